"""What keeps what comes out of the loop: everything, or figures of it.

A recorder says where rows are to be written, a block of control periods at a time, and is told when they are there.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol

import numpy as np

from nhtrack.experiment.rows import BARE, Rows, variables_of
from nhtrack.simulation import columns
from nhtrack.simulation.touch import FIELDS, SLOTS

_BLOCK = 16 * 2**20  # bytes of a block of rows that are not kept


class Shape(NamedTuple):
    """How much a run is.

    Attributes:
        periods: control periods.
        simulations: side by side.
        robots: of each.
        telemetry: whether rows have telemetry.
        memory: values that the law remembers.
        qpos: robots with wheels and coordinates of each; (0, 0) on the ideal model.
        dt: control period [s].
        start: time at the start [s].
        every: every so many control periods a row is kept; the end of the run always is.
        touch: whether robots can touch each other.
    """

    periods: int
    simulations: int
    robots: int
    telemetry: bool
    memory: int
    qpos: tuple[int, int]
    dt: float
    start: float
    every: int = 1
    touch: bool = False

    @property
    def total(self) -> int:
        """Rows of a whole run."""
        return self.row_of(self.periods) + 1

    def row_of(self, period: int) -> int:
        """Returns the number of the first row that is not before the beginning of a period."""
        return -(-period // self.every)

    def row_after(self, period: int) -> int:
        """Returns the number of the first row that is of a period or later, where all rows before it are written."""
        return self.total if period > self.periods else self.row_of(period)

    @property
    def columns(self) -> int:
        """Columns of a row."""
        return BARE + (columns.WIDTH if self.telemetry else 0)

    @property
    def row_bytes(self) -> int:
        """Bytes of all rows of one time, without the law's memory."""
        p, size = self.qpos
        touched = self.touch * SLOTS * len(FIELDS)
        return 8 * self.simulations * (self.robots * (self.columns + touched) + p * size)

    def times(self, first: int, count: int) -> np.ndarray:
        """Returns the times of so many rows from `first` on [s]."""
        periods = np.minimum(np.arange(first, first + count) * self.every, self.periods)
        return self.start + periods * self.dt

    def rows(self, count: int, *, memory: bool, qpos: bool, touch: bool) -> Rows:
        """Returns room for so many rows."""
        b, n = self.simulations, self.robots
        return Rows(
            np.empty((b, count, n, self.columns)),
            np.empty((b, count if memory else 0, n, max(self.memory, 1))),
            np.empty((b, count if qpos and self.qpos[0] else 0, *self.qpos)),
            np.empty((b, count if touch and self.touch else 0, n, SLOTS, len(FIELDS))),
            0,
        )


class Recorder(Protocol):
    """Keeps what a run leaves."""

    @property
    def room(self) -> int:
        """How many rows `space` has at most."""
        ...

    def begin(self, shape: Shape) -> None:
        """Is told how much will come."""
        ...

    def space(self, first: int, count: int) -> Rows:
        """Returns where rows from `first` on are to be written, at most `count` of them."""
        ...

    def add(self, first: int, count: int) -> None:
        """Is told that so many rows have been written, from `first` on."""
        ...


class KeepingRecorder(Recorder, Protocol):
    """Keeps all rows."""

    @property
    def count(self) -> int:
        """How many there are."""
        ...

    @property
    def time(self) -> np.ndarray:
        """Times of the rows [s]."""
        ...

    def kept(self, *, batch: bool) -> tuple[Mapping[str, Any], Any]:
        """Returns variables and qpos as `nhtrack.experiment.loop.Rollout` has them, of a batch or of one simulation."""
        ...


class FullRecorder:
    """Keeps every row in memory, and MuJoCo's configurations with them."""

    count = 0

    def begin(self, shape: Shape) -> None:
        """Takes memory for the whole run."""
        self.shape, self.count, self.room = shape, 0, shape.total + shape.periods
        self._rows = shape.rows(shape.total, memory=False, qpos=True, touch=True)

    def space(self, first: int, count: int) -> Rows:
        """Returns the rows themselves."""
        return self._rows._replace(first=first)

    def add(self, first: int, count: int) -> None:
        """Counts the rows."""
        self.count = first + count

    @property
    def time(self) -> np.ndarray:
        """Times of the rows [s]."""
        return self.shape.times(0, self.count)

    def kept(self, *, batch: bool) -> tuple[Mapping[str, np.ndarray], np.ndarray | None]:
        """Returns the rows by the names of variables, and qpos; see `KeepingRecorder`."""
        variables, qpos = kept_of(self._rows, self.count)
        one = slice(None) if batch else 0
        return {name: values[:, one] for name, values in variables.items()}, None if qpos is None else qpos[:, one]


def kept_of(rows: Rows, count: int) -> tuple[dict[str, np.ndarray], np.ndarray | None]:
    """Returns views of the first rows: by the names of variables, shape (t, b, n, ...); and qpos, shape (t, b, nq)."""
    found = variables_of(rows.table[:, :count].swapaxes(0, 1))
    if rows.touch.shape[1]:
        found |= {"touch": rows.touch[:, :count].swapaxes(0, 1)}
    if not rows.qpos.shape[1]:
        return found, None
    return found, rows.qpos[:, :count].reshape(len(rows.qpos), count, -1).swapaxes(0, 1)


class Streaming:
    """A recorder that looks at rows as they come and keeps none of them: what derives from it has `take`."""

    def begin(self, shape: Shape) -> None:
        """Takes memory for a block of rows."""
        self.shape = shape
        count = self.room = max(2, min(shape.total, _BLOCK // (shape.row_bytes + 8 * shape.simulations * shape.memory)))
        self._rows = shape.rows(count, memory=True, qpos=False, touch=False)

    def space(self, first: int, count: int) -> Rows:
        """Returns the block's rows, as many as there are."""
        return self._rows

    def add(self, first: int, count: int) -> None:
        """Looks at the rows."""
        self.take(first, count, self._rows)

    def take(self, first: int, count: int, rows: Rows) -> None:
        """Looks at so many rows from `first` on, the first ones of a block; they are gone afterwards."""
        raise NotImplementedError
