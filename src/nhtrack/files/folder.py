"""Results folders: found usable before work begins, never left with the files of two runs, each file written whole."""

from __future__ import annotations

import contextlib
import json
import tempfile
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from typing import Any

from nhtrack.errors import NhtrackError
from nhtrack.files.atomic import atomic_path, reason_of
from nhtrack.files.temporary import is_held, made_folder, remove_abandoned, temporary_folder

COMPARISON = "comparison.json"  # says which laws have folders of their own beside it
_RUN = ("recording.nc", "summary.json")


class OutputError(NhtrackError):
    """A results folder that cannot be used."""


@contextlib.contextmanager
def claimed_folder(name: str, out: Path | None, overwrite: bool) -> Iterator[Path]:
    """Yields a results folder that exists, can be written to, and is nobody else's as long as work goes on within.

    What fails leaves no empty folder behind; what a process that was killed left is removed with the next claim.

    Args:
        name: what the folder is called after where none is given: `runs/<name>-<n>/` with the first free n.
        out: the folder.
        overwrite: allow a folder that has files in it.

    Raises:
        OutputError: the folder has files in it, or another process works in it, or it cannot be written to.
    """
    with contextlib.ExitStack() as held:
        if out is None:
            out = _fresh(name, held)
        else:
            require_unused(out, overwrite)
            _claim(out, held)
        yield out


def require_free(file: Path, overwrite: bool) -> None:
    """Raises, before any work is done, where a file cannot be written or must not be replaced after it.

    Raises:
        OutputError: it exists, and `overwrite` does not allow it to be replaced; or nothing can be written there.
    """
    if file.exists() and not overwrite:
        raise OutputError(f"{file} exists; choose another --out, or --force to replace it")
    try:
        with tempfile.TemporaryFile(dir=next(folder for folder in file.absolute().parents if folder.exists())):
            pass
    except OSError as error:
        raise OutputError(f"cannot write {file}: {reason_of(error)}") from error


def _fresh(name: str, held: contextlib.ExitStack) -> Path:
    """Claims and returns `runs/<name>-<n>` with the first free n; two runs at once get two folders."""
    for n in count(1):
        folder = Path("runs") / f"{name}-{n}"
        if is_used(folder):
            continue
        with contextlib.ExitStack() as tried:
            claim = _claim(folder, tried)
            if list(folder.iterdir()) == [claim]:  # nobody took it at the same time
                held.enter_context(tried.pop_all())
                return folder
    raise AssertionError("numbers do not end")


def _claim(folder: Path, held: contextlib.ExitStack) -> Path:
    """Makes a folder that others see to be in use until the stack is closed; returns what they see."""
    try:
        held.enter_context(made_folder(folder))
        return held.enter_context(temporary_folder(folder))
    except OSError as error:
        raise OutputError(f"cannot write results into {folder}: {reason_of(error)}") from error


def require_unused(out: Path, overwrite: bool) -> None:
    """Removes from a results folder what processes that are gone left half-written, and has a look at the rest.

    Raises:
        OutputError: it is no folder, another process works in it, or there is something in it and it is not to be
            overwritten.
    """
    used = is_used(out)
    if used and is_held(out):
        raise OutputError(f"another process writes into {out}; choose another --out, or wait until it is done")
    if used and not overwrite:
        raise OutputError(f"{out} exists already; choose another --out, or --force to write into it")


def is_used(out: Path) -> bool:
    """Returns whether something has the name of a results folder, other than an empty folder; see `require_unused`."""
    if not out.is_dir():
        return out.exists()
    for inner in out.iterdir():
        if inner.is_dir() and remove_abandoned(inner):
            with contextlib.suppress(OSError):  # with something else in it, it stays
                inner.rmdir()
    remove_abandoned(out)
    return any(out.iterdir())


def clear(folder: Path, but: Path) -> None:
    """Removes the results of an earlier run or comparison, so that a folder never holds files of two.

    Args:
        folder: theirs.
        but: the first file of the next, which was written before: where that fails, the earlier ones stay.
    """
    files = [folder / name for name in (*_RUN, COMPARISON, "video.mp4", "report.html")]
    files += [figure for figure in (folder / "figures").glob("*.p*") if figure.suffix in (".png", ".pdf")]
    laws = _law_folders(folder)
    for file in (*files, *(law / name for law in laws for name in _RUN)):
        if file != but:
            file.unlink(missing_ok=True)
    for law in laws:
        with contextlib.suppress(OSError):  # with something else in it, it stays
            law.rmdir()


def _law_folders(folder: Path) -> list[Path]:
    """Returns the folders of the laws of an earlier comparison, as it says itself; no other run's is touched."""
    try:
        rows = json.loads((folder / COMPARISON).read_text())["laws"]
        named = [str(row["label"]) for row in rows]
    except (OSError, ValueError, KeyError, TypeError):  # none, or not one of ours
        return []
    return [folder / name for name in named if Path(name).name == name and (folder / name).is_dir()]


def save_json(path: Path, tree: Any) -> Path:
    """Writes a tree as indented JSON; the file appears under its name only once it is whole."""
    with atomic_path(path) as temporary:
        temporary.write_text(json.dumps(tree, indent=2, allow_nan=False) + "\n")
    return path
