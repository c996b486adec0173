"""What runs read beside the package: laws, robots and tables of the user's own, and laws that are installed."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from nhtrack.errors import NhtrackError
from nhtrack.files.carried import as_named, read_at
from nhtrack.laws import laws
from nhtrack.robots.contract import ROBOT_FILES, Hints, is_robot_file
from nhtrack.robots.reading.companions import files_of
from nhtrack.robots.reading.files import load_source

__all__ = ["files_read", "fingerprint", "is_file_name", "outline", "sources_in"]

_COUNTS = ("nbody", "ngeom", "nmesh", "nmeshvert", "nmeshface", "ntex", "ntexdata", "nhfield", "nhfielddata")


def sources_in(*trees: Any) -> tuple[str, ...]:
    """Returns what plain trees name that runs read, sorted: files by their full paths, installed laws by name."""
    return tuple(sorted(set(_named(trees))))


def _named(tree: Any) -> Iterator[str]:
    if isinstance(tree, Mapping | list | tuple):
        for value in tree.values() if isinstance(tree, Mapping) else tree:
            yield from _named(value)
    elif isinstance(tree, str) and (_installed_law(tree) or (is_file_name(tree) and os.path.exists(tree))):
        yield tree


def is_file_name(source: str) -> bool:
    """Returns whether a text is the full path of what may be a file, rather than the name of a law."""
    return os.path.isabs(source) and "\0" not in source


def _installed_law(name: str) -> str:
    """Returns the hash of a law that scenarios may name and that is not the package's own; empty of all else."""
    kind = laws().get(name)
    return "" if kind is None or kind.built_in else kind.hash


def files_read(source: str) -> frozenset[Path]:
    """Returns the files that are read where one is named, such as meshes with a robot; none for a law by its name."""
    path = Path(source)
    try:
        found = files_of(path) if _may_be_robot(path) else frozenset[Path]()
    except (NhtrackError, OSError):  # no robot, so nothing is read with it
        found = frozenset()
    alone = frozenset([path] if is_file_name(source) and path.is_file() else [])
    return frozenset(file for file in found or alone if os.access(file, os.R_OK))


def _may_be_robot(path: Path) -> bool:
    return is_robot_file(str(path)) and (path.suffix.lower() in ROBOT_FILES or path.is_dir())


def fingerprint(source: str) -> str:
    """Returns a hash of what is read where a file is named, or of the law of a name; empty of what is not there.

    It is one of contents only, so that it is the same on every processor.
    """
    if not is_file_name(source):
        return _installed_law(source)
    try:
        contents = [file.read_bytes() for file in sorted(files_read(str(read_at(Path(source)))))]
    except OSError:
        return ""
    hashes = b"".join(hashlib.sha256(content).digest() for content in contents)
    return hashlib.sha256(hashes).hexdigest() if contents else ""


def outline(source: str) -> str:
    """Returns how much a robot's file comes to with all that it names, and what was not found; empty of what is none.

    It is made of whole numbers, and needs none of the hints that the robot may need.
    """
    at = read_at(Path(source))
    if not is_file_name(source) or not _may_be_robot(at):
        return ""
    try:
        robot = load_source(at, Hints())
    except (NhtrackError, OSError) as error:
        return as_named(str(error))
    counts = (getattr(robot.model, name) for name in _COUNTS)
    return as_named(f"{[int(count) for count in counts]} {robot.notes}")
