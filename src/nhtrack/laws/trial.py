"""A law called once, as Python, before anything is run: what it would do wrong in the first period of any run."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from nhtrack.laws.contract import Follower, Leader, LeaderMotion, Limits
from nhtrack.laws.faults import SIGNATURES
from nhtrack.laws.functions import as_python, python_of
from nhtrack.laws.law import Law, LawKind
from nhtrack.laws.own_file import place_of

_PERIOD = 0.01
_FOLLOWER = Follower(-0.5, 0.3, 0.2, 0.1, 0.0, -0.1)
_LEADER = Leader(0.0, 0.0, 0.0, 0.2, 0.0, 0.1, 0.05, 0.0, -0.05)
_LIMITS = Limits(1.0, 2.0, 1.0, 4.0)


class _FaultyError(Exception):
    """What is wrong, with its place."""


def trial_fault(law: Law, *, limited: bool = False) -> str | None:
    """Returns what is wrong with a law, `file:line: message`, or None.

    It is called for a follower half a metre behind a leader that drives: a plain state, in which every law has an
    answer.

    Args:
        law: with its gains.
        limited: whether it is to keep limits.
    """
    kind, limits = law.kind, _LIMITS if limited else Limits()
    try:
        memory = _first_memory(kind, law.gains)
        _command(kind, law.gains, limits, memory)
        _sentences(kind, "warnings", kind.warn, law.gains, limits)
        _sentences(kind, "beyond", kind.beyond, law.gains, _PERIOD, LeaderMotion(*np.transpose([_LEADER, _LEADER])))
    except _FaultyError as error:
        return str(error)
    return None


def _first_memory(kind: LawKind, gains: Any) -> Any:
    if kind.memory is None or kind.init is None:
        return ()
    memory = _called(kind, "init", kind.init, gains, _PERIOD, _FOLLOWER, _LEADER)
    _require_memory(kind, "init", kind.init, memory)
    return memory


def _command(kind: LawKind, gains: Any, limits: Limits, memory: Any) -> None:
    found = _called(kind, "command", kind.command, gains, _PERIOD, limits, _FOLLOWER, _LEADER, memory)
    if not (isinstance(found, tuple) and len(found) == 3):
        raise _faulty(kind, kind.command, f"`command` returned {_shown(found)}; expected {SIGNATURES['command']}")
    for name, value in zip(("u_x", "u_theta"), found, strict=False):
        if not _is_finite(value):
            raise _faulty(kind, kind.command, f"`command` returned {name} = {_shown(value)}; expected a finite number")
    _require_memory(kind, "command", kind.command, found[2])


def _require_memory(kind: LawKind, name: str, function: Callable[..., Any], memory: Any) -> None:
    """Checks that what a function returned as memory is what the file says a memory is."""
    if kind.memory is None:
        if memory != ():
            said = f"`{name}` returned the memory {_shown(memory)}, and the file has no class `Memory`; return `memory`"
            raise _faulty(kind, function, said)
        return
    if not isinstance(memory, kind.memory):
        raise _faulty(kind, function, f"`{name}` returned {_shown(memory)} as memory; expected a `Memory`")
    for field, expected in kind.memory_sizes.items():
        value = getattr(memory, field)
        items = value if isinstance(value, tuple) else (value,)
        if (len(items) if isinstance(value, tuple) else 0) != expected or not all(map(_is_finite, items)):
            wanted = f"{expected} finite numbers" if expected else "a finite number"
            raise _faulty(kind, function, f"`{name}` returned Memory.{field} = {_shown(value)}; expected {wanted}")


def _sentences(kind: LawKind, name: str, function: Callable[..., Any] | None, *arguments: Any) -> None:
    if function is None:
        return
    found = _called(kind, name, function, *arguments)
    if not isinstance(found, (tuple, list)) or not all(isinstance(each, str) for each in found):
        raise _faulty(kind, function, f"`{name}` returned {_shown(found)}; expected a tuple of texts")


def _called(kind: LawKind, name: str, function: Callable[..., Any], *arguments: Any) -> Any:
    try:
        return as_python(function)(*arguments)
    except Exception as error:
        place = place_of(error, kind.file, _line(function))
        said = f"{type(error).__name__}: {error}"
        raise _FaultyError(f"{place}: `{name}` raised {said}, for a plain state") from error


def _faulty(kind: LawKind, function: Callable[..., Any], message: str) -> _FaultyError:
    return _FaultyError(f"{kind.file}:{_line(function)}: {message}")


def _line(function: Callable[..., Any]) -> int:
    plain = python_of(function)
    return plain.__code__.co_firstlineno if plain is not None else 1


def _is_finite(value: Any) -> bool:
    try:
        return math.isfinite(value)
    except (TypeError, OverflowError):
        return False


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 80 else text[:77] + "..."
