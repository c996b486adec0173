"""Bounds on what a robot's file may make of a few words, and on the files that it includes."""

from __future__ import annotations

import math
import re
from pathlib import Path

from nhtrack.errors import RobotError
from nhtrack.files.text import TextError, read_text

__all__ = ["bounded_text"]

_MOST_BYTES = 20 * 10**6  # of a file, without its meshes
_MOST_FILES = 100  # that it includes
_MOST_REPEATED = 10_000  # elements that a file asks for by their number
_MOST_PIXELS = 2e7  # of a picture or a height field that a file asks for by its size
_REPEATED = re.compile(r'<(?:replicate|composite|flexcomp)\b[^>]*?\bcount\s*=\s*["\']([^"\']*)')
_SIZES = re.compile(r"<(?:texture|hfield)\b[^>]*>")
_SIZE = re.compile(r'\b(?:width|height|nrow|ncol)\s*=\s*["\']\s*([0-9.eE+]+)')
_INCLUDED = re.compile(r'<include\b[^>]*?\bfile\s*=\s*["\']([^"\']*)')


def bounded_text(file: Path) -> str:
    """Returns the text of a robot's file, which with all that it includes asks for no more than the bounds.

    Raises:
        RobotError: it cannot be read, or asks for more.
    """
    text = _text(file, file)
    folder, waiting, seen, repeated = file.absolute().parent, [text], {file.absolute()}, 1.0
    while waiting:
        said = waiting.pop()
        repeated *= math.prod(_number(word) for counts in _REPEATED.findall(said) for word in counts.split())
        if repeated > _MOST_REPEATED:
            raise RobotError(f"{file}: asks for {repeated:.3g} repeated elements, more than {_MOST_REPEATED}")
        for element in _SIZES.findall(said):
            if (size := math.prod(map(_number, _SIZE.findall(element)))) > _MOST_PIXELS:
                raise RobotError(f"{file}: asks for {size:.3g} points in one element, more than {_MOST_PIXELS:g}")
        for name in _INCLUDED.findall(said):
            included = folder / name
            if included not in seen:
                seen.add(included)
                waiting.append(_text(included, file))
        if len(seen) > _MOST_FILES:
            raise RobotError(f"{file}: includes more than {_MOST_FILES} files")
    return text


def _text(path: Path, file: Path) -> str:
    try:
        return read_text(path, _MOST_BYTES)
    except TextError as error:
        at = f":{error.line}:{error.column}" if error.line and path == file else ""
        what = "" if path == file else f"includes {path}, which "
        raise RobotError(f"{file}{at}: {what}{'cannot be read: ' if path == file else ''}{error.reason}") from None


def _number(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        return 1.0  # told by MuJoCo
