"""What a motion on the ideal model asks of wheels, motors and floor, and how much faster it could be.

A motion sped up by the factor s (s < 1 is slower) keeps its shape: its time scale is divided by s. Accelerations
and products of velocities scale with s^2, velocities with s (docs/theory.md, similarity); robot, gravity and the
place do not scale. So, for every wheel and instant, with what is asked for at rest marked 0 (on a slope, gravity),

    friction   |D_0 + s^2 D| <= mu_m (N_0 + s^2 N)       D: force on the floor, N: load
    speed      |w| s <= w_0                              w: wheel speed, w_0: no-load speed
    torque     |tau_0 + s^2 tau| <= tau_max              and, on the motor's line, either sign
               +-(tau_0 + s^2 tau) <= tau_s (1 -+ s w/w_0)   tau_s: stall torque

with mu_m the margin times the friction coefficient. Each of these holds up to one largest s, the root of a quadratic;
the smallest of them over wheels and instants is the factor by which the motion may be sped up.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from nhtrack.arrays import Array
from nhtrack.config.scenario import Scenario
from nhtrack.experiment.build import Experiment
from nhtrack.experiment.loop import Rollout
from nhtrack.ground import Gravity, Ground
from nhtrack.robots.diff_drive import DiffDrive

WHEELS = ("left", "right")
LIMITS = ("friction", "wheel speed", "wheel torque")  # in the order of `largest_factors`
_DIGITS = 4  # of a time scale; friction goes with its square and is then used to within 0.2 % of the margin


Rates: TypeAlias = tuple[Array, Array, Array, Array]


class Motion(NamedTuple):
    """Motion of n robots at the start and at the end of every control period, between which it changes linearly.

    Attributes:
        time: [s], shape (k,), two rows a period.
        g: poses, shape (k, ..., n, 3).
        v: forward velocities [m/s], shape (k, ..., n), and so the others.
        omega: yaw rates [rad/s].
        u_x: forward accelerations [m/s^2].
        u_theta: yaw accelerations [rad/s^2].
    """

    time: Array
    g: Array
    v: Array
    omega: Array
    u_x: Array
    u_theta: Array

    @property
    def rates(self) -> Rates:
        """v, omega, u_x, u_theta: what the reduced model's functions take."""
        return self.v, self.omega, self.u_x, self.u_theta

    @property
    def at_rest(self) -> Rates:
        """The same for robots that stand."""
        zero = np.zeros_like(self.v)
        return zero, zero, zero, zero


def motion_of(run: Rollout, robots: Any = slice(None)) -> Motion:
    """Returns the motion of a run on the ideal model, of the chosen robots (indices or a slice).

    Of a run with a row every so many periods, the motion at the start of those periods only.
    """
    if run.every > 1:
        pose, twist, u = (run.variables[name][:-1][..., robots, :] for name in ("pose", "twist", "input"))
        return Motion(run.time[:-1], pose, twist[..., 0], twist[..., 2], u[..., 0], u[..., 1])
    pose, twist = (_ends(run.variables[name][..., robots, :]) for name in ("pose", "twist"))
    u = np.repeat(run.variables["input"][:-1][..., robots, :], 2, axis=0)
    return Motion(_ends(run.time), pose, twist[..., 0], twist[..., 2], u[..., 0], u[..., 1])


def _ends(values: Array) -> Array:
    """Returns the rows at the start and at the end of every period, shape (t, ...) -> (2 (t - 1), ...)."""
    return np.stack([values[:-1], values[1:]], axis=1).reshape(-1, *values.shape[1:])


def largest_factors(motion: Motion, drive: DiffDrive, ground: Ground) -> Array:
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


def _friction_factor(motion: Motion, drive: DiffDrive, ground: Ground) -> Array:
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


