"""Results folders: found usable before work begins, never left with the files of two runs, each file written whole."""

from __future__ import annotations

import contextlib
import json
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from nhtrack.errors import NhtrackError
from nhtrack.files.atomic import atomic_path
from nhtrack.files.temporary import remove_abandoned

COMPARISON = "comparison.json"  # says which laws have folders of their own beside it
_RUN = ("recording.nc", "summary.json")


class OutputError(NhtrackError):
    """A results folder that cannot be used."""


@contextlib.contextmanager
def claimed_folder(name: str, out: Path | None, overwrite: bool) -> Iterator[Path]:
    """Yields a results folder that exists and can be written to; what fails within leaves no empty folder behind.

    Args:
        name: what the folder is called after where none is given: `runs/<name>-<n>/` with the first free n.
        out: the folder.
        overwrite: allow a folder that has files in it.

    Raises:
        OutputError: the folder has files in it, or cannot be written to.
    """
    folder = fresh_folder(name) if out is None else _claimed(out, overwrite)
    try:
        yield folder
    except BaseException:
        with contextlib.suppress(OSError):  # nor touch one that is not empty
            folder.rmdir()
            if out is None:
                folder.parent.rmdir()
        raise


def require_free(file: Path, overwrite: bool) -> None:
    """Raises, before any work is done, where a file must not be replaced after it.

    Raises:
        OutputError: it exists, and `overwrite` does not allow it to be replaced.
    """
    if file.exists() and not overwrite:
        raise OutputError(f"{file} exists; choose another --out, or --force to replace it")


def fresh_folder(name: str) -> Path:
    """Makes and returns `runs/<name>-<n>` with the first free n; two runs at once get two folders."""
    parent = Path("runs")
    parent.mkdir(exist_ok=True)
    n = 1
    while True:
        folder = parent / f"{name}-{n}"
        try:
            folder.mkdir()
        except FileExistsError:
            n += 1
        else:
            return folder


def _claimed(out: Path, overwrite: bool) -> Path:
    """Returns a results folder that exists and can be written to, found out before anything is run."""
    require_unused(out, overwrite)
    try:
        out.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=out):
            pass
    except OSError as error:
        raise OutputError(f"cannot write results into {out}: {error.strerror}") from error
    return out


def require_unused(out: Path, overwrite: bool) -> None:
    """Removes from a results folder what processes that are gone left half-written, and has a look at the rest.

    Raises:
        OutputError: it is no folder, or there is something in it and it is not to be overwritten.
    """
    if is_used(out) and not overwrite:
        raise OutputError(f"{out} exists already; choose another --out, or --force to write into it")


def is_used(out: Path) -> bool:
    """Returns whether something has the name of a results folder, other than an empty folder; see `require_unused`."""
    if not out.is_dir():
        return out.exists()
    for folder in (out, *(inner for inner in out.iterdir() if inner.is_dir())):
        remove_abandoned(folder)
    return any(out.iterdir())


def clear(folder: Path) -> None:
    """Removes the results of an earlier run or comparison, so that a folder never holds files of two."""
    for law in _law_folders(folder):
        for name in _RUN:
            (law / name).unlink(missing_ok=True)
        with contextlib.suppress(OSError):  # with something else in it, it stays
            law.rmdir()
    for name in (*_RUN, COMPARISON, "video.mp4", "report.html"):
        (folder / name).unlink(missing_ok=True)
    for figure in (folder / "figures").glob("*.p*"):
        if figure.suffix in (".png", ".pdf"):
            figure.unlink()


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
