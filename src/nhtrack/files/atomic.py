"""Files that appear under their names only once they are whole."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

__all__ = ["atomic_path"]


class atomic_path:  # noqa: N801 - reads as a function in a with statement
    """Context manager that yields a temporary path beside the target.

    On success the file takes the target's name in one step; on failure it is removed and the target is as it
    was.
    """

    def __init__(self, target: Path) -> None:
        self._target = target

    def __enter__(self) -> Path:
        self._target.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(
            dir=self._target.parent, prefix=f".{self._target.stem}-", suffix=self._target.suffix
        )
        os.close(handle)
        self._temporary = Path(name)
        return self._temporary

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            umask = os.umask(0)
            os.umask(umask)
            self._temporary.chmod(0o666 & ~umask)  # mkstemp makes files private; a result is an ordinary file
            try:
                os.replace(self._temporary, self._target)
            except OSError:
                self._temporary.unlink(missing_ok=True)
                raise
        else:
            self._temporary.unlink(missing_ok=True)
