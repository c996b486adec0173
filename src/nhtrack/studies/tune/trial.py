"""Sets of gains run side by side on the ideal model, and what they cost."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from nhtrack.analysis.motion import robots_with_wheels
from nhtrack.arrays import Array
from nhtrack.config.scenario import Scenario
from nhtrack.execution import Executor, Serial, serial
from nhtrack.experiment.build import build
from nhtrack.experiment.loop import Progress
from nhtrack.settling import settling_limits
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.robot_models import RobotModels
from nhtrack.studies.tune.objective import Figures, Objective, figures_of

SEARCH_PERIODS = 2000  # control periods of a search run, at most
_ROBOT_PERIODS = 2_500_000  # robots x candidates x periods in one batch: some 400 MB


class Trial:
    """Runs sets of gains side by side and says what they cost."""

    def __init__(
        self,
        scenario: Scenario,
        names: tuple[str, ...],
        objective: Objective,
        robot: RobotModels,
        executor: Executor = serial,
    ) -> None:
        self._scenario, self._names, self._objective, self._robot = scenario, names, objective, robot
        self._executor = executor
        late = scenario.delay or scenario.law.delay_periods  # periods, which would be longer
        slower = 1 if late else math.ceil(scenario.periods / SEARCH_PERIODS)
        self._search = scenario.model_copy(update={"control_rate": scenario.control_rate / slower})

    def run(
        self, candidates: Array, report: Callable[[float], None] | None = None, *, own_rate: bool = False
    ) -> tuple[Figures, Array]:
        """Returns the figures of candidates (b, d) and their costs, each of shape (b,)."""
        scenario = self._scenario if own_rate else self._search
        room = _ROBOT_PERIODS // (scenario.periods * (1 + len(scenario.followers)))
        together = max(1, min(room, -(-len(candidates) // self._executor.workers)))
        batches = [candidates[begin : begin + together] for begin in range(0, len(candidates), together)]
        here = report if isinstance(self._executor, Serial) else None  # of a batch elsewhere nothing is heard before
        parts = dict[int, Figures]()

        def progress(done: int, total: int) -> None:
            if here is not None:
                here((len(parts) + done / total) / len(batches))

        work = partial(_figures, scenario, self._names, self._robot, None if here is None else progress)
        for place, figures in self._executor(batches, work):
            parts[place] = figures
            if report is not None:
                report(len(parts) / len(batches))
        columns = zip(*(parts[place] for place in range(len(batches))), strict=True)
        figures = Figures(*(np.concatenate(column) for column in columns))
        return figures, self._objective.cost(figures)


def _figures(
    scenario: Scenario, names: tuple[str, ...], robot: RobotModels, progress: Progress | None, batch: Array
) -> Figures:
    """Returns the figures of one batched rollout; NaN for the candidates that lose their robots."""
    gains = {name: batch[:, i, None] for i, name in enumerate(names)}
    experiment = build(with_gains(scenario, gains), robot)
    simulation = IdealSimulation(experiment.network.names, None, experiment.dt, keep_going=True, size=experiment.size)
    run = experiment.rollout(simulation, progress, batch=(len(batch),))
    run.require_whole()  # a robot that runs away is a candidate that is lost, and no failure
    bodies = list(robots_with_wheels(experiment).values())
    margin = scenario.similarity.friction_margin
    limits = settling_limits(experiment.similarity.length)
    figures = figures_of(run, limits, bodies, robot.plant, experiment.scene.ground, margin)
    return Figures(*(np.where(simulation.lost, np.nan, values) for values in figures))


def with_gains(scenario: Scenario, gains: Mapping[str, Array] | Mapping[str, float]) -> Scenario:
    """Returns the scenario with other gains: numbers, or arrays (b, 1) that make its law one of b laws."""
    return scenario.model_copy(update={"law": scenario.law.model_copy(update=dict(gains))})