def _torque_factor(motion: Motion, drive: DiffDrive, ground: Ground, speed: Array) -> Array:
    """Returns the largest s at which every motor gives what it is asked for, shape (k, ..., n, 2)."""
    motor, gravity = drive.motor, ground.gravity_at(motion.g[..., 2])
    at_rest = drive.wheel_torques(*motion.at_rest, gravity)
    torque = drive.wheel_torques(*motion.rates, gravity) - at_rest
    back_voltage = motor.stall_torque * speed / motor.no_load_speed
    factors = [
        _crossing(sign * torque, slope, sign * at_rest - limit)
        for sign in (1, -1)
        for slope, limit in ((0.0 * speed, motor.torque_limit), (sign * back_voltage, motor.stall_torque))
    ]
    idle = (torque == 0) & (at_rest == 0)  # a motor that is asked for nothing is limited by its speed alone
    return np.where(idle, np.inf, np.min(factors, axis=0))


def _crossing(a: Array, b: Array, c: Array) -> Array:
    """Returns the smallest s >= 0 beyond which a s^2 + b s + c > 0, infinite where there is none."""
    with np.errstate(invalid="ignore", divide="ignore"):
        below = b + np.sqrt(b * b - 4 * a * c)
        root = np.where(below > 0, -2 * c / below, np.inf)
    rising = (b > 0) | ((b == 0) & (a > 0))
    return np.where(c < 0, root, np.where((c > 0) | rising, 0.0, np.inf))


def torque_limits(drive: DiffDrive, torque: Array, speed: Array) -> Array:
    """Returns the torque [N m] a motor can give in the direction of `torque` at `speed` [rad/s]; not below zero."""
    motor = drive.motor
    line = motor.stall_torque * (1 - np.sign(torque) * speed / motor.no_load_speed)
    return np.clip(line, 0.0, motor.torque_limit)


@dataclass(frozen=True)
class Demand:
    """The most a robot's motion asks of one quantity.

    Attributes:
        robot: its name.
        quantity: what is asked for, such as `wheel_torque`.
        value: how much, in `unit`, at the moment when the share is largest.
        unit: of value and limit.
        limit: what there is at that moment, or None where nothing limits the quantity itself.
        share: how much of what there is; more than 1 does not fit. None where there is no limit.
        time: when, on the robot's clock [s].
        wheel: `left` or `right`, or None for the robot as a whole.
    """

    robot: str
    quantity: str
    value: float
    unit: str
    limit: float | None
    share: float | None
    time: float
    wheel: str | None = None


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


def robots_with_wheels(experiment: Experiment) -> dict[str, int]:
    """Returns the index of every robot that has a body, by name: all but a virtual leader."""
    return {name: i for i, name in enumerate(experiment.network.names) if name in experiment.scene.bodies}


def bindings(experiment: Experiment, run: Rollout, drive: DiffDrive, ground: Ground) -> tuple[Binding, ...]:
    """Returns the limit that each robot of an ideal run meets first; `ground` as in `largest_factors`."""
    found = []
    for name, i in robots_with_wheels(experiment).items():
        motion = motion_of(run, i)
        factors = largest_factors(motion, drive, ground)
        limit, row, wheel = np.unravel_index(factors.argmin(), factors.shape)
        factor = float(factors[limit, row, wheel])
        found.append(Binding(name, factor, LIMITS[limit], WHEELS[wheel], float(motion.time[row])))
    return tuple(found)


def demands(experiment: Experiment, run: Rollout, drive: DiffDrive, ground: Ground) -> tuple[Demand, ...]:
    """Returns the most that each robot of an ideal run asks for, quantity by quantity.

    Args:
        experiment: what was run.
        run: its rollout on the ideal model.
        drive: the robots' reduced model.
        ground: what they stand on.
    """
    return tuple(
        demand
        for name, i in robots_with_wheels(experiment).items()
        for demand in _demands_of(name, motion_of(run, i), drive, ground)
    )


def _demands_of(robot: str, motion: Motion, drive: DiffDrive, ground: Ground) -> list[Demand]:
    found = []
    for quantity, values, unit in (
        ("forward_acceleration", np.abs(motion.u_x), "m/s^2"),
        ("yaw_acceleration", np.abs(motion.u_theta), "rad/s^2"),
    ):
        row = int(values.argmax())
        found.append(Demand(robot, quantity, float(values[row]), unit, None, None, float(motion.time[row])))
    for quantity, unit, use in wheel_uses(motion, drive, ground):
        at = np.unravel_index(use.share.argmax(), use.share.shape)
        value, limit, share = (float(np.broadcast_to(values, use.share.shape)[at]) for values in use)
        found.append(Demand(robot, quantity, value, unit, limit, share, float(motion.time[at[0]]), WHEELS[at[1]]))
    return found


