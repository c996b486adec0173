"""What keeps what comes out of the loop: everything, or figures of it.

A recorder says where rows are to be written, a block of control periods at a time, and is told when they are there.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from nhtrack.experiment.rows import BARE, Rows, named
from nhtrack.simulation import columns

_BLOCK = 16 * 2**20  # bytes of a block of rows that are not kept


class Shape(NamedTuple):
    """How much a run is.

    Attributes:
        periods: control periods; a run has one row more.
        simulations: side by side.
        robots: of each.
        telemetry: whether rows have telemetry.
        memory: values that the law remembers.
        qpos: robots with wheels and coordinates of each; (0, 0) on the ideal model.
        dt: control period [s].
        start: time at the start [s].
    """

    periods: int
    simulations: int
    robots: int
    telemetry: bool
    memory: int
    qpos: tuple[int, int]
    dt: float
    start: float

    @property
    def columns(self) -> int:
        """Columns of a row."""
        return BARE + (columns.WIDTH if self.telemetry else 0)

    @property
    def row_bytes(self) -> int:
        """Bytes of all rows of one time, without the law's memory."""
        p, size = self.qpos
        return 8 * self.simulations * (self.robots * self.columns + p * size)

    def rows(self, count: int, *, memory: bool, qpos: bool) -> Rows:
        """Returns room for so many rows."""
        b, n = self.simulations, self.robots
        return Rows(
            np.empty((count, b, n, self.columns)),
            np.empty((count if memory else 0, b, n, max(self.memory, 1))),
            np.empty((count if qpos and self.qpos[0] else 0, b, *self.qpos)),
        )


class Recorder(Protocol):
    """Keeps what a run leaves."""

    def begin(self, shape: Shape) -> None:
        """Is told how much will come."""
        ...

    def space(self, first: int, count: int) -> Rows:
        """Returns where rows from `first` on are to be written, at most `count` of them."""
        ...

    def add(self, first: int, rows: Rows, lost: np.ndarray) -> None:
        """Takes rows that have been written, and which simulations are lost by now, shape (b,)."""
        ...


class FullRecorder:
    """Keeps every row.

    Args:
        qpos: whether to keep MuJoCo's configurations, for films.
    """

    def __init__(self, *, qpos: bool = True) -> None:
        self._qpos, self.count = qpos, 0

    def begin(self, shape: Shape) -> None:
        """Takes memory for the whole run."""
        self.shape, self.count = shape, 0
        self._rows = shape.rows(shape.periods + 1, memory=False, qpos=self._qpos)

    def space(self, first: int, count: int) -> Rows:
        """Returns the rows themselves."""
        table, memory, qpos = self._rows
        return Rows(table[first : first + count], memory, qpos[first : first + count])

    def add(self, first: int, rows: Rows, lost: np.ndarray) -> None:
        """Counts the rows."""
        self.count = first + len(rows.table)

    @property
    def time(self) -> np.ndarray:
        """Times of the rows [s]."""
        return self.shape.start + np.arange(self.count) * self.shape.dt

    @property
    def variables(self) -> dict[str, np.ndarray]:
        """Arrays of shape (t, b, n, ...) by the names of `nhtrack.recording.VARIABLES`."""
        return named(self._rows.table[: self.count])

    @property
    def qpos(self) -> np.ndarray | None:
        """MuJoCo's configurations, shape (t, b, nq), or None."""
        held = self._rows.qpos[: self.count]
        return held.reshape(*held.shape[:2], -1) if len(self._rows.qpos) else None


class Streaming:
    """A recorder that looks at rows as they come and keeps none of them: what derives from it has `take`."""

    def begin(self, shape: Shape) -> None:
        """Takes memory for a block of rows."""
        self.shape = shape
        count = max(2, min(shape.periods + 1, _BLOCK // (shape.row_bytes + 8 * shape.simulations * shape.memory)))
        self._rows = shape.rows(count, memory=True, qpos=False)

    def space(self, first: int, count: int) -> Rows:
        """Returns the block's rows, as many as there are."""
        table, memory, qpos = self._rows
        return Rows(table[:count], memory[:count], qpos)

    def add(self, first: int, rows: Rows, lost: np.ndarray) -> None:
        """Looks at the rows."""
        self.take(first, rows, lost)

    def take(self, first: int, rows: Rows, lost: np.ndarray) -> None:
        """Looks at rows from `first` on; they are gone afterwards."""
        raise NotImplementedError
