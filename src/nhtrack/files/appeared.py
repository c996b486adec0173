"""Files that other machines have written, seen here."""

from __future__ import annotations

import os
import time
from collections.abc import Iterable
from pathlib import Path

from nhtrack.errors import WriteError

_PATIENCE = 90.0  # [s] that a shared disk may take to show a file: NFS asks its server once a minute by default
_AGAIN = 0.5  # [s]


def wait_for(files: Iterable[Path]) -> None:
    """Waits until files are seen that have been written, on a disk that shows them late.

    Raises:
        WriteError: one is not seen.
    """
    until = time.monotonic() + _PATIENCE
    missing = [file for file in files if not file.exists()]
    while missing:
        if time.monotonic() > until:
            raise WriteError(f"{missing[0]} was written by another machine and is not here: do they share its folder?")
        time.sleep(_AGAIN)
        for folder in {file.parent for file in missing}:
            os.listdir(folder)  # which asks the server, where the file's name alone would not
        missing = [file for file in missing if not file.exists()]
