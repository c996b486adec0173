"""What runs read beside the package: laws, robots and tables of the user's own, and laws that are installed."""

from __future__ import annotations

import hashlib
import os
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from nhtrack.errors import NhtrackError
from nhtrack.files.carried import read_at
from nhtrack.laws import laws
from nhtrack.mjcf.files import read_text
from nhtrack.robots.contract import ROBOT_FILES, is_robot_file
from nhtrack.robots.reading.companions import files_of
from nhtrack.simulation.robot_models import load_robot

__all__ = ["files_read", "fingerprint", "is_file_name", "sources_in"]


def sources_in(tree: Any) -> Iterator[str]:
    """Yields what a plain tree names that runs read: files by their full paths, installed laws by their names."""
    if isinstance(tree, Mapping):
        for value in tree.values():
            yield from sources_in(value)
    elif isinstance(tree, list | tuple):
        for value in tree:
            yield from sources_in(value)
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
    if _may_be_robot(path):
        try:
            return files_of(path)
        except NhtrackError:  # no robot, so nothing is read with it
            pass
    return frozenset([path] if is_file_name(source) and path.is_file() else [])


def _may_be_robot(path: Path) -> bool:
    return is_robot_file(str(path)) and (path.suffix.lower() in ROBOT_FILES or path.is_dir())


def fingerprint(source: str) -> str:
    """Returns a hash of what runs depend on, of a robot with all that it is read from; empty of what is not there."""
    if not is_file_name(source):
        return _installed_law(source)
    at = read_at(Path(source))
    try:
        contents = [each.read_bytes() for each in sorted(files_read(str(at)))]
    except OSError:
        return ""
    if not contents:
        return ""
    digest = hashlib.sha256()
    for content in (*contents, (_standard_form(source) if _may_be_robot(at) else "").encode()):
        digest.update(hashlib.sha256(content).digest())
    return digest.hexdigest()


def _standard_form(robot: str) -> str:
    """Returns the standard form of a robot, in which files have the names of their contents; empty of what is none.

    What its copy does not find, such as a file that it includes by a full path, shows here.
    """
    try:
        root, _ = read_text(load_robot(robot).mjcf)
    except (NhtrackError, OSError, ValueError):
        return ""  # none, or read with hints only
    return ET.tostring(root, encoding="unicode")
