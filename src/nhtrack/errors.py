"""Exceptions of the package; every one derives from `NhtrackError`."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

_MOST_NAMES = 60  # that a message lists
_MOST_FAULTS = 100  # that a message tells
_LONGEST_NAME = 200  # letters of what was given that a message repeats, and that its nearest name is looked for with


class NhtrackError(Exception):
    """Root of every error the package raises on purpose."""


class RefusedError(NhtrackError):
    """Something that cannot be run as it is: nothing was run, and nothing written."""


class RobotError(NhtrackError):
    """A robot model that cannot be driven as a differential-drive robot."""


class RecordingError(NhtrackError):
    """A recording that cannot be read or lacks what was asked of it."""


class RenderError(NhtrackError):
    """A picture or film that cannot be made, with what is missing."""


class RefusedFilmError(RefusedError, RenderError):
    """A film that is not made as it was asked for."""


class WriteError(NhtrackError):
    """A file that could not be written; what had its name before still has it."""


class FeasibilityError(NhtrackError):
    """A scenario that no time scale makes feasible for its robots; names robot, time and quantity."""


@contextmanager
def noting(note: str) -> Iterator[None]:
    """Lets what stops the work within say what is kept of it, and how to go on."""
    try:
        yield
    except (WriteError, OSError, KeyboardInterrupt) as stopped:
        stopped.add_note(note)
        raise


class SimulationDiverged(NhtrackError):
    """A simulation left the region where its numbers mean anything.

    Attributes:
        robot: name of the first robot it happened to.
        time: simulated time on the robot's clock [s].
        reason: what happened, in words.
        batch: index of the simulation in its batch.
    """

    def __init__(self, reason: str, robot: str, time: float, batch: int = 0) -> None:
        self.reason, self.robot, self.time, self.batch = reason, robot, time, batch
        super().__init__(f"{reason}: robot {robot!r} at t = {time:.3f} s (simulation {batch})")

    def __reduce__(self) -> tuple[type[SimulationDiverged], tuple[str, str, float, int]]:
        """Returns how to make the error anew, so that it can cross from a worker process."""
        return type(self), (self.reason, self.robot, self.time, self.batch)


@dataclass(frozen=True)
class Fault:
    """One thing wrong in one place of a scenario file.

    Attributes:
        line: one-based line, 0 where the fault concerns the whole file.
        column: one-based column.
        key: dotted path of the key, such as `followers[0].start.pose`.
        message: what was given, what was expected, what is available.
    """

    line: int
    column: int
    key: str
    message: str


def _place(fault: Fault) -> tuple[int, int, str]:
    """Returns what faults are told in the order of; those of one place stay as they were found."""
    return fault.line, fault.column, fault.key


class ScenarioError(NhtrackError):
    """Everything wrong with a scenario, one line a fault, all of them at once; of very many the message has the first.

    Attributes:
        source: the file, or a word for text that came from elsewhere.
        faults: the faults, in the order of the file.
    """

    def __init__(self, source: str | Path, faults: Sequence[Fault]) -> None:
        self.source, self.faults = str(source), tuple(sorted(faults, key=_place))
        lines = [self._line(fault) for fault in self.faults[:_MOST_FAULTS]]
        if more := len(self.faults) - len(lines):
            lines.append(printable(f"{self.source}: and {more} more"))
        super().__init__("\n".join(lines))

    def __reduce__(self) -> tuple[type[ScenarioError], tuple[str, tuple[Fault, ...]]]:
        """Returns how to make the error anew, so that it can cross from a worker process."""
        return type(self), (self.source, self.faults)

    def _line(self, fault: Fault) -> str:
        where = f"{self.source}:{fault.line}:{fault.column}" if fault.line else self.source
        return printable(f"{where}: {fault.key}: {fault.message}" if fault.key else f"{where}: {fault.message}")


def printable(text: str) -> str:
    """Returns a text in one line, with an escape for each character that a screen would obey or cannot show."""
    return "".join(each if each.isprintable() else each.encode("unicode_escape").decode() for each in text)


def clipped(text: str) -> str:
    """Returns a text, or the beginning of one that is too long for a message."""
    return text if len(text) <= _LONGEST_NAME else f"{text[:_LONGEST_NAME]}..."


def did_you_mean(given: str, available: Iterable[str]) -> str:
    """Returns a clause for messages, naming the nearest available name and all of them, or the first of many."""
    names = [str(name) for name in available]
    nearest = difflib.get_close_matches(given[:_LONGEST_NAME], names, n=1, cutoff=0.5)
    hint = f"did you mean {nearest[0]!r}? " if nearest else ""
    rest = f" and {len(names) - _MOST_NAMES} more" if len(names) > _MOST_NAMES else ""
    return f"{hint}available: {', '.join(names[:_MOST_NAMES]) if names else 'none'}{rest}"
