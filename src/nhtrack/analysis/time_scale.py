"""The time scale at which a scenario fits its robots, found from motions on the ideal model."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, TypeVar

from nhtrack.analysis.motion import root_motion
from nhtrack.analysis.speedup import Binding, binding_of
from nhtrack.config.campaign import Campaign
from nhtrack.config.checks import MOST_PERIODS
from nhtrack.config.scenario import Scenario
from nhtrack.errors import FeasibilityError
from nhtrack.experiment.build import build, robot_of
from nhtrack.similarity import rounded_up

_CLOSE_ENOUGH = 0.998  # a fitting time scale this close to what its own run asks for is taken
_FIRST_PERIODS = 2000  # of the first run of a search
_FEWEST_PERIODS = 100  # below this a run no longer is the motion of its scenario
_MOST_RUNS = 20
_MOST_BLIND_PERIODS = 200_000  # of a run that diverges: beyond it the control period is not to blame


Timed = TypeVar("Timed", Scenario, Campaign)


def at_time(scenario: Timed, time: float | Literal["auto"]) -> Timed:
    """Returns the scenario or campaign with a time scale."""
    return scenario.model_copy(update={"similarity": scenario.similarity.model_copy(update={"time": time})})


def leader_time(scenario: Scenario) -> float:
    """Returns the smallest time scale at which a robot that moves as the leader is to fits; nothing is run.

    Raises:
        FeasibilityError: none does.
    """
    robot, name = robot_of(scenario), scenario.leader.name

    def worst(tried: Scenario) -> Binding:
        experiment = build(tried, robot)
        ground = experiment.scene.ground.scaled(tried.similarity.friction_margin)
        return binding_of(name, root_motion(experiment), robot.plant, ground)

    return smallest_time(scenario, worst)


def smallest_time(scenario: Scenario, worst_at: Callable[[Scenario], Binding | None]) -> float:
    """Returns the smallest time scale at which a motion fits wheels and motors, rounded up to four digits.

    One run tells by what factor its motion may be sped up. The control rate stays on the robot's clock, so the run at
    the new time scale differs a little; it is run as well, and again, until a time scale fits in its own run and is no
    larger than that run asks for.

    Args:
        scenario: whose time scale.
        worst_at: returns the limit that the motion of a scenario meets first, or None where it diverges.

    Raises:
        FeasibilityError: nothing fits, with robot, time and quantity.
    """
    per_unit = scenario.duration * scenario.control_rate  # control periods at T = 1
    floor, ceiling = rounded_up(_FEWEST_PERIODS / per_unit), MOST_PERIODS / per_unit
    time, too_small, fitted = max(_FIRST_PERIODS / per_unit, floor), 0.0, None
    for _ in range(_MOST_RUNS):
        worst = worst_at(at_time(scenario, time))
        if worst is None and time * per_unit > _MOST_BLIND_PERIODS:
            raise FeasibilityError(f"the ideal run diverges at every time scale tried, up to {time:.3g}")
        if worst is None:
            wanted = 4 * time
        elif worst.factor == 0:
            place = f"{worst.robot}'s {worst.wheel} wheel at {worst.time:.3g} s"
            raise FeasibilityError(f"{place} asks for {worst.limit} and there is none, however slow the motion")
        else:
            wanted = max(rounded_up(time / worst.factor), floor)
        if worst is not None and worst.factor >= 1:
            fitted = time if fitted is None else min(fitted, time)
            if wanted <= too_small or wanted >= _CLOSE_ENOUGH * time:
                return fitted
        else:
            too_small = max(too_small, time)
            if fitted is not None and wanted >= fitted:
                return fitted
        time = wanted
        if time > ceiling and worst is not None:
            raise FeasibilityError(_too_long(scenario, time, worst))
    raise FeasibilityError(f"no time scale found in {_MOST_RUNS} runs; the last tried was {time:g}")


def _too_long(scenario: Scenario, time: float, worst: Binding) -> str:
    reason = f"{worst.limit} of {worst.robot}'s {worst.wheel} wheel at {worst.time:.3g} s asks for it"
    count = scenario.duration * time * scenario.control_rate
    return (
        f"time scale {time:.3g} needed: {reason}; "
        f"that is {count:.2g} control periods, and a run has at most {MOST_PERIODS:.2g}"
    )
