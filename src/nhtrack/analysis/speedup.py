"""How much faster a motion on the ideal model could be before wheels, motors or floor are asked for too much.

A motion sped up by the factor s (s < 1 is slower) keeps its shape: its time scale is divided by s. Accelerations
and products of velocities scale with s^2, velocities with s (docs/theory.md, similarity); robot, gravity and the
place do not scale. So, for every wheel and instant, with what is asked for at rest marked 0 (on a slope, gravity),

    friction   |D_0 + s^2 D| <= mu_m (N_0 + s^2 N)       D: force on the floor, N: load
    speed      |w| s <= w_0                              w: wheel speed, w_0: no-load speed
    torque     |tau_0 + s d w + s^2 tau| <= tau_max      and, on the motor's line, either sign
               +-(tau_0 + s d w + s^2 tau) <= tau_s (1 -+ s w/w_0)   tau_s: stall torque

where viscous friction of the wheel joints, d w, grows with s, and their dry friction, which does not, is in tau_0;
with mu_m the margin times the friction coefficient. Each of these holds up to one largest s, the root of a quadratic;
the smallest of them over wheels and instants is the factor by which the motion may be sped up.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nhtrack.analysis.motion import WHEELS, IdealMotion, Rates, motion_of, robots_with_wheels
from nhtrack.arrays import Array
from nhtrack.experiment.build import Experiment
from nhtrack.experiment.loop import Rollout
from nhtrack.ground import Gravity, Ground
from nhtrack.robots.diff_drive import DiffDrive

LIMITS = ("friction", "wheel speed", "wheel torque")  # in the order of `largest_factors`
_MOSTLY = 0.5  # of the motor's line


def largest_factors(motion: IdealMotion, drive: DiffDrive, ground: Ground) -> Array:
    """Returns the largest s at which each limit holds, the module's equations, shape (3, k, ..., n, 2).

    Args:
        motion: in robot units.
        drive: the robots' reduced model.
        ground: what they stand on, its friction the share that may be used (`Ground.scaled`).
    """
    speed = drive.wheel_speeds(motion.v, motion.omega)
    with np.errstate(divide="ignore", over="ignore"):  # next to nothing asked for
        return np.stack(
            [
                np.sqrt(_friction_factor(motion, drive, ground)),
                np.where(speed == 0, np.inf, drive.motor.no_load_speed / np.abs(speed)),
                _torque_factor(motion, drive, ground, speed),
            ]
        )


def _friction_factor(motion: IdealMotion, drive: DiffDrive, ground: Ground) -> Array:
    """Returns the largest s^2 at which every wheel holds, shape (k, ..., n, 2)."""
    gravity = ground.gravity_at(motion.g[..., 2])
    (x_0, y_0), (x, y) = (_wheel_forces(drive, rates, gravity) for rates in (motion.at_rest, motion.rates))
    load_0 = drive.wheel_loads(*motion.at_rest, gravity)
    load = drive.wheel_loads(*motion.rates, gravity) - load_0
    x, y, square = x - x_0, y - y_0, ground.friction_at(drive.wheel_places(motion.g)) ** 2
    return _crossing(
        x * x + y * y - square * load * load,
        2 * (x * x_0 + y * y_0 - square * load * load_0),
        x_0 * x_0 + y_0 * y_0 - square * load_0 * load_0,
    )


def _wheel_forces(drive: DiffDrive, rates: Rates, gravity: Gravity) -> tuple[Array, Array]:
    """Returns the forces along and across that each wheel asks of the floor [N], shapes (..., 2) and (..., 1)."""
    f_x, f_y, tau = drive.ground_wrench(*rates, gravity)
    moment = tau / drive.half_separation
    return np.stack([f_x - moment, f_x + moment], axis=-1) / 2, f_y[..., None] / 2


def _torque_factor(motion: IdealMotion, drive: DiffDrive, ground: Ground, speed: Array) -> Array:
    """Returns the largest s at which every motor gives what it is asked for, shape (k, ..., n, 2)."""
    motor, gravity = drive.motor, ground.gravity_at(motion.g[..., 2])
    at_rest = drive.wheel_torques(*motion.at_rest, gravity)
    viscous = drive.losses.viscous(speed)
    dry = drive.losses.dry(speed, drive.wheel_speeds(motion.u_x, motion.u_theta))
    torque = drive.wheel_torques(*motion.rates, gravity) - at_rest - viscous - dry
    at_rest = at_rest + dry
    back_voltage = motor.slope * speed
    factors = [
        _crossing(sign * torque, slope + sign * viscous, sign * at_rest - limit)
        for sign in (1, -1)
        for slope, limit in ((0.0 * speed, motor.torque_limit), (sign * back_voltage, motor.stall_torque))
    ]
    # A motor that is asked for nothing is limited by its speed alone.
    idle = (torque == 0) & (at_rest == 0) & (viscous == 0)
    return np.where(idle, np.inf, np.min(factors, axis=0))


def _crossing(a: Array, b: Array, c: Array) -> Array:
    """Returns the smallest s >= 0 beyond which a s^2 + b s + c > 0, infinite where there is none."""
    with np.errstate(invalid="ignore", divide="ignore"):
        below = b + np.sqrt(b * b - 4 * a * c)
        root = np.where(below > 0, -2 * c / below, np.inf)
    rising = (b > 0) | ((b == 0) & (a > 0))
    limited = np.where(c < 0, root, np.where((c > 0) | rising, 0.0, np.inf))
    return np.where(np.isneginf(c), np.inf, limited)  # of a motor without limit


@dataclass(frozen=True)
class Binding:
    """The limit a robot meets first when its motion is sped up.

    Attributes:
        robot: its name.
        factor: largest s at which it fits; below 1 it does not fit now.
        limit: one of `LIMITS`.
        wheel: `left` or `right`.
        time: when, on the robot's clock [s].
    """

    robot: str
    factor: float
    limit: str
    wheel: str
    time: float


def bindings(experiment: Experiment, run: Rollout, drive: DiffDrive, ground: Ground) -> tuple[Binding, ...]:
    """Returns the limit that each robot of an ideal run meets first; `ground` as in `largest_factors`."""
    found = []
    for name, i in robots_with_wheels(experiment).items():
        found.append(binding_of(name, motion_of(run, i), drive, ground))
    return tuple(found)


def binding_of(robot: str, motion: IdealMotion, drive: DiffDrive, ground: Ground) -> Binding:
    """Returns the limit that a robot of one motion meets first; `ground` as in `largest_factors`."""
    return min((_binding_of(robot, piece, drive, ground) for piece in motion.blocks()), key=lambda each: each.factor)


def _binding_of(robot: str, motion: IdealMotion, drive: DiffDrive, ground: Ground) -> Binding:
    factors = largest_factors(motion, drive, ground)
    limit, row, wheel = np.unravel_index(factors.argmin(), factors.shape)
    factor, name = float(factors[limit, row, wheel]), LIMITS[limit]
    if name == "wheel torque":
        speed = factor * abs(drive.wheel_speeds(motion.v[row], motion.omega[row])[wheel])
        if speed > _MOSTLY * drive.motor.no_load_speed:
            name = "wheel speed"  # which has used up the motor's line
    return Binding(robot, factor, name, WHEELS[wheel], float(motion.time[row]))
