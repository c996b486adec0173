"""Bounds on what a robot's file may make of a few words, and on the files that it includes."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from html import unescape
from pathlib import Path

from nhtrack.errors import RobotError
from nhtrack.files.text import TextError, read_text

__all__ = ["bounded_text", "elements", "text_of"]

_MOST_BYTES = 20 * 10**6  # of a file, without its meshes
_MOST_FILES = 100  # that it includes
_MOST_REPEATED = 10_000  # elements that a file asks for by their number
_MOST_POINTS = 2e7  # of a picture, a height field, an array that a file asks for by its size
_MOST_CUTS = 300  # into which a file asks for a mesh to be cut along each of its sides
_MOST_MEMORY = 2**30  # bytes that it sets aside
_REPEATED = ("replicate", "composite", "flexcomp")
_SIZES = {
    "texture": ("width", "height"), "hfield": ("nrow", "ncol"), "numeric": ("size",), "user": ("dim",),
}  # fmt: skip
_ASKING = frozenset((*_REPEATED, *_SIZES, "include", "size", "mesh"))
_UNITS = {unit: 1024**power for power, unit in enumerate("KMGTPE", start=1)}
# Comments and the like are passed over; a tag's attributes may hold `>`. Nothing is looked at twice.
_TAG = re.compile(
    r"<!--(?:.*?-->|.*)|<!\[CDATA\[(?:.*?\]\]>|.*)|<\?(?:.*?\?>|.*)"
    r"|<([A-Za-z_][\w:.-]*+)((?:[^<>\"']++|\"[^\"]*\"|'[^']*')*+)",
    re.DOTALL,
)
_ATTRIBUTE = re.compile(r"(?<![\w:.-])([\w:.-]++)\s*+=\s*+(?:\"([^\"]*)\"|'([^']*)')")


def bounded_text(file: Path) -> str:
    """Returns the text of a robot's file, which with all that it includes asks for no more than the bounds.

    Raises:
        RobotError: it cannot be read, or asks for more.
    """
    text = text_of(file, file)
    folder, waiting, seen, repeated = file.absolute().parent, [text], {file.absolute()}, 1.0
    while waiting:
        for tag, given in _asking(waiting.pop()):
            if tag in _REPEATED:
                repeated *= math.prod(map(_number, given.get("count", "").split()))
            if repeated > _MOST_REPEATED:
                raise RobotError(f"{file}: asks for {repeated:.3g} repeated elements, more than {_MOST_REPEATED}")
            for said in _too_much(tag, given):
                raise RobotError(f"{file}: asks for {said}")
            if tag == "include" and (included := folder / given.get("file", "")) not in seen:
                seen.add(included)
                waiting.append(text_of(included, file))
            if len(seen) > _MOST_FILES:
                raise RobotError(f"{file}: includes more than {_MOST_FILES} files")
    return text


def elements(text: str) -> Iterator[tuple[str, Mapping[str, str]]]:
    """Yields the elements of an XML text by their names, with their attributes."""
    for found in _TAG.finditer(text):
        if found[1]:
            yield found[1], _attributes(found[2])


def _asking(text: str) -> Iterator[tuple[str, Mapping[str, str]]]:
    """Yields the elements of an XML text that may ask for much."""
    for found in _TAG.finditer(text):
        if found[1] in _ASKING or (found[2] and "nsample" in found[2]):
            yield found[1], _attributes(found[2])


def _attributes(text: str) -> Mapping[str, str]:
    return {name: unescape(one or other) for name, one, other in _ATTRIBUTE.findall(text)}


def _too_much(tag: str, given: Mapping[str, str]) -> Iterator[str]:
    """Yields what an element asks for beyond the bounds."""
    asked = [_number(given[name]) for name in _SIZES.get(tag, ()) if name in given]
    asked = [math.prod(asked), _number(given.get("nsample", "0"))]
    if tag == "size":
        asked = [_number(value) for name, value in given.items() if name != "memory"]
        if (memory := _bytes(given.get("memory", "0"))) > _MOST_MEMORY:
            yield f"{memory:.3g} bytes, more than {_MOST_MEMORY:.3g}"
    if (most := max(asked, default=0)) > _MOST_POINTS:
        yield f"{most:.3g} points in one element, more than {_MOST_POINTS:g}"
    if tag == "mesh" and "builtin" in given:
        cuts = max(map(_number, given.get("params", "").split()), default=0)
        if cuts > _MOST_CUTS:
            yield f"a mesh of {cuts:.3g} cuts, more than {_MOST_CUTS}"


def text_of(path: Path, file: Path) -> str:
    """Returns the text of a file that a robot's file includes, or of the robot's file itself.

    Raises:
        RobotError: it cannot be read.
    """
    try:
        return read_text(path, _MOST_BYTES)
    except TextError as error:
        at = error.place if path == file else ""
        what = "" if path == file else f"includes {path}, which "
        raise RobotError(f"{file}{at}: {what}{'cannot be read: ' if path == file else ''}{error.reason}") from None


def _number(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        return 1.0  # told by MuJoCo


def _bytes(word: str) -> float:
    unit = word.strip()[-1:].upper()
    return _number(word.strip()[:-1]) * _UNITS[unit] if unit in _UNITS else _number(word)
