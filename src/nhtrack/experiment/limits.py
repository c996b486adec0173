"""The motions within which a robot's wheels neither slip nor ask too much of their motors."""

from __future__ import annotations

from dataclasses import replace
from math import isfinite, pi, sqrt

import numpy as np

from nhtrack.errors import FeasibilityError
from nhtrack.ground import GRAVITY, Ground
from nhtrack.laws import Limits
from nhtrack.robots.diff_drive import DiffDrive

_RATES = 33  # samples of the yaw rate, in which the demand is not linear
_HEADINGS = 32  # samples of the heading on a slope
_BISECTIONS = 40
_TRACTION = 0.5  # of the grip, left to either acceleration, against the lateral one
_AGILE, _SLOWER = 1.0, 8  # [rad/s] that a robot should be able to turn at; how often it is made slower for that
_SPEED = 0.5  # of the largest speed that motors hold, beyond which they have little torque left


def motion_limits(drive: DiffDrive, ground: Ground, utilisation: float, speed: float | None = None) -> Limits:
    """Returns limits within which the predicted utilisation stays below a share and no motor clips.

    At a speed v and a grip A [m/s^2] they are `|omega| <= A/v`, `|u_x| <= A/2`, `|u_theta| <= A/(2 b)`, for the largest
    A with which all of the box fits.

    Args:
        drive: the robot's reduced model.
        ground: what it stands on; the smallest friction of its patches counts everywhere.
        utilisation: share of the friction that may be used, in (0, 1].
        speed: largest speed [m/s]; half of what the motors hold straight on by default, and where that is not limited,
            that at which a turn about one wheel takes friction 1, sqrt(g b).

    Raises:
        FeasibilityError: straight on at that speed is already too much for ground or motors.
    """
    v = _usual_speed(drive) if speed is None else speed
    if v == 0:
        raise FeasibilityError("the wheels cannot turn: dry friction at their joints takes all of the motors' torque")
    friction = min([ground.friction, *(patch.friction for patch in ground.patches)])
    everywhere = replace(ground, friction=friction, patches=())

    def fits(grip: float) -> bool:
        return _fits(drive, everywhere, utilisation, (v, *_rates(drive, v, grip)))

    least, most = 1e-3 * GRAVITY, max(friction, 1e-3) * GRAVITY
    if not fits(least):
        raise FeasibilityError(_no_room(drive, everywhere, utilisation, (v, *_rates(drive, v, least))))
    for _ in range(_BISECTIONS):
        middle = (least + most) / 2
        least, most = (middle, most) if fits(middle) else (least, middle)
    return Limits(v, *_rates(drive, v, least))


def agile_limits(drive: DiffDrive, ground: Ground, utilisation: float) -> Limits:
    """Returns `motion_limits` at the largest of some speeds at which a robot turns by a radian a second.

    Large robots and those that are fast have grip for wide turns only at the speed that is usual for them.

    Raises:
        FeasibilityError: it cannot move, however slowly.
    """
    limits = motion_limits(drive, ground, utilisation)
    for _ in range(_SLOWER):
        if limits.yaw_rate >= _AGILE:
            break
        limits = motion_limits(drive, ground, utilisation, limits.speed / sqrt(2))
    return limits


def _usual_speed(drive: DiffDrive) -> float:
    free = _SPEED * drive.top_speed
    return free if isfinite(free) else sqrt(GRAVITY * drive.half_separation)


def _rates(drive: DiffDrive, v: float, grip: float) -> tuple[float, float, float]:
    """Returns the largest yaw rate, acceleration and yaw acceleration of a grip."""
    return grip / v, _TRACTION * grip, _TRACTION * grip / drive.half_separation


def _fits(drive: DiffDrive, ground: Ground, utilisation: float, limits: tuple[float, float, float, float]) -> bool:
    """Returns whether all motions within limits (v, omega, u_x, u_theta) keep their wheels and motors."""
    used, held = _asked(drive, ground, limits)
    return used <= utilisation and held


def _asked(drive: DiffDrive, ground: Ground, limits: tuple[float, float, float, float]) -> tuple[float, bool]:
    """Returns the largest utilisation of the motions within limits, and whether motors give all their torques.

    At one yaw rate and heading, torques are linear and utilisation is quasiconvex in (v, u_x, u_theta), so the corners
    decide, of which losses at the wheel joints ask most, too; yaw rates and headings are sampled.
    """
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
    poses = np.stack([np.zeros_like(theta), np.zeros_like(theta), theta], axis=-1)
    used = drive.predicted_utilisation(ground, poses, v, omega, u_x, u_theta)
    torque = drive.wheel_torques(v, omega, u_x, u_theta, gravity)
    held = drive.motor.saturate(torque, drive.wheel_speeds(v, omega))
    return float(used.max()), bool((held == torque).all())


def _no_room(
    drive: DiffDrive, ground: Ground, utilisation: float, limits: tuple[float, float, float, float]
) -> str:
    """Returns why not even these limits, next to none, fit, and what would make them fit."""
    asked, _ = _asked(drive, replace(ground, friction=1.0), limits)
    none = f"at {limits[0]:.3g} m/s no turn and no acceleration, however small, fits"
    if asked > utilisation * ground.friction:
        enough = f"{asked / utilisation:.3g} would do"
        if ground.friction == 0:
            return f"{none} a floor without friction; {enough}"
        return (
            f"{none} the floor: wheels ask for {asked / ground.friction:.3g} times its friction {ground.friction:g}, "
            f"of which the share {utilisation:g} may be used; {enough}"
        )
    return f"{none} the motors; a lower speed than that asks them for less"
