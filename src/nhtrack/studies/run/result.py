"""What a run leaves behind."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from nhtrack.analysis.event import Event
from nhtrack.errors import SimulationDiverged
from nhtrack.recording import Recording
from nhtrack.views import drawn_by

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, repr=False)
class Outcome:
    """What a run left behind.

    Attributes:
        recording: the run.
        summary: its figures, see `nhtrack.analysis.metrics.summary`, with the warnings and notes.
        failure: why it ended early, or None.
        events: what went wrong on wheels.
        folder: where the files are, or None for a run in memory.
        files: the files written, in the order of writing.
        skipped: what was asked for and could not be made, with the reason.
    """

    recording: Recording
    summary: dict[str, Any]
    failure: SimulationDiverged | None
    events: tuple[Event, ...] = ()
    folder: Path | None = None
    files: tuple[Path, ...] = ()
    skipped: tuple[str, ...] = ()

    @property
    def warnings(self) -> tuple[str, ...]:
        """What will go wrong and what went wrong, in sentences."""
        return tuple(self.summary.get("warnings", ()))

    @property
    def notes(self) -> tuple[str, ...]:
        """What was read otherwise than the robot's file has it, or left out, in sentences."""
        return tuple(self.summary.get("notes", ()))

    def __getitem__(self, name: str) -> xr.DataArray:
        """Returns one recorded variable, with its coordinates and units; see `Recording`."""
        return self.recording[name]

    def __repr__(self) -> str:
        """Returns a one-line account of the run."""
        return f"Outcome({self.recording!r}, {self.recording.outcome})"

    def _repr_html_(self) -> str:
        """Returns what a notebook shows: pictures of the run, its paths and errors, its figures in tables."""
        return drawn_by("nhtrack.studies.run.view.outcome_html", self)


class DivergedError(SimulationDiverged):
    """A run that ended early because its numbers no longer meant anything.

    Attributes:
        outcome: what was recorded until then.
    """

    def __init__(self, outcome: Outcome) -> None:
        assert outcome.failure is not None
        failure, self.outcome = outcome.failure, outcome
        super().__init__(failure.reason, failure.robot, failure.time, failure.batch)

    def __reduce__(self) -> tuple[type[DivergedError], tuple[Outcome]]:  # type: ignore[override]
        """Returns how to make the error anew, so that it can cross from a worker process."""
        return type(self), (self.outcome,)


# A run, its recording, or the file that this was saved to.
Recorded: TypeAlias = Outcome | Recording | str | Path


def recording_of(recorded: Recorded) -> Recording:
    """Returns the recording that is meant.

    Raises:
        RecordingError: the file is none.
    """
    if isinstance(recorded, Outcome):
        return recorded.recording
    return recorded if isinstance(recorded, Recording) else Recording.load(recorded)
