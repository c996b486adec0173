"""A reduced model for tests that need wheels in name only: about the size of nh_mini."""

from nhtrack.robots.diff_drive import DiffDrive, Motor

DRIVE = DiffDrive(
    wheel_radius=0.016,
    half_separation=0.043,
    mass=0.3,
    axle_inertia=3e-4,
    wheel_inertia=2e-6,
    com=(-0.01, 0.0, 0.02),
    casters=((-0.04, 0.0),),
    motor=Motor(torque_limit=0.03, stall_torque=0.05, no_load_speed=60.0),
)
