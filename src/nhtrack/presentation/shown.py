"""What figures, films and reports of a recording agree on, whatever they are drawn with."""

from __future__ import annotations

from collections.abc import Iterable

from nhtrack.ground import Ground
from nhtrack.presentation.numbers import quantity, share
from nhtrack.recording import Recording
from nhtrack.settling import LATE, SettlingLimits

__all__ = ["CROWD", "Room", "Span", "covered", "ground_of", "settled_note", "short_name", "within"]

CROWD = 7  # more followers than this are drawn as a band: single curves could no longer be told apart

Span = tuple[float, float]  # start and end [s]
Room = tuple[float, float, float, float]  # a part of the floor: x_min, x_max, y_min, y_max [m]


def covered(spans: Iterable[Span]) -> list[Span]:
    """Returns the time that spans (start, end) cover, as spans in order that neither touch nor overlap."""
    apart: list[Span] = []
    for start, end in sorted(spans):
        if apart and start <= apart[-1][1]:
            apart[-1] = (apart[-1][0], max(end, apart[-1][1]))
        else:
            apart.append((start, end))
    return apart


def ground_of(recording: Recording) -> Ground:
    """Returns what the robots of a recording stood on."""
    return recording.scene.ground if recording.has_scene else Ground()


def short_name(name: str) -> str:
    """Returns the number at the end of a robot's name, or its first letter."""
    return name[len(name.rstrip("0123456789")) :] or name[0]


def within(limits: SettlingLimits) -> str:
    """Returns within which errors a follower has settled: `within 10 mm and 20 mrad`."""
    return f"within {quantity(limits.position, 'm')} and {quantity(limits.heading, 'rad')}"


def settled_note(limits: SettlingLimits) -> str:
    """Returns what *settled* means, for the note of a table; see `nhtrack.settling`."""
    return f"settled: {within(limits)} of its place until the end, for {share(LATE)} of the run or longer"
