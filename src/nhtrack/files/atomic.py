"""Files that appear under their names only once they are whole."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from nhtrack.errors import WriteError
from nhtrack.files.temporary import made_folder, temporary_folder

__all__ = ["atomic_path", "reason_of"]


@contextmanager
def atomic_path(target: Path) -> Iterator[Path]:
    """Yields a temporary path on the target's disk.

    On success the file there takes the target's name in one step; on failure it is removed and the target is as it was.
    A process that is killed leaves a hidden folder, which the next one that writes beside the target removes.

    Raises:
        WriteError: the disk is full, or the file may not be written there.
    """
    try:
        with made_folder(target.parent), temporary_folder(target.parent) as folder:
            yield folder / target.name
            os.replace(folder / target.name, target)
    except BrokenPipeError:  # of something else
        raise
    except OSError as error:
        raise WriteError(f"cannot write {target}: {reason_of(error)}") from error


def reason_of(error: OSError) -> str:
    """Returns why something could not be written, in the system's words."""
    return str(error) if error.errno is None else os.strerror(error.errno)
