"""A campaign's runs in parts: some starts of a law and a family side by side, with a file for their rows."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from nhtrack.experiment.build import Experiment
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.scene import stepped_scene
from nhtrack.studies.campaign.cell import Cell
from nhtrack.studies.campaign.outcomes import outcomes_of, statistics_of
from nhtrack.studies.campaign.tables import rows_of, save_runs

PART = {"ideal": 1000, "mujoco": 250}  # starts in a part: few enough for the caches, and to lose little when stopped


class Part(NamedTuple):
    """Some starts of a cell, and the file their rows are written to."""

    cell: Cell
    starts: slice
    path: Path


def run_part(part: Part) -> None:
    """Runs some starts side by side and writes their rows."""
    save_runs(run_starts(part.cell, part.starts), part.path)


@np.errstate(over="ignore", invalid="ignore")  # what is lost is told by the table
def run_starts(cell: Cell, starts: slice) -> pd.DataFrame:
    """Returns the rows of some consecutive starts of a cell, run side by side."""
    experiment, campaign = cell.experiment(starts), cell.campaign
    simulation = _simulation(experiment, campaign.backend)
    statistics = statistics_of(campaign, experiment)
    failure = experiment.record(simulation, statistics)
    if failure is not None:  # of the law itself; a robot that is lost is a figure
        raise failure
    return rows_of(cell, starts.start, outcomes_of(statistics, campaign, experiment, simulation.lost))


def _simulation(experiment: Experiment, backend: str) -> IdealSimulation | MujocoSimulation:
    spec, size = experiment.scene, experiment.size
    if backend == "ideal":
        names, plant = experiment.network.names, experiment.robot.plant
        return IdealSimulation(names, plant, experiment.dt, spec.ground, virtual_root=True, keep_going=True, size=size)
    batch = experiment.start.g.shape[:1]
    scene = stepped_scene(spec, experiment.robot)
    return MujocoSimulation(scene, experiment.dt, batch, spec=spec, keep_going=True, size=size)


def parts_of(cell: Cell, folder: Path) -> Iterator[Part]:
    """Yields a cell in parts."""
    count, size = cell.campaign.starts.count, PART[cell.campaign.backend]
    for first in range(0, count, size):
        name = f"{slug(cell.label)}-{slug(cell.family)}-{first}.parquet"
        yield Part(cell, slice(first, min(first + size, count)), folder / "parts" / name)


def slug(text: str) -> str:
    """Returns a label as names of files have it."""
    return text.replace(" ", "_")
