"""Room for the rows of a run: memory, or a file where there are too many."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable
from math import prod
from pathlib import Path

import numpy as np

from nhtrack.errors import RefusedError

MEMORY = 10**9  # bytes of rows from which on they go to a file
_SPARE = 1.1  # room that is asked for over room that is needed


class RoomError(RefusedError):
    """A run whose rows fit neither into memory nor onto the disk."""


def storage(size: int, folder: Path | None) -> Callable[[tuple[int, ...]], np.ndarray]:
    """Returns what makes arrays of float64 for rows of so many bytes: in memory, or in a nameless file of a folder.

    Args:
        size: of all rows [bytes].
        folder: where the file may be, or None to stay in memory.

    Raises:
        RoomError: there is no room; nothing has been written.
    """
    if size <= MEMORY:
        return np.empty
    if folder is None:
        free = available_memory()
        if free is not None and _SPARE * size > free:
            raise RoomError(_no_room(size, f"memory has {free / 1e9:.3g} GB left"))
        return np.empty
    folder.mkdir(parents=True, exist_ok=True)
    free = shutil.disk_usage(folder).free
    if 2 * _SPARE * size > free:  # the rows, and the recording that is made of them
        raise RoomError(_no_room(2 * size, f"{folder} has {free / 1e9:.3g} GB left"))

    def in_file(shape: tuple[int, ...]) -> np.ndarray:
        if not prod(shape):
            return np.empty(shape)
        with tempfile.TemporaryFile(dir=folder) as file:
            _take_room(file.fileno(), np.dtype(float).itemsize * prod(shape), folder)
            return np.memmap(file, dtype=float, mode="w+", shape=shape)

    return in_file


def _take_room(file: int, size: int, folder: Path) -> None:
    """Takes room on the disk: a disk that fills up under mapped memory ends the process (SIGBUS)."""
    try:
        os.posix_fallocate(file, 0, size)
    except OSError as error:
        raise RoomError(_no_room(size, f"{folder} has no room for it: {error.strerror}")) from None


def available_memory() -> int | None:
    """Returns how many bytes of memory are free to be taken, or None where the system does not tell."""
    try:
        lines = Path("/proc/meminfo").read_text().splitlines()
        found = next(line for line in lines if line.startswith("MemAvailable"))
        return 1024 * int(found.split()[1])
    except (OSError, StopIteration, ValueError, IndexError):
        return None


def _no_room(size: int, there: str) -> str:
    return (
        f"the recording needs {size / 1e9:.3g} GB and {there}; keep fewer rows with `record: {{every: 10}}`, or run "
        "fewer robots or less time"
    )
