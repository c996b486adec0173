"""Text files that are somebody else's: read where they are files of a bounded size that hold text."""

from __future__ import annotations

import os
from pathlib import Path

__all__ = ["TextError", "exists", "read_bytes", "read_text", "text_of"]


class TextError(ValueError):
    """A file that holds no text, or cannot be read.

    Attributes:
        reason: what is wrong, in words.
        line: from one, 0 where it is the whole file.
        column: from one.
    """

    def __init__(self, reason: str, line: int = 0, column: int = 0) -> None:
        self.reason, self.line, self.column = reason, line, column
        super().__init__(reason)

    @property
    def place(self) -> str:
        """What stands behind the file's name: `:line:column`, nothing where it is the whole file."""
        return f":{self.line}:{self.column}" if self.line else ""


def exists(path: Path) -> bool:
    """Returns whether there is something of a name, which need not be one that a file can have."""
    return os.path.exists(path)  # Path.exists raises where a name is too long


def _without_waiting(path: str, flags: int) -> int:
    """Returns a file opened such that none of the system's own, as /proc has them, is waited for."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def read_text(path: Path, most: int) -> str:
    """Returns the text of a file, with one kind of line end and without a byte order mark.

    Args:
        path: of the file; a pipe or a device, which may never end, is refused.
        most: bytes that it may have.

    Raises:
        TextError: it cannot be read, is too long, or is not UTF-8 text.
    """
    return text_of(read_bytes(path, most)).removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")


def read_bytes(path: Path, most: int) -> bytes:
    """Returns what a file holds.

    Args:
        path: of the file; a pipe or a device, which may never end, is refused.
        most: bytes that it may have.

    Raises:
        TextError: it cannot be read, or is too long.
    """
    if not exists(path):
        raise TextError("no such file")
    if not path.is_file():
        raise TextError("is a directory" if path.is_dir() else "is no regular file")
    try:
        with open(path, "rb", opener=_without_waiting) as file:
            data = file.read(most + 1)
    except OSError as error:
        raise TextError(f"cannot be read: {error.strerror}") from None
    if data is None:
        raise TextError("cannot be read: nothing is there yet")
    if len(data) > most:
        raise TextError(f"has more than {most / 1e6:g} MB")
    return data


def text_of(data: bytes) -> str:
    """Returns bytes as the text they are, with its line ends and any byte order mark.

    Raises:
        TextError: it is not UTF-8 text; with line and column.
    """
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        column = error.start - data.rfind(b"\n", 0, error.start)
        reason = f"not UTF-8 text (byte 0x{data[error.start]:02x}); save the file as UTF-8"
        raise TextError(reason, line, column) from None
