"""A recorder that keeps every row in a file, a block of them at a time: a run need not fit into memory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from nhtrack.arrays import CHUNK
from nhtrack.experiment.recorder import Shape, kept_of
from nhtrack.experiment.rows import Rows
from nhtrack.files.appended import AppendedDataset
from nhtrack.recording.making import make_recording, plain_attributes
from nhtrack.recording.reading import reopened
from nhtrack.recording.recording import Recording

_BUFFER = 2**24  # bytes of rows that are written together


class FileRecorder:
    """Keeps every row of a run in a file, with the poses of its ideal twin; see `KeepingRecorder`.

    A block of rows is written while the next one is filled.

    Args:
        file: where to.
        robots: their names.
        twin: what ran on the ideal integrator before, with `pose` in its variables; None for a run that is its own.
        only: the variables that are kept, all by default.
    """

    def __init__(
        self, file: Path, robots: tuple[str, ...], twin: Mapping[str, Any] | None = None, only: Sequence[str] = ()
    ) -> None:
        self._file, self._robots, self._twin, self._only, self.count = file, robots, twin, only, 0

    def begin(self, shape: Shape) -> None:
        """Makes the file, and takes memory for two blocks of rows."""
        self.shape, self.count = shape, 0
        self._size = max(1, min(CHUNK, shape.total, _BUFFER // shape.row_bytes))
        self._open, self._spare = (shape.rows(self._size, memory=False, qpos=True, touch=True) for _ in range(2))
        self._first = 0  # row of the block that is open
        none = {name: values[:0] for name, values in self._values(0, 1).items()}
        self._names = none.keys() - {"time", "qpos"}
        variables = {name: values for name, values in none.items() if name in self._names}
        template = make_recording(none["time"], self._robots, variables, {}, none.get("qpos")).dataset
        self._dataset = AppendedDataset(self._file, template, self._size)

    @property
    def room(self) -> int:
        """Returns how many rows the open block has room for."""
        return self._first + self._size - self.count

    def space(self, first: int, count: int) -> Rows:
        """Returns the open block."""
        return self._open._replace(first=first - self._first)

    def add(self, first: int, count: int) -> None:
        """Counts the rows, and hands the block over when it is full."""
        self.count = first + count
        if not self.room:
            self._hand_over()
            self._open, self._spare, self._first = self._spare, self._open, self.count

    @property
    def time(self) -> np.ndarray:
        """Times of the rows [s]."""
        return self.shape.times(0, self.count)

    def kept(self, *, batch: bool) -> tuple[Mapping[str, Any], Any]:
        """Returns what is read as the variables of one simulation, a part at a time; qpos stays in the file.

        Raises:
            TypeError: a batch is wanted.
        """
        if batch:
            raise TypeError("a file has one simulation")
        self._hand_over()
        return {name: self._dataset[name] for name in self._names}, None

    def finish(self, attributes: Mapping[str, Any]) -> Recording:
        """Returns the recording, which stays in its file until it is saved."""
        self._hand_over()
        self._dataset.finish(plain_attributes(attributes))
        return Recording(reopened(self._file), self._file)

    def discard(self) -> None:
        """Closes a file that nobody needs any more."""
        self._dataset.discard()

    def _hand_over(self) -> None:
        if self.count > self._first:
            self._dataset.append(self._first, self._values(self._first, self.count - self._first))

    def _values(self, first: int, count: int) -> dict[str, np.ndarray]:
        """Returns the rows of the open block as they are recorded, with qpos where there is any, and their times."""
        variables, qpos = kept_of(self._open, count)
        found = {name: values[:, 0] for name, values in variables.items() if not self._only or name in self._only}
        if not self._only:
            found["ideal_pose"] = found["pose"] if self._twin is None else _poses(self._twin["pose"], first, count)
            found |= {} if qpos is None else {"qpos": qpos[:, 0]}
        return found | {"time": self.shape.times(first, count)}


def _poses(twin: Any, first: int, count: int) -> np.ndarray:
    """Returns the poses of rows of a twin; NaN where it ended before."""
    poses = np.full((count, *twin.shape[1:]), np.nan)
    known = twin[first : first + count]
    poses[: len(known)] = known
    return poses
