"""Says what is read from a robot's file, and how fast it may be driven."""

import nhtrack

robot = nhtrack.inspect("burger", friction=0.8)
print(f"{robot.drive.mass:g} kg on wheels of {1000 * robot.drive.wheel_radius:g} mm")
print(f"at most {robot.limits.speed:.2g} m/s and {robot.limits.yaw_rate:.2g} rad/s")
for row in robot.rows[:3]:
    print(row)
print("its left tyre is", robot.reading.sources["left tyre"])
robot.save_figure("burger.png")  # from above and from the side
