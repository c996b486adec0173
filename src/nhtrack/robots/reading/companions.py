"""The files that a robot is read from: its own, what that includes, meshes and pictures."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from pathlib import Path

from nhtrack.files.carried import read_at
from nhtrack.files.text import exists
from nhtrack.mjcf.files import FILES
from nhtrack.robots.contract import ROBOT_FILES
from nhtrack.robots.reading.bounds import elements, text_of
from nhtrack.robots.reading.files import find_file
from nhtrack.robots.reading.urdf import urdf_text

__all__ = ["files_of"]

_FOLDERS = ("assetdir", "meshdir", "texturedir")


def files_of(path: Path) -> frozenset[Path]:
    """Returns the files that are there and may be read with a robot, rather too many than too few.

    Args:
        path: of its file, or of a folder that holds it.

    Raises:
        RobotError: it cannot be found, or not be read as text.
    """
    found, texts, folders, names = set(_beside(path)), [find_file(path)], set[Path](), set[str]()
    main = texts[0]
    while texts:
        text = texts.pop()
        found.add(text)
        folders.add(text.parent)
        for tag, given in _elements(text):
            files = [given[name] for name in (*FILES, "filename") if name in given]
            named = [given[name] for name in _FOLDERS if tag == "compiler" and name in given]
            folders |= {folder / name for folder in (main.parent, text.parent) for name in named}
            names |= set(files)
            if tag in ("include", "model"):
                inside = {_at(folder, name) for folder in (main.parent, text.parent) for name in files}
                texts += [each for each in inside - found - set(texts) if _is_file(each)]
    for name in names:
        own = {_at(folder, each) for folder in folders for each in (name, Path(name).name)}
        found |= {each for each in own if _is_file(each)}
    return frozenset(found)


def _beside(path: Path) -> Iterator[Path]:
    """Yields the files among which a robot is looked for in a folder."""
    if path.is_dir():
        yield from (each for each in path.iterdir() if each.suffix.lower() in ROBOT_FILES and each.is_file())


def _elements(file: Path) -> Iterator[tuple[str, Mapping[str, str]]]:
    """Yields the elements of a file with their attributes; in a URDF packages are full paths."""
    text = text_of(file, file)
    try:
        root = ET.fromstring(text)
    except ET.ParseError:
        root = None  # MuJoCo reads what is not quite XML
    if root is not None and root.tag == "robot":
        text, _ = urdf_text(root, file)
    yield from elements(text)


def _at(folder: Path, name: str) -> Path:
    """Returns where a file that a folder's file names is read, spelled in one way."""
    return read_at(Path(os.path.normpath(folder / name)))


def _is_file(path: Path) -> bool:
    return exists(path) and path.is_file()
