"""Signals one after the other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nhtrack.references.contract import ReferenceInputError, Signal
from nhtrack.references.expression import make_signal


@dataclass(frozen=True)
class Segments:
    """Signals one after the other: `signals[i]` on [ends[i-1], ends[i]), and 0 after the last end.

    Attributes:
        ends: strictly increasing positive times, the last may be infinite, shape n.
        signals: what holds before each end, shape n.

    Raises:
        ReferenceInputError: ends that do not increase, or not as many ends as signals.
    """

    ends: tuple[float, ...]
    signals: tuple[Signal, ...]

    def __post_init__(self) -> None:
        if len(self.ends) != len(self.signals):
            raise ReferenceInputError(f"{len(self.ends)} ends for {len(self.signals)} segments")
        if any(not end > start for start, end in zip((0.0, *self.ends), self.ends, strict=False)):
            raise ReferenceInputError(f"segments must end at increasing times after 0, got {list(self.ends)}")

    def __call__(self, t: np.ndarray) -> np.ndarray:
        """Returns the values at the times `t`, both of shape (T,); a formula is asked in its segment only."""
        times = np.asarray(t, dtype=np.float64)
        # A control instant that rounding left just short of an end belongs to the next segment: pieces meant
        # to cancel (speed up for 1 s, brake for 1 s) then hold for equally many periods and stop the leader
        # exactly.
        ends = np.array(self.ends) * (1.0 - 1e-12)
        index = np.searchsorted(ends, times, side="right")
        values = np.zeros(times.shape)
        for i, signal in enumerate(self.signals):
            inside = index == i
            values[inside] = signal(times[inside])
        return values


def make_segments(segments: Sequence[tuple[float | None, float | str]]) -> Segments:
    """Returns the signal of (end, number or formula) pairs; the last end may be None, for ever."""
    if any(end is None for end, _ in segments[:-1]):
        raise ReferenceInputError("only the last segment may go without an end")
    ends = tuple(math.inf if end is None else float(end) for end, _ in segments)
    return Segments(ends, tuple(make_signal(value) for _, value in segments))
