"""What is known to go wrong before anything is run: of the gains, and of a leader beyond law or robot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nhtrack.analysis.demand import root_predictions
from nhtrack.analysis.extent import extent_of
from nhtrack.analysis.motion import root_path_of
from nhtrack.analysis.time_scale import at_time, leader_time
from nhtrack.config.degrees import degree_warnings
from nhtrack.config.law_sections import law_section
from nhtrack.config.link import delay_warnings
from nhtrack.config.scenario import Scenario
from nhtrack.errors import FeasibilityError
from nhtrack.experiment.build import Experiment, build, make_law
from nhtrack.experiment.leader_notes import leader_warnings
from nhtrack.experiment.robot_checks import robot_warnings
from nhtrack.laws import Law, LeaderMotion, Limits
from nhtrack.laws.leader_bounds import close_to_limits, over_limits
from nhtrack.similarity import rounded_up

_RESERVE = 1.05  # a leader at its followers' limit is not reached by most of them; one as much slower is
_ELSE = "agile"  # the law to be tried where another one has a bound


def beforehand(scenario: Scenario, experiment: Experiment) -> tuple[str, ...]:
    """Returns what is wrong with gains, leader, robot and ground, and how much a very large run is, in sentences."""
    extent = extent_of(experiment, wheels=scenario.backend != "ideal")
    large = [extent.sentence] if extent.is_large else []
    of_law = (*degree_warnings(scenario), *beforehand_of_law(scenario, experiment))
    if scenario.backend == "ideal":
        return (*of_law, *large)
    of_robot = (*robot_warnings(scenario, experiment), *leader_beyond_robot(scenario, experiment))
    return (*of_law, *of_robot, *large)


def told_extent(scenario: Scenario, experiment: Experiment) -> str:
    """Returns how much a run is, in a sentence; empty where that is little, or so much that it is a warning."""
    extent = extent_of(experiment, wheels=scenario.backend != "ideal")
    return "" if extent.is_large else extent.sentence


def beforehand_without_time(scenario: Scenario) -> tuple[str, tuple[str, ...]]:
    """Returns `told_extent` and `beforehand` of a scenario with `time: auto`, at the smallest that fits its leader.

    Followers may ask for a larger one, so that nothing is told of limits of the law, which depend on it.

    Raises:
        FeasibilityError: none fits a leader with wheels.
    """
    try:
        time = leader_time(scenario)
    except FeasibilityError as error:
        if not scenario.leader.virtual:
            raise
        return "", (f"a robot in the place of {scenario.leader.name}: {error}",)
    timed = at_time(scenario, time)
    experiment = build(timed)
    free = replace(experiment, law=replace(experiment.law, limits=Limits()))
    at = f"similarity.time {time:g}, the smallest that fits {scenario.leader.name} alone"
    extent = told_extent(timed, experiment)
    return extent and f"at {at}: {extent}", tuple(f"at {at}: {said}" for said in beforehand(timed, free))


def beforehand_of_law(scenario: Scenario, experiment: Experiment) -> tuple[str, ...]:
    """Returns the same of the law alone, and of the leader's way along its path."""
    name, law = scenario.leader.name, experiment.law
    beyond = (f"{name}: {said}" for said in leader_beyond_law(law, scenario, experiment))
    late = delay_warnings(scenario.delay, scenario.law)
    gains = (_with_key(law, said) for said in law.warnings())
    return (*gains, *late, *leader_warnings(scenario), *beyond)


def _with_key(law: Law, said: str) -> str:
    """Returns a sentence about gains with the key where it begins with one."""
    return f"law.{said}" if said.partition(" ")[0] in law.gains._fields else f"law: {said}"


def leader_beyond_robot(scenario: Scenario, experiment: Experiment) -> tuple[str, ...]:
    """Returns what is too much for a robot that moves as the leader is to, in sentences; nothing on the ideal model."""
    return () if scenario.backend == "ideal" else root_predictions(scenario, experiment)


def leader_beyond_law(law: Law, scenario: Scenario, experiment: Experiment) -> tuple[str, ...]:
    """Returns what of the leader's motion a law cannot follow, or is not known to, each with what would help.

    Args:
        law: in robot units; the experiment's own, or another.
        scenario: of the experiment.
        experiment: whose root is looked at; what its followers track is not where they have places or several parents.
    """
    leader = _root(experiment)
    over, time = over_limits(law.limits, experiment.dt, leader), scenario.similarity.time_scale
    close = close_to_limits(law.limits, leader, _RESERVE)
    slower = max((each.slower for each in (*over, *close)), default=1.0)
    fitting = rounded_up(_RESERVE * time * slower)
    reserve = f"{100 * (_RESERVE - 1):.2g} %"
    remedy = f"similarity.time {fitting:g} would leave a reserve of {reserve}"
    told = [f"{each.says}: it is not followed while that lasts; {remedy}" for each in over]
    told += [f"{each.says}; {remedy}" for each in close]
    beyond = law.beyond(experiment.dt, leader)
    other = make_law(law_section(_ELSE)(name=_ELSE), experiment.similarity)
    helps = beyond and law.kind is not other.kind and not other.beyond(experiment.dt, leader)
    instead = f"; no such bound is known of law: {{name: {_ELSE}}}" if helps else ""
    return (*told, *(f"{said}{instead}" for said in beyond))


def _root(experiment: Experiment) -> LeaderMotion:
    """Returns the root's motion at the beginning of each control period."""
    (x, y, theta), v, omega = (values[:-1].T for values in root_path_of(experiment))
    u_x, u_theta = experiment.inputs.T
    aside = np.zeros_like(v)
    return LeaderMotion(x, y, theta, v, aside, omega, u_x, aside, u_theta)
