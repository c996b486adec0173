"""Motions that ask neither too much grip nor too much of the motors, as arrays: kept as second implementation."""

from __future__ import annotations

from math import pi

import numpy as np

from nhtrack.errors import FeasibilityError
from nhtrack.ground import GRAVITY, Ground
from nhtrack.robots.diff_drive import DiffDrive
from reference.laws import Limits

_RATES = 33  # samples of the yaw rate, in which the demand is not linear
_HEADINGS = 32  # samples of the heading on a slope
_BISECTIONS = 40
_TRACTION = 0.5  # of the grip, left to either acceleration, against the lateral one
_SPEED = 0.5  # of the wheels' speed without load, beyond which motors have little torque left


def motion_limits(drive: DiffDrive, ground: Ground, utilisation: float, speed: float | None = None) -> Limits:
    """Returns limits within which the predicted utilisation stays below a share and no motor clips."""
    v = _SPEED * drive.top_speed if speed is None else speed
    friction = min([ground.friction, *(patch.friction for patch in ground.patches)])

    def fits(grip: float) -> bool:
        return _fits(drive, ground, friction, utilisation, (v, *_rates(drive, v, grip)))

    least, most = 1e-3 * GRAVITY, max(friction, 1e-3) * GRAVITY
    if not fits(least):
        raise FeasibilityError(f"at {v:.3g} m/s no turn and no acceleration, however small, fits ground and motors")
    for _ in range(_BISECTIONS):
        middle = (least + most) / 2
        least, most = (middle, most) if fits(middle) else (least, middle)
    return Limits(v, *_rates(drive, v, least))


def _rates(drive: DiffDrive, v: float, grip: float) -> tuple[float, float, float]:
    """Returns the largest yaw rate, acceleration and yaw acceleration of a grip."""
    return grip / v, _TRACTION * grip, _TRACTION * grip / drive.half_separation


def _fits(
    drive: DiffDrive, ground: Ground, friction: float, utilisation: float, limits: tuple[float, float, float, float]
) -> bool:
    """Returns whether all motions within limits (v, omega, u_x, u_theta) keep their wheels and motors."""
    largest_v, largest_omega, largest_u_x, largest_u_theta = limits
    ends = np.array([-1.0, 1.0])
    headings = np.linspace(-pi, pi, _HEADINGS) if ground.slope else np.zeros(1)
    v, omega, u_x, u_theta, theta = np.meshgrid(
        largest_v * ends,
        largest_omega * np.linspace(-1, 1, _RATES),
        largest_u_x * ends,
        largest_u_theta * ends,
        headings,
    )
    gravity = ground.gravity_at(theta)
    used = drive.friction_utilisation(v, omega, u_x, u_theta, friction, gravity)
    torque = drive.wheel_torques(v, omega, u_x, u_theta, gravity)
    held = drive.motor.saturate(torque, drive.wheel_speeds(v, omega))
    return bool((used <= utilisation).all() and (held == torque).all())
