"""Imports the file of a law that is no module of an installed package."""

from __future__ import annotations

import hashlib
import sys
import traceback
from pathlib import Path
from types import ModuleType

from nhtrack.errors import RefusedError
from nhtrack.files.carried import read_at
from nhtrack.files.text import TextError, exists, read_bytes, text_of

_MOST_BYTES = 10**6
_MARK = "\ufeff"  # that some editors begin a file with


class LawError(RefusedError):
    """A law's file that does not keep the contract of `nhtrack.laws.contract`, or a law that fails while it runs."""


def read_source(path: str | Path) -> tuple[Path, str]:
    """Returns the full path of a law's file, and its text.

    Raises:
        LawError: no such file, or no text.
    """
    at = read_at(Path(path))
    if not exists(at):
        raise LawError(f"{path}: no such file")
    file = Path(path).resolve()
    try:
        return file, text_of(read_bytes(at, _MOST_BYTES))  # its hash is that of the file: line ends stay
    except TextError as error:
        raise LawError(f"{file}{error.place}: {error}") from error


def import_source(file: Path, source: str) -> ModuleType:
    """Returns the module of a law's text, under a name of its own; nothing is written beside the file.

    Raises:
        LawError: it cannot be imported; with file and line.
    """
    name = f"nhtrack_own_{file.stem}_{hashlib.sha256(f'{file}{source}'.encode()).hexdigest()[:12]}"
    module = ModuleType(name)
    module.__file__ = str(file)
    sys.modules[name] = module  # where type hints look for it
    try:
        exec(compile(source.lstrip(_MARK), str(file), "exec"), module.__dict__)
    except BaseException as error:
        del sys.modules[name]
        if not isinstance(error, Exception):
            raise
        raise LawError(f"{place_of(error, str(file))}: {_said(error)}") from error
    return module


def place_of(error: BaseException, file: str, line: int | None = None) -> str:
    """Returns `file:line` of the last line of a law's file that an error came through.

    Args:
        error: what was raised.
        file: the law's.
        line: where it is if no line of the file was come through.
    """
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == file]
    if isinstance(error, SyntaxError) and error.filename == file:
        lines.append(error.lineno)
    found = lines[-1] if lines else line
    return file if found is None else f"{file}:{found}"


def _said(error: Exception) -> str:
    if isinstance(error, SyntaxError):
        return f"{error.msg}"
    said = f"{type(error).__name__}: {error}"
    if isinstance(error, ModuleNotFoundError):
        said += "; a law is one file, and what it imports must be installed"
    return said
