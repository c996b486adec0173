"""How much a run is, known before it is run: memory, a file, time; and whether there is room for it."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import NamedTuple

from nhtrack.errors import RefusedError
from nhtrack.experiment.build import Experiment
from nhtrack.experiment.recorder import Shape

MEMORY = 10**8  # bytes of rows from which on they go to a file, where there may be one

# Measured (docs/performance.md), to plan with: neighbours on a machine move times by half.
_PHYSICS_STEP = 12e-6  # [s] a robot on wheels
_PERIOD = 1.5e-6  # [s] a robot on the ideal integrator, with its law
BYTE = 100e-9  # [s] of a recording written, looked through and drawn
_BASE = 5.5e8  # [bytes] of a process that runs, reads and draws; a small run takes 4.7e8
_PERIODS = 200  # [bytes] a control period: the leader's input, and what is looked at beforehand
_ROWS = 200  # [bytes] a row of what is looked at of one robot
_COORDINATES = 9  # MuJoCo's, of one robot, about
_SPARE = 1.1  # room that is asked for over room that is needed
_LARGE = 1e9  # [bytes] of a recording from which on it is said how to have less
_PART = 10.0  # [s] about, that a part of many runs takes: what is lost when stopped
_LARGEST = 500  # runs of a part
_SHARES = 4  # parts a worker at least, where there are so many runs: the last ones are then short
_NOTED = 30.0  # [s] from which on it is said how long a run takes


class RoomError(RefusedError):
    """A run for which memory or disk have no room."""


class Extent(NamedTuple):
    """How much a run and its ideal twin are.

    Attributes:
        periods: control periods.
        robots: of the run.
        every: every so many periods a row is kept.
        rows: of run and twin [bytes].
        file: the recording, where nothing of it could be compressed [bytes].
        seconds: on one core, about, without the film [s].
    """

    periods: int
    robots: int
    every: int
    rows: int
    file: int
    seconds: float

    def memory(self, *, in_file: bool) -> float:
        """Returns how much memory the process takes [bytes], about, its rows in a file or not."""
        rows = _ROWS * self.periods / self.every if in_file else 2.5 * self.rows
        return _BASE + _PERIODS * self.periods + rows

    @property
    def bare_seconds(self) -> float:
        """How long the run takes where nothing of it is written or drawn [s]."""
        return self.seconds - BYTE * self.file

    @property
    def is_large(self) -> bool:
        """Whether it is worth a warning."""
        return self.file > _LARGE

    @property
    def sentence(self) -> str:
        """What to know before it runs into a folder; empty for a run that is over soon and small."""
        if self.seconds < _NOTED and self.rows <= MEMORY:
            return ""
        memory, minutes = self.memory(in_file=self.rows > MEMORY), self.seconds / 60
        time = f"{minutes:.2g} min" if minutes < 60 else f"{minutes / 60:.2g} h"
        fewer = f"; `record: {{every: {10 * self.every}}}` keeps a tenth" if self.is_large else ""
        return (
            f"{self.periods} control periods of {self.robots} robots: about {time} on one core, {_gigabytes(memory)} "
            f"of memory, a recording of at most {_gigabytes(self.file)}{fewer}"
        )


def extent_of(experiment: Experiment, *, wheels: bool) -> Extent:
    """Returns how much a run of an experiment is, on wheels or on the ideal model alone."""
    periods, robots = len(experiment.inputs), len(experiment.network)
    shape = Shape(
        periods, 1, robots, True, 0, (robots, _COORDINATES) if wheels else (0, 0), 0.0, 0.0, experiment.every,
        experiment.scene.robot_contact,
    )  # fmt: skip
    rows = shape.row_bytes * shape.total
    file = rows + 8 * 3 * robots * shape.total
    steps = periods * robots
    seconds = _PERIOD * steps + BYTE * file
    seconds += wheels * _PHYSICS_STEP * steps * experiment.dt / experiment.scene.timestep
    return Extent(periods, robots, experiment.every, 2 * rows, file, seconds)


def part_size(seconds: float, runs: int, workers: int, most: int = _LARGEST, least: float = 0.0) -> int:
    """Returns how many of many runs are a part, that one worker does and writes at a time.

    Args:
        seconds: of a run on one core, about.
        runs: how many there are.
        workers: how many parts are done at once.
        most: how many may be a part.
        least: seconds of a part that it is not worth to go below, where it begins with what takes long.
    """
    shares = max(-(-runs // (_SHARES * workers)), int(least / seconds))
    return max(1, min(_LARGEST, most, int(_PART / seconds), shares))


def require_room(extent: Extent, folder: Path | None) -> bool:
    """Returns whether rows are to go to a file of a folder, rather than to memory.

    Raises:
        RoomError: there is no room for them; nothing is run.
    """
    in_file = folder is not None and extent.rows > MEMORY
    needed, free = _SPARE * extent.memory(in_file=in_file), available_memory()
    if free is not None and needed > free:
        raise RoomError(_no_room(extent, f"{_gigabytes(needed)} of memory and {_gigabytes(free)} are free", in_file))
    if folder is not None and in_file:
        folder.mkdir(parents=True, exist_ok=True)
        needed, free = _SPARE * extent.file, shutil.disk_usage(folder).free
        if needed > free:
            where = f"{_gigabytes(needed)} on the disk of {folder} and {_gigabytes(free)} are free there"
            raise RoomError(_no_room(extent, where, in_file))
    return in_file


def available_memory() -> int | None:
    """Returns how many bytes of memory are free to be taken, or None where the system does not tell."""
    try:
        lines = Path("/proc/meminfo").read_text().splitlines()
        found = next(line for line in lines if line.startswith("MemAvailable"))
        return 1024 * int(found.split()[1])
    except (OSError, StopIteration, ValueError, IndexError):
        return None


def _gigabytes(size: float) -> str:
    return f"{size / 1e9:.2g} GB" if size < 1e11 else f"{size / 1e9:.0f} GB"


def _no_room(extent: Extent, there: str, in_file: bool) -> str:
    folder = "" if in_file else ", and `nhtrack run` keeps them on the disk"
    return (
        f"duration: {extent.periods} control periods of {extent.robots} robots need {there}; "
        f"`record: {{every: {10 * extent.every}}}` keeps a tenth of the rows{folder}; or run fewer robots or less time"
    )