class Use(NamedTuple):
    """What wheels are asked for, what there is, and the share of it, each of shape (k, ..., n, 2) or broadcasting."""

    value: Array
    limit: Array
    share: Array


def wheel_uses(motion: Motion, drive: DiffDrive, ground: Ground) -> tuple[tuple[str, str, Use], ...]:
    """Returns what the wheels of a motion are asked for, each with its quantity and unit.

    A wheel that the motion would lift has a load below zero and uses more than all of it.
    """
    gravity, friction = ground.gravity_at(motion.g[..., 2]), ground.friction_at(drive.wheel_places(motion.g))
    utilisation = drive.friction_utilisation(*motion.rates, friction, gravity)
    load, at_rest = (drive.wheel_loads(*rates, gravity) for rates in (motion.rates, motion.at_rest))
    torque, speed = drive.wheel_torques(*motion.rates, gravity), drive.wheel_speeds(motion.v, motion.omega)
    available = torque_limits(drive, torque, speed)
    with np.errstate(divide="ignore", invalid="ignore"):
        torque_share = np.where(torque == 0, 0.0, np.abs(torque) / available)
    no_load = drive.motor.no_load_speed
    return (
        ("friction_utilisation", "1", Use(utilisation, np.array(1.0), utilisation)),
        ("wheel_speed", "rad/s", Use(np.abs(speed), np.array(no_load), np.abs(speed) / no_load)),
        ("wheel_torque", "N m", Use(np.abs(torque), available, torque_share)),
        ("wheel_load", "N", Use(load, np.array(0.0), 1 - load / at_rest)),
    )


def predictions(scenario: Scenario, experiment: Experiment, run: Rollout, drive: DiffDrive) -> tuple[str, ...]:
    """Returns what an ideal run says will go wrong on wheels, in sentences, with the time scale that would fit."""
    if len(run.time) < 2:
        return ()
    ground, similarity = experiment.scene.ground, scenario.similarity
    faults = [_fault(demand) for demand in demands(experiment, run, drive, ground) if _is_over(demand)]
    within = ground.scaled(similarity.friction_margin)
    worst = min(binding.factor for binding in bindings(experiment, run, drive, within))
    remedy = "no similarity.time would fit"
    if worst > 0:
        remedy = f"similarity.time {rounded_up(similarity.time_scale / worst):g} would fit"
    return tuple(f"{fault}; {remedy}" for fault in faults)


def _is_over(demand: Demand) -> bool:
    return demand.share is not None and demand.share > 1


def _fault(demand: Demand) -> str:
    wheel, when = f"its {demand.wheel} wheel", f"at {demand.time:.3g} s"
    match demand.quantity:
        case "friction_utilisation" if math.isinf(demand.value):
            return f"{demand.robot} is predicted to slip: {wheel} needs friction {when} and there is none"
        case "friction_utilisation":
            times = f"{demand.value:.3g} times the friction there is"
            return f"{demand.robot} is predicted to slip: {wheel} needs {times} {when}"
        case "wheel_load":
            return f"{demand.robot} is predicted to lift {wheel} {when}"
        case quantity:
            asked = f"{demand.value:.3g} of {demand.limit:.3g} {demand.unit}"
            what = quantity.removeprefix("wheel_")
            return f"{demand.robot} is predicted to exceed its motors' limits: {what} of {wheel} {when}, {asked}"


def rounded_up(value: float) -> float:
    """Returns the smallest number of four significant digits that is not below a positive value."""
    nearest = float(f"{value:.{_DIGITS}g}")
    if nearest >= value:
        return nearest
    step = 10.0 ** (math.floor(math.log10(value)) - _DIGITS + 1)
    return float(f"{nearest + step:.{_DIGITS}g}")
