"""Runs of a sweep that can go side by side: one experiment, with other gains, starts and seeds in each."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from nhtrack.arrays import Array
from nhtrack.config.law_sections import LawSection
from nhtrack.config.scenario import Scenario
from nhtrack.experiment.build import Experiment, build, make_scene_spec, seeds_of, start_of
from nhtrack.experiment.recorder import FullRecorder
from nhtrack.experiment.rows import BARE
from nhtrack.experiment.run_statistics import RunStatistics, Statistics
from nhtrack.settling import first_late_row, settling_limits
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.robot_models import RobotModels
from nhtrack.simulation.state import State
from nhtrack.studies.campaign.outcomes import simulation_of

_SHARED_GAINS = ("turn_rate", "dead_zone_speed")  # those that make the leader which a law sees
_BYTES = 2.5e8  # of ideal twins kept at once


@dataclass(frozen=True)
class Figures:
    """What came of runs side by side.

    Attributes:
        statistics: their figures.
        late: first row of the late part.
        dt: control period [s].
        periods: control periods of a run.
        bodies: first robot that has wheels.
        lost: which runs were lost, shape (b,).
        twins: which have an ideal twin that was not, shape (b,).
    """

    statistics: Statistics
    late: int
    dt: float
    periods: int
    bodies: int
    lost: Array
    twins: Array


def alike(scenarios: Sequence[Scenario]) -> Iterable[list[int]]:
    """Returns the places of scenarios that can run side by side, group by group."""
    groups: dict[str, list[int]] = {}
    for place, scenario in enumerate(scenarios):
        groups.setdefault(_shared(scenario), []).append(place)
    return groups.values()


def _shared(scenario: Scenario) -> str:
    """Returns all of a scenario in which runs side by side may not differ, as text."""
    limits = getattr(scenario.law, "limits", None)
    if limits is not None and not limits.everywhere and make_scene_spec(scenario).ground.patches:
        return scenario.model_dump_json()  # which patches count depends on where robots start
    start = scenario.leader.start
    return scenario.model_copy(
        update={
            "seed": 0,
            "law": _without_gains(scenario.law),
            "leader": scenario.leader.model_copy(update={"start": start.model_copy(update=_NOWHERE)}),
            "followers": tuple(
                each.model_copy(update={"start": each.start.model_copy(update=_NOWHERE)}) for each in scenario.followers
            ),
        }
    ).model_dump_json()


_NOWHERE = {"pose": (0.0, 0.0, 0.0), "twist": (0.0, 0.0)}


def _without_gains(law: LawSection) -> LawSection:
    described = law.kind.described
    own = [name for name, gain in described.items() if not gain.section and name not in _SHARED_GAINS]
    return law.model_copy(update=dict.fromkeys(own, 0.0))


def run_side_by_side(scenarios: Sequence[Scenario], robot: RobotModels | None, *, twins: bool) -> Figures:
    """Runs scenarios that are alike side by side, as each would run alone, and returns their figures.

    Args:
        scenarios: see `alike`.
        robot: theirs, where it has been read already.
        twins: whether to take gaps to ideal twins, on wheels.

    Raises:
        SimulationDiverged: the law raised an exception; a robot that is lost is a figure.
        FeasibilityError: the law is to keep limits, and ground or motors leave none.
    """
    one = build(scenarios[0], robot)
    all_of_them = _beside(one, scenarios)
    wheels = scenarios[0].backend != "ideal"
    followed = _twins(all_of_them) if twins and wheels else None
    times = one.start.t + np.arange(len(one.inputs) + 1) * one.dt
    late, limits = first_late_row(times), settling_limits(one.similarity.length)
    statistics = RunStatistics(limits, late, one.law.kind.modes, None if followed is None else followed[0])
    simulation = simulation_of(all_of_them, scenarios[0].backend)
    failure = all_of_them.record(simulation, statistics)
    if failure is not None:
        raise failure
    sound = np.zeros(len(scenarios), dtype=bool) if followed is None else ~followed[1]
    first = int(one.scene.virtual_root)
    return Figures(statistics.figures, late, one.dt, len(one.inputs), first, simulation.lost, sound)


def most_side_by_side(experiment: Experiment) -> int:
    """Returns how many runs of an experiment may go side by side, for what is kept of their ideal twins."""
    return max(1, int(_BYTES / (8 * BARE * len(experiment.network) * (len(experiment.inputs) + 1))))


def _beside(one: Experiment, scenarios: Sequence[Scenario]) -> Experiment:
    """Returns the experiment of scenarios side by side, arrays of shape (b, n, ...)."""
    starts = [start_of(scenario, one.similarity) for scenario in scenarios]
    gains = [scenario.law.gains(one.similarity) for scenario in scenarios]
    law = one.law.kind(
        limits=one.law.limits,
        delay_periods=one.law.delay_periods,
        **{name: np.array([row[name] for row in gains], dtype=float) for name in gains[0]},
    )
    g, xi = (np.stack([getattr(start, name) for start in starts]) for name in ("g", "xi"))
    seeds = seeds_of(*(scenario.seed for scenario in scenarios))
    return replace(one, law=law, start=State(one.start.t, g, xi), link=replace(one.link, seeds=seeds))


def _twins(experiment: Experiment) -> tuple[Array, Array]:
    """Returns the poses of the ideal twins, shape (b, rows, n, 3), and which of them were lost, shape (b,)."""
    names = experiment.network.names
    simulation = IdealSimulation(names, None, experiment.dt, keep_going=True, size=experiment.size)
    recorder = FullRecorder()
    experiment.record(simulation, recorder)
    return np.ascontiguousarray(recorder.kept(batch=True)[0]["pose"].swapaxes(0, 1)), simulation.lost
