"""Where the rows of a run and of its ideal twin are until they are a recording: in memory, or in a file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from nhtrack.experiment.loop import Rollout
from nhtrack.experiment.recorder import FullRecorder, KeepingRecorder
from nhtrack.recording import Recording, make_recording
from nhtrack.recording.file_recorder import FileRecorder

_MOTION = ("pose", "twist", "input")  # what is asked of a twin


class Keeping(Protocol):
    """Keeps a run and its twin; `twin_recorder`, `recorder` and `recording` are called in this order."""

    def twin_recorder(self) -> KeepingRecorder:
        """Returns what keeps the twin, which is the run itself where that is ideal."""
        ...

    def recorder(self, twin: Rollout) -> KeepingRecorder:
        """Returns what keeps a run on wheels."""
        ...

    def recording(self, main: Rollout, twin: Rollout, attributes: Mapping[str, Any]) -> Recording:
        """Returns the recording of a run; the rows of both rollouts are its own from then on."""
        ...


class InMemory:
    """Keeps both in memory; see `Keeping`.

    Args:
        robots: their names.
    """

    def __init__(self, robots: tuple[str, ...]) -> None:
        self._robots = robots

    def twin_recorder(self) -> KeepingRecorder:
        """Returns a recorder in memory."""
        return FullRecorder()

    def recorder(self, twin: Rollout) -> KeepingRecorder:
        """Returns a recorder in memory."""
        return FullRecorder()

    def recording(self, main: Rollout, twin: Rollout, attributes: Mapping[str, Any]) -> Recording:
        """Returns the recording.

        A run that ended early has fewer rows than its twin; where the twin ended early, its pose is not known.
        """
        shared = min(len(main.time), len(twin.time))
        ideal_pose = np.full_like(main.variables["pose"], np.nan)
        ideal_pose[:shared] = twin.variables["pose"][:shared]
        variables = {**main.variables, "ideal_pose": ideal_pose}
        return make_recording(main.time, self._robots, variables, attributes, main.qpos)


class InFile:
    """Keeps both in files of a folder; see `Keeping`.

    Args:
        robots: their names.
        folder: which stays until the recording is saved.
        ideal: whether the run is its own twin.
    """

    def __init__(self, robots: tuple[str, ...], folder: Path, *, ideal: bool) -> None:
        self._main = FileRecorder(folder / "recording.nc", robots)
        self._twin = self._main if ideal else FileRecorder(folder / "twin.nc", robots, only=_MOTION)
        self._robots, self._folder = robots, folder

    def twin_recorder(self) -> KeepingRecorder:
        """Returns the recorder of the twin's motion, or of the run."""
        return self._twin

    def recorder(self, twin: Rollout) -> KeepingRecorder:
        """Returns the recorder of the run, which looks up the twin's poses."""
        self._main = FileRecorder(self._folder / "recording.nc", self._robots, twin.variables)
        return self._main

    def recording(self, main: Rollout, twin: Rollout, attributes: Mapping[str, Any]) -> Recording:
        """Returns the recording."""
        recording = self._main.finish(attributes)
        if self._twin is not self._main:
            self._twin.discard()
        return recording
