"""The laws there are: the package's own, those of installed packages, and those of a user's file."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from functools import cache, lru_cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import MappingProxyType, ModuleType

from nhtrack.errors import did_you_mean
from nhtrack.laws.law import LawKind
from nhtrack.laws.own_file import LawError, import_source, read_source

GROUP = "nhtrack.laws"  # entry points: a name, and the module that is the law's file
# The package's own, each a module beside this one.
_BUILT_IN = (
    "published",
    "stabiliser",
    "universal",
    "agile",
    "kanayama",
    "samson",
    "jiang_nijmeijer",
    "feedback_linearisation",
    "look_ahead",
    "panteley",
    "vfo",
    "guiding_field",
    "polar_backstepping",
)


@cache
def laws() -> Mapping[str, LawKind]:
    """Returns the laws that scenarios may name, the package's own first; see `faulty_laws`."""
    return MappingProxyType({name: kind for name, kind in _all().items() if isinstance(kind, LawKind)})


@cache
def faulty_laws() -> Mapping[str, LawError]:
    """Returns what is wrong with installed laws that cannot be used, by their names: only who names one is told."""
    return MappingProxyType({name: error for name, error in _all().items() if isinstance(error, LawError)})


@cache
def _all() -> Mapping[str, LawKind | LawError]:
    found: dict[str, LawKind | LawError] = {name: LawKind.of(_own(name), built_in=True) for name in _BUILT_IN}
    for entry in sorted(entry_points(group=GROUP)):
        try:
            kind: LawKind | LawError = _installed(entry)
        except LawError as error:
            kind = error
        if entry.name not in _BUILT_IN:
            found[entry.name] = kind
    return found


def law_named(name: str) -> LawKind:
    """Returns a law by its name.

    Raises:
        LawError: there is none, and the message lists those there are; or it cannot be used.
    """
    known = laws()
    if name in faulty_laws():
        raise faulty_laws()[name]
    if name not in known:
        raise LawError(f"no law called {name!r}; {did_you_mean(name, known)}")
    return known[name]


def law_in(path: str | Path) -> LawKind:
    """Returns the law of a file, anew whenever its text has changed.

    Raises:
        LawError: no such file, it cannot be imported, or it does not keep the contract; with file and line.
    """
    return law_of_text(*read_source(path))


@lru_cache(maxsize=64)
def law_of_text(file: Path, source: str) -> LawKind:
    """Returns the law of a file that has a text, or had it; see `law_in`."""
    return LawKind.of(import_source(file, source), file.stem, source)


def _own(name: str) -> ModuleType:
    return importlib.import_module(f"nhtrack.laws.{name}")


def _installed(entry: EntryPoint) -> LawKind:
    """Returns the law of an installed package.

    Raises:
        LawError: its module cannot be imported, does not keep the contract, or takes a name that there is.
    """
    if entry.name in _BUILT_IN:
        raise LawError(f"entry point {entry.value!r}: there is a law called {entry.name!r} already")
    try:
        module = entry.load()
    except Exception as error:
        raise LawError(f"entry point {entry.name!r}: {entry.value} cannot be imported: {error}") from error
    if not isinstance(module, ModuleType):
        raise LawError(f"entry point {entry.name!r}: {entry.value} is no module; name the module that is the law")
    return LawKind.of(module, entry.name)
