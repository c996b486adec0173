"""A law that remembers what it saw, and runs that tell it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from nhtrack.experiment.followers import Tracking
from nhtrack.experiment.link import Link
from nhtrack.experiment.loop import run_loop
from nhtrack.experiment.recorder import Shape, Streaming
from nhtrack.experiment.rows import Rows
from nhtrack.laws import Law, law_in
from nhtrack.network import Network
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.state import State

LAWS = Path(__file__).parent / "own_laws"
ECHO = law_in(LAWS / "echo.py")


class Memories(Streaming):
    """Keeps the law's memory, shape (t, b, n, values)."""

    def begin(self, shape: Shape) -> None:
        super().begin(shape)
        self._kept: list[np.ndarray] = []

    def take(self, first: int, count: int, rows: Rows) -> None:
        self._kept.append(rows.memory[:, :count].swapaxes(0, 1).copy())

    @property
    def rows(self) -> np.ndarray:
        return np.concatenate(self._kept)


def watch(
    network: Network,
    inputs: np.ndarray,
    start: State,
    dt: float,
    tracking: Tracking | None = None,
    link: Link | None = None,
    law: Law | None = None,
) -> dict[str, np.ndarray]:
    """What followers saw in each period and at the end, (t, n), by the names of the memory of `own_laws/echo.py`."""
    recorder, simulation = Memories(), IdealSimulation(network.names, None, dt)
    failure = run_loop(simulation, law or ECHO(), network, inputs, start, recorder, tracking, link=link)
    assert failure is None
    return dict(zip(ECHO.memory._fields, np.moveaxis(recorder.rows[:, 0], -1, 0), strict=True))
