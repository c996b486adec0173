"""Temporary folders that go with the process that made them.

A process that is killed removes nothing, so who works in a place removes first what those left there that are gone.
Each folder holds a file that its process keeps locked (`flock`): the system unlocks it when the process ends, in
whatever way and on whatever machine shares the disk, which a process number would not tell. Where files cannot be
locked nothing is removed.
"""

from __future__ import annotations

import fcntl
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from secrets import token_hex

__all__ = ["is_held", "made_folder", "remove_abandoned", "temporary_folder"]

_PREFIX, _LOCK = ".nhtrack-", "lock"


@contextmanager
def temporary_folder(parent: Path) -> Iterator[Path]:
    """Yields a hidden folder inside another, which is removed at the end, after those of processes that are gone."""
    remove_abandoned(parent)
    folder, lock = parent / f"{_PREFIX}{token_hex(8)}", None
    try:
        lock = _made(folder)
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        if lock is not None:
            os.close(lock)


@contextmanager
def made_folder(folder: Path) -> Iterator[None]:
    """Makes a folder where there is none; one that was made and is empty after a failure is removed."""
    made = [each for each in (folder, *folder.parents) if not each.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    try:
        yield
    except BaseException:
        for each in made:
            with suppress(OSError):  # with something in it, it stays
                each.rmdir()
        raise


def remove_abandoned(parent: Path) -> bool:
    """Removes the temporary folders in a folder whose processes are gone; returns whether there were any."""
    found = False
    for folder in parent.glob(f"{_PREFIX}*"):
        try:
            lock = _locked(folder)
        except OSError:  # its process works still, or nobody can tell
            continue
        found = True
        shutil.rmtree(folder, ignore_errors=True)
        os.close(lock)
    return found


def is_held(parent: Path) -> bool:
    """Returns whether another process works in a folder, once what those left that are gone has been removed."""
    return any(parent.glob(f"{_PREFIX}*/{_LOCK}"))


def _made(folder: Path) -> int | None:
    """Makes a folder and returns its lock, or None where files cannot be locked."""
    while True:
        folder.mkdir(mode=0o700, exist_ok=True)
        try:
            return _locked(folder)
        except (BlockingIOError, FileNotFoundError):  # another took it for abandoned before it was locked
            continue
        except OSError:
            return None


def _locked(folder: Path) -> int:
    """Returns the lock of a folder, held until it is closed.

    Raises:
        BlockingIOError: another holds it.
        OSError: the folder is gone, or files cannot be locked here.
    """
    path = folder / _LOCK
    lock = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if not os.path.samestat(os.fstat(lock), path.stat()):
            raise FileNotFoundError(path)
    except OSError:
        os.close(lock)
        raise
    return lock
