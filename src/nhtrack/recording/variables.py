"""What a recording holds of every robot at every time: names, components, units and meanings."""

from __future__ import annotations

from dataclasses import dataclass

# 2: the scene's physical effects stand by their keys; 3: checksums; 4: these go on from rows to attributes
FORMAT_VERSION = 4

COMPONENTS: dict[str, tuple[str, ...]] = {
    "pose_component": ("x", "y", "theta"),
    "twist_component": ("v_x", "v_y", "omega"),
    "input_component": ("u_x", "u_theta"),
    "wheel": ("left", "right"),
    "touch_component": ("partner", "time", "impulse", "closing_speed", "overlap"),
}


@dataclass(frozen=True)
class Variable:
    """A recorded quantity: its dimensions after (time, robot), its unit, and what it means."""

    dims: tuple[str, ...]
    units: str
    long_name: str


_POSE, _TWIST, _INPUT, _WHEEL = (("pose_component",), ("twist_component",), ("input_component",), ("wheel",))

VARIABLES: dict[str, Variable] = {
    "pose": Variable(
        _POSE, "m, m, rad", "pose of the axle midpoint in the world, heading unwrapped"),
    "twist": Variable(
        _TWIST, "m/s, m/s, rad/s", "body twist of the axle midpoint"),
    "input": Variable(
        _INPUT, "m/s^2, rad/s^2", "commanded accelerations, held over the period that begins at this time"),
    "leader_pose": Variable(
        _POSE, "m, m, rad", "pose each follower was told to track (NaN for the root)"),
    "leader_twist": Variable(
        _TWIST, "m/s, m/s, rad/s", "twist each follower was told to track (NaN for the root)"),
    "error": Variable(
        _POSE, "m, m, rad",
        "follower's pose seen from what it tracks, heading taken to (-pi, pi] (NaN for the root)"),
    "ideal_pose": Variable(
        _POSE, "m, m, rad", "pose of the ideal twin: same scenario and sampled law on the ideal integrator"),
    "wheel_torque": Variable(
        _WHEEL, "N m",
        "torque of the wheel motors, after limits, mean over the period that ends at this time"),
    "wheel_torque_demand": Variable(
        _WHEEL, "N m",
        "torque the compensation asked for before limits, of largest magnitude in that period"),
    "torque_saturation": Variable(
        _WHEEL, "1", "share of the period that ends at this time in which the motor's limits cut the torque asked for"
    ),
    "wheel_speed": Variable(
        _WHEEL, "rad/s", "spin of the wheels relative to the chassis"),
    "wheel_load": Variable(
        _WHEEL, "N", "normal force between wheel and floor, mean over the period that ends at this time"),
    "longitudinal_slip": Variable(
        _WHEEL, "m/s", "rolling-direction velocity of the contact point, v_x -+ b omega - r wheel_speed"),
    "lateral_slip": Variable(
        (), "m/s", "sideways velocity of the axle, v_y"),
    "friction_utilisation": Variable(
        _WHEEL, "1", "hypot(f_long, f_lat)/(mu N), largest in the period that ends at this time"),
    "friction_utilisation_predicted": Variable(
        _WHEEL, "1", "the same from the reduced model with quasi-static loads"),
    "tilt": Variable(
        (), "rad", "angle between the robot's vertical axis and the world's"),
    "wheel_clearance": Variable(
        _WHEEL, "m", "height of the wheels' lowest points above the floor"),
    "touch": Variable(
        ("touch", "touch_component"), "1, s, N s, m/s, m",
        "robots touched since the row before, each pair with one of the two (NaN where there is none): place of the "
        "other, time in contact, impulse of the normal forces, largest closing speed, largest overlap of the hulls"),
}  # fmt: skip
