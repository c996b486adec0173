"""Files of one machine on another: copies travel with a task, and are read there in place of what they are copies of.

Names stay those of the files that were copied: in scenarios, in tables and, by `as_named`, in messages.
"""

from __future__ import annotations

import atexit
import hashlib
import os
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from nhtrack.files.temporary import temporary_folder

__all__ = ["Carried", "as_named", "carried", "read_at"]

_read: ContextVar[tuple[Path, Carried] | None] = ContextVar("read", default=None)  # copies, and the folder they lie in


@dataclass(frozen=True)
class Carried:
    """Copies of files.

    Attributes:
        contents: bytes of each by its full path, in arrays, which a worker may share and need not copy.
        identity: a hash of them.
    """

    contents: Mapping[str, np.ndarray[Any, np.dtype[np.uint8]]] = field(compare=False)
    identity: str

    @contextmanager
    def here(self) -> Iterator[None]:
        """Lets the copies be read within, in place of files of the same paths, be there such or not."""
        before = _read.set((_unpacked(self), self))
        try:
            yield
        finally:
            _read.reset(before)


def carried(files: Iterable[Path]) -> Carried:
    """Returns copies of files, as they are now.

    Raises:
        OSError: one cannot be read.
    """
    contents = {os.path.abspath(file): np.frombuffer(file.read_bytes(), np.uint8) for file in sorted(files)}
    digest = hashlib.sha256()
    for name, data in contents.items():
        digest.update(os.fsencode(name) + f"\0{len(data)}\0".encode() + data.tobytes())
    return Carried(contents, digest.hexdigest())


def read_at(path: Path) -> Path:
    """Returns where a file or folder is to be read: at its copy where it was copied, else at the path itself."""
    if (read := _read.get()) is None:
        return path
    root, files = read
    name = os.path.abspath(path)
    copy = _copy_of(root, name)
    return copy if name in files.contents or copy.is_dir() else path


def as_named(text: str) -> str:
    """Returns a message with the names of files in place of those of their copies."""
    read = _read.get()
    return text if read is None else text.replace(str(read[0]), "")


def _copy_of(root: Path, path: str) -> Path:
    return Path(f"{root}{path}")


_kept = ExitStack()
atexit.register(_kept.close)


@cache
def _unpacked(files: Carried) -> Path:
    """Returns a folder with the copies, each at its full path below it; it goes with this process."""
    root = _kept.enter_context(temporary_folder(Path(tempfile.gettempdir())))
    for name, data in files.contents.items():
        copy = _copy_of(root, name)
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes(data.tobytes())
    return root
