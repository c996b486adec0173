"""Reads an MJCF file, what it includes and the files that it speaks of."""

from __future__ import annotations

import hashlib
import xml.etree.ElementTree as ET
from pathlib import Path

from nhtrack.errors import RobotError

__all__ = ["FILES", "UNREADABLE", "read", "read_text"]

FILES = ("file", "fileback", "filedown", "filefront", "fileleft", "fileright", "fileup")  # attributes that name one
_FOLDERS = {"mesh": "meshdir", "skin": "meshdir", "hfield": "meshdir", "texture": "texturedir"}
# Elements that stand for others, whose names MuJoCo would make up, or that only a plug-in understands.
UNREADABLE = ("attach", "composite", "deformable", "extension", "flexcomp", "model", "plugin", "replicate")


def read(file: Path) -> tuple[ET.Element, dict[str, bytes]]:
    """Returns the root element of an MJCF file and the contents of the files that it speaks of, by name.

    A file's name in MJCF becomes that of its contents, so that files of two robots are never taken for each other.

    Raises:
        RobotError: it is no MJCF, or has elements that cannot be attached under another name.
        OSError: a file cannot be read.
    """
    return _with_files(_parsed(file, file.parent), file)


def read_text(text: str) -> tuple[ET.Element, dict[str, bytes]]:
    """Returns what `read` does, of an MJCF text whose files have full paths."""
    return _with_files(ET.fromstring(text), Path("/"))


def _with_files(root: ET.Element, file: Path) -> tuple[ET.Element, dict[str, bytes]]:
    found = sorted({each.tag for each in root.iter()} & set(UNREADABLE))
    if found:
        raise RobotError(
            f"{file}: cannot read {', '.join(f'<{tag}>' for tag in found)} without dm_control, which Python 3.12 and "
            "older have; write out what it stands for, as MuJoCo does when it saves a model"
        )
    folders: dict[str, str] = {}
    for compiler in root.findall("compiler"):
        both = compiler.attrib.pop("assetdir", "")
        folders |= {name: compiler.attrib.pop(name, both) for name in ("meshdir", "texturedir")}
    assets: dict[str, bytes] = {}
    for element in root.iterfind("asset/*"):
        for name in set(FILES) & set(element.attrib):
            source = file.parent / folders.get(_FOLDERS.get(element.tag, ""), "") / element.attrib[name]
            data = source.read_bytes()
            kept = f"{source.stem}-{hashlib.sha1(data, usedforsecurity=False).hexdigest()}{source.suffix}"
            if name == "file" and "name" not in element.attrib:
                element.set("name", source.stem)
            element.set(name, kept)
            assets[kept] = data
    return root, assets


def _parsed(file: Path, folder: Path) -> ET.Element:
    """Returns the root element of a file, with the elements of the files that it includes in their places."""
    try:
        root = ET.fromstring(file.read_bytes())
    except ET.ParseError as error:
        raise RobotError(f"{file}: no XML: {error}") from error
    if root.tag not in ("mujoco", "mujocoinclude"):
        raise RobotError(f"{file}: expected <mujoco>, got <{root.tag}>")
    for parent in list(root.iter()):
        for place, child in reversed(list(enumerate(parent))):
            if child.tag == "include":
                parent[place : place + 1] = list(_parsed(folder / child.attrib["file"], folder))
    return root
