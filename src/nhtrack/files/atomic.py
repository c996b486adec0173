"""Files that appear under their names only once they are whole."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from nhtrack.files.temporary import temporary_folder

__all__ = ["atomic_path"]


@contextmanager
def atomic_path(target: Path) -> Iterator[Path]:
    """Yields a temporary path on the target's disk.

    On success the file there takes the target's name in one step; on failure it is removed and the target is as it was.
    A process that is killed leaves a hidden folder, which the next one that writes beside the target removes.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    with temporary_folder(target.parent) as folder:
        yield folder / target.name
        os.replace(folder / target.name, target)
