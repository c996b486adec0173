"""What a kind of robot defines: how one is read from a file that somebody else wrote.

A robot is read once and written down in one standard form, an MJCF text of our own (`nhtrack.robots.reading.standard`),
which is all that scenes, effects and films see. A kind is a folder of this room with a module `reading` that defines
`KIND`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from nhtrack.robots.contract import Parts
from nhtrack.robots.diff_drive.model import DiffDrive
from nhtrack.robots.reading.source import Source

__all__ = ["Kind", "Reading"]


@dataclass(frozen=True)
class Reading:
    """A robot as it was read.

    Attributes:
        file: its file.
        kind: what sort of robot it is.
        mjcf: its standard form; files of meshes and textures by their full paths.
        parts: names in it.
        model: the reduced model.
        sources: what each was read from, by what was read: `left tyre` from `geom 'tyre' (line 30)`.
        notes: what was left out or taken otherwise than the file has it, a sentence each.
    """

    file: Path
    kind: str
    mjcf: str
    parts: Parts
    model: DiffDrive
    sources: Mapping[str, str]
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Kind:
    """A kind of robot.

    Attributes:
        name: its folder.
        read: returns a robot of this kind as it was read; raises RefusedRobot for all others.
    """

    name: str
    read: Callable[[Source], Reading]
