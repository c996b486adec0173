"""What a motion on the ideal model asks of wheels, motors and floor, and what that means on wheels."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from nhtrack.analysis.motion import WHEELS, IdealMotion, motion_of, robots_with_wheels, root_motion
from nhtrack.analysis.speedup import Binding, binding_of, bindings
from nhtrack.arrays import Array
from nhtrack.config.scenario import Scenario
from nhtrack.experiment.build import Experiment
from nhtrack.experiment.loop import Rollout
from nhtrack.ground import Ground
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.robots.motor import Motor
from nhtrack.similarity import rounded_up

_ROUNDING = 1e-9  # over a limit that counts as at it


@dataclass(frozen=True)
class PeakDemand:
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


def demands(experiment: Experiment, run: Rollout, drive: DiffDrive, ground: Ground) -> tuple[PeakDemand, ...]:
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
        for demand in demands_of(name, motion_of(run, i), drive, ground)
    )


def demands_of(robot: str, motion: IdealMotion, drive: DiffDrive, ground: Ground) -> list[PeakDemand]:
    """Returns the most that a motion asks of a robot, quantity by quantity; arguments as in `demands`."""
    pieces = [_demands_of(robot, piece, drive, ground) for piece in motion.blocks()]
    return [max(those, key=_size) for those in zip(*pieces, strict=True)]


def _size(demand: PeakDemand) -> float:
    return demand.value if demand.share is None else demand.share


def _demands_of(robot: str, motion: IdealMotion, drive: DiffDrive, ground: Ground) -> list[PeakDemand]:
    found = []
    for quantity, values, unit in (
        ("forward_acceleration", np.abs(motion.u_x), "m/s^2"),
        ("yaw_acceleration", np.abs(motion.u_theta), "rad/s^2"),
    ):
        row = int(values.argmax())
        found.append(PeakDemand(robot, quantity, float(values[row]), unit, None, None, float(motion.time[row])))
    for quantity, unit, use in wheel_uses(motion, drive, ground):
        at = np.unravel_index(use.share.argmax(), use.share.shape)
        value, limit, share = (float(np.broadcast_to(values, use.share.shape)[at]) for values in use)
        found.append(PeakDemand(robot, quantity, value, unit, limit, share, float(motion.time[at[0]]), WHEELS[at[1]]))
    return found


class Use(NamedTuple):
    """What wheels are asked for, what there is, and the share of it, each of shape (k, ..., n, 2) or broadcasting."""

    value: Array
    limit: Array
    share: Array


def wheel_uses(motion: IdealMotion, drive: DiffDrive, ground: Ground) -> tuple[tuple[str, str, Use], ...]:
    """Returns what the wheels of a motion are asked for, each with its quantity and unit.

    A wheel that the motion would lift has a load below zero and uses more than all of it.
    """
    gravity = ground.gravity_at(motion.g[..., 2])
    utilisation = drive.predicted_utilisation(ground, motion.g, *motion.rates)
    load, at_rest = (drive.wheel_loads(*rates, gravity) for rates in (motion.rates, motion.at_rest))
    torque, speed = drive.wheel_torques(*motion.rates, gravity), drive.wheel_speeds(motion.v, motion.omega)
    fast, strong = _motor_uses(drive.motor, torque, speed)
    return (
        ("friction_utilisation", "1", Use(utilisation, np.array(1.0), utilisation)),
        ("wheel_speed", "rad/s", fast),
        ("wheel_torque", "N m", strong),
        ("wheel_load", "N", Use(load, np.array(0.0), 1 - load / at_rest)),
    )


def _motor_uses(motor: Motor, torque: Array, speed: Array) -> tuple[Use, Use]:
    """Returns what motors are asked for of speed and of torque.

    A motor that drives stays below its line, |tau|/tau_s + |w|/w_0 <= 1. What is used of the line is told of the larger
    of the two terms, with the limit at which the line would end if both grew alike; the other is held against the
    no-load speed, or the driver's torque, alone.
    """
    of_speed, of_torque = np.abs(speed) / motor.no_load_speed, np.abs(torque) / motor.stall_torque
    line = np.where(torque * speed > 0, of_torque + of_speed, of_torque)
    turning = (of_speed > of_torque) & (torque * speed > 0)
    fast = np.where(turning, line, of_speed)
    strong = np.maximum(np.abs(torque) / motor.torque_limit, np.where(turning, 0.0, line))
    return _proportional(speed, fast, motor.no_load_speed), _proportional(torque, strong, motor.torque_limit)


def _proportional(values: Array, share: Array, otherwise: float) -> Use:
    """Returns the use of values of which a share is told; where nothing is asked for, of a limit."""
    size = np.abs(values)
    with np.errstate(invalid="ignore", divide="ignore"):
        return Use(size, np.where(share > 0, size / share, otherwise), share)


def predictions(scenario: Scenario, experiment: Experiment, run: Rollout, drive: DiffDrive) -> tuple[str, ...]:
    """Returns what an ideal run says will go wrong on wheels, in sentences, with the time scale that would fit."""
    if len(run.time) < 2:
        return ()
    ground = experiment.scene.ground
    wanted = demands(experiment, run, drive, ground)
    return _too_much(wanted, bindings(experiment, run, drive, _kept(ground, scenario)), scenario)


def root_predictions(scenario: Scenario, experiment: Experiment) -> tuple[str, ...]:
    """Returns what will go wrong on wheels with a robot that moves as the root is to, as `predictions`; without a run.

    A root that is a marker is not bound by wheels, but a follower that is exactly in its place is.
    """
    leader, drive, ground = scenario.leader, experiment.robot.plant, experiment.scene.ground
    robot = f"a robot in the place of {leader.name}" if leader.virtual else leader.name
    motion = root_motion(experiment)
    wanted = demands_of(robot, motion, drive, ground)
    return _too_much(wanted, [binding_of(robot, motion, drive, _kept(ground, scenario))], scenario)


def _kept(ground: Ground, scenario: Scenario) -> Ground:
    return ground.scaled(scenario.similarity.friction_margin)


def _too_much(wanted: Iterable[PeakDemand], bound: Iterable[Binding], scenario: Scenario) -> tuple[str, ...]:
    """Returns which demands are over their limits, in sentences, with the time scale that would fit."""
    worst = min(binding.factor for binding in bound)
    remedy = "no similarity.time would fit"
    if worst > 0:
        remedy = f"similarity.time {rounded_up(scenario.similarity.time_scale / worst):g} would fit"
    return tuple(f"{_fault(demand)}; {remedy}" for demand in wanted if _is_over(demand))


def _is_over(demand: PeakDemand) -> bool:
    return demand.share is not None and demand.share > 1 + _ROUNDING


def _fault(demand: PeakDemand) -> str:
    wheel, when = f"its {demand.wheel} wheel", f"at {demand.time:.3g} s"
    match demand.quantity:
        case "friction_utilisation" if math.isinf(demand.value):
            return f"{demand.robot} is predicted to slip: {wheel} needs friction {when} and there is none"
        case "friction_utilisation":
            times = f"{_apart(demand.value, 1)[0]} times the friction there is"
            return f"{demand.robot} is predicted to slip: {wheel} needs {times} {when}"
        case "wheel_load":
            return f"{demand.robot} is predicted to lift {wheel} {when}"
        case quantity:
            asked = f"{' of '.join(_apart(demand.value, demand.limit or 0.0))} {demand.unit}"
            what = quantity.removeprefix("wheel_")
            return f"{demand.robot} is predicted to exceed its motors' limits: {what} of {wheel} {when}, {asked}"


def _apart(value: float, limit: float) -> tuple[str, str]:
    """Returns two numbers as texts with three digits, or as many as tell them apart."""
    pairs = ((f"{value:.{digits}g}", f"{limit:.{digits}g}") for digits in range(3, 17))
    return next((pair for pair in pairs if pair[0] != pair[1]), (f"{value:.3g}", f"{limit:.3g}"))
