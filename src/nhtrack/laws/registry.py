"""The laws there are: the package's own, those of installed packages, and those of a user's file."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Mapping
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from types import MappingProxyType, ModuleType

from nhtrack.errors import did_you_mean
from nhtrack.laws.law import LawError, LawKind

GROUP = "nhtrack.laws"  # entry points: a name, and the module that is the law's file
# The package's own, each a module beside this one.
_BUILT_IN = (
    "published",
    "stabiliser",
    "universal",
    "kanayama",
    "samson",
    "jiang_nijmeijer",
    "feedback_linearisation",
    "look_ahead",
)


@cache
def laws() -> Mapping[str, LawKind]:
    """Returns the laws that scenarios may name, the package's own first.

    Raises:
        LawError: an installed law does not keep the contract, cannot be imported, or takes a name that there is.
    """
    found = {name: LawKind.of(_own(name), built_in=True) for name in _BUILT_IN}
    for entry in entry_points(group=GROUP):
        if entry.name in found:
            raise LawError(f"entry point {entry.value!r}: there is a law called {entry.name!r} already")
        try:
            module = entry.load()
        except Exception as error:
            raise LawError(f"entry point {entry.name!r}: {entry.value} cannot be imported: {error}") from error
        found[entry.name] = LawKind.of(module, entry.name)
    return MappingProxyType(found)


def law_named(name: str) -> LawKind:
    """Returns a law by its name.

    Raises:
        LawError: there is none; the message lists those there are.
    """
    known = laws()
    if name not in known:
        raise LawError(f"no law called {name!r}; {did_you_mean(name, known)}")
    return known[name]


def law_in(path: str | Path) -> LawKind:
    """Returns the law of a file, anew whenever the file has changed.

    Raises:
        LawError: no such file, it cannot be imported, or it does not keep the contract; with file and line.
    """
    file = Path(path).resolve()
    if not file.is_file():
        raise LawError(f"{path}: no such file")
    stat = file.stat()
    return _law_in(file, stat.st_mtime_ns, stat.st_size)


@cache
def _law_in(file: Path, modified: int, size: int) -> LawKind:
    return LawKind.of(_imported(file), file.stem)


def _own(name: str) -> ModuleType:
    return importlib.import_module(f"nhtrack.laws.{name}")


def _imported(file: Path) -> ModuleType:
    """Returns the module of a file, under a name of its own."""
    name = f"nhtrack_law_{file.stem}_{abs(hash(str(file)))}"
    spec = importlib.util.spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise LawError(f"{file}: not a Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # where type hints and inspect look for it
    try:
        spec.loader.exec_module(module)
    except SyntaxError as error:
        raise LawError(f"{file}:{error.lineno}: {error.msg}") from error
    except Exception as error:
        lines = [frame.tb_lineno for frame in _frames(error) if frame.tb_frame.f_code.co_filename == str(file)]
        where = f"{file}:{lines[-1]}" if lines else str(file)
        raise LawError(f"{where}: {type(error).__name__}: {error}") from error
    return module


def _frames(error: BaseException) -> list:  # type: ignore[type-arg]
    found, frame = [], error.__traceback__
    while frame is not None:
        found.append(frame)
        frame = frame.tb_next
    return found
