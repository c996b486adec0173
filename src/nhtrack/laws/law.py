"""A law as the package holds it: what its file defines, and the same with gains in robot units."""

from __future__ import annotations

import ast
import hashlib
import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import ModuleType
from typing import Any, get_type_hints

import numpy as np

from nhtrack.errors import NhtrackError
from nhtrack.laws.address import Entry, entry_of
from nhtrack.laws.contract import Gain, Limits


class LawError(NhtrackError):
    """A law's file that does not keep the contract of `nhtrack.laws.contract`, or a law that fails while it runs."""


@dataclass(frozen=True)
class LawKind:
    """What the file of a law defines.

    Attributes:
        name: what scenarios call it.
        gains: its NamedTuple of gains.
        memory: its NamedTuple of memory, or None.
        init: makes the memory to begin with, or None.
        command: returns accelerations and memory.
        warn: says what gains and limits break, or None.
        file: where it is defined.
        source: the text of that file.
        summary: first line of its module's docstring.
        built_in: whether it is one of the package's own.
    """

    name: str
    gains: Any
    memory: Any
    init: Callable[..., Any] | None = field(repr=False)
    command: Callable[..., Any] = field(repr=False)
    warn: Callable[..., tuple[str, ...]] | None = field(repr=False)
    file: str
    source: str = field(repr=False)
    summary: str
    built_in: bool = False

    @classmethod
    def of(cls, module: ModuleType, name: str | None = None, *, built_in: bool = False) -> LawKind:
        """Returns the law of a module.

        Args:
            module: of its file.
            name: what to call it; the file's name by default.
            built_in: whether it is one of the package's own.

        Raises:
            LawError: everything in which the module does not keep the contract, with file and line.
        """
        file = str(module.__file__)
        source = inspect.getsource(module)
        faults = _faults(module, source)
        if faults:
            raise LawError("\n".join(f"{file}:{line}: {message}" for line, message in faults))
        return cls(
            name=name or module.__name__.rpartition(".")[2],
            gains=module.Gains,
            memory=getattr(module, "Memory", None),
            init=getattr(module, "init", None),
            command=module.command,
            warn=getattr(module, "warnings", None),
            file=file,
            source=source,
            summary=(module.__doc__ or "").strip().partition("\n")[0],
            built_in=built_in,
        )

    @property
    def described(self) -> Mapping[str, Gain]:
        """What there is to know of each gain, by its field's name."""
        hints = get_type_hints(self.gains, include_extras=True)
        return {name: _described(hints[name]) for name in self.gains._fields}

    @property
    def hash(self) -> str:
        """SHA-256 of the text of its file."""
        return hashlib.sha256(self.source.encode()).hexdigest()

    @cached_property
    def memory_size(self) -> int:
        """Number of values in its memory."""
        return 0 if self.memory is None else len(self.memory._fields)

    @cached_property
    def modes(self) -> tuple[int, ...]:
        """Places in its memory that hold whole numbers and truth values: what it has decided, not what it filters."""
        if self.memory is None:
            return ()
        hints = get_type_hints(self.memory)
        return tuple(i for i, name in enumerate(self.memory._fields) if hints[name] in (int, bool))

    @cached_property
    def entry(self) -> Entry:
        """The addresses of its compiled code."""
        return entry_of(self)

    def __call__(self, *, limits: Limits | None = None, **gains: Any) -> Law:
        """Returns the law with gains in robot units."""
        return Law(self, self.gains(**gains), limits or Limits())


@dataclass(frozen=True)
class Law:
    """A law with gains in robot units.

    Attributes:
        kind: what its file defines.
        gains: numbers, or arrays of shape (b,) or (b, 1) that make it one of b laws.
        limits: of the robot.
    """

    kind: LawKind
    gains: Any
    limits: Limits = field(default_factory=Limits)

    def warnings(self) -> tuple[str, ...]:
        """Returns what the gains break, with the formula; empty where nothing is known to be wrong."""
        return () if self.kind.warn is None else tuple(self.kind.warn(self.gains, self.limits))

    @property
    def gain_rows(self) -> np.ndarray:
        """The gains as rows, shape (1 or b, number of gains)."""
        columns = np.broadcast_arrays(*(np.asarray(gain, dtype=float).reshape(-1) for gain in self.gains))
        return np.ascontiguousarray(np.stack(columns, axis=-1)) if columns else np.zeros((1, 0))


def _described(hint: Any) -> Gain:
    found = [extra for extra in getattr(hint, "__metadata__", ()) if isinstance(extra, Gain)]
    return found[0] if found else Gain("1", "")


def _faults(module: ModuleType, source: str) -> list[tuple[int, str]]:
    """Returns in which lines the module does not keep the contract, and how."""
    lines = {node.name: node.lineno for node in ast.parse(source).body if hasattr(node, "name") and node.name}
    faults = []
    for name, arguments in (("command", 6), ("init", 4), ("warnings", 2)):
        function = getattr(module, name, None)
        if function is None:
            if name == "command" or (name == "init" and hasattr(module, "Memory")):
                faults.append((1, f"no function `{name}`: a law has {_SIGNATURES[name]}"))
            continue
        if not callable(function) or len(inspect.signature(function).parameters) != arguments:
            faults.append((lines.get(name, 1), f"`{name}` is not {_SIGNATURES[name]}"))
    for name in ("Gains", "Memory"):
        kind = getattr(module, name, None)
        if kind is None:
            if name == "Gains":
                faults.append((1, "no class `Gains`: a NamedTuple of the law's gains, each a float"))
        elif not (isinstance(kind, type) and issubclass(kind, tuple) and hasattr(kind, "_fields")):
            faults.append((lines.get(name, 1), f"`{name}` is not a NamedTuple"))
        else:
            faults += [(lines.get(name, 1), message) for message in _field_faults(kind)]
    return faults


def _field_faults(kind: Any) -> list[str]:
    """Returns which fields of a NamedTuple are not numbers."""
    hints = get_type_hints(kind)
    return [
        f"`{kind.__name__}.{name}`: expected float, int or bool, got {getattr(hints[name], '__name__', hints[name])}"
        for name in kind._fields
        if hints[name] not in (float, int, bool)
    ]


_SIGNATURES = {
    "command": "command(gains, period, limits, follower, leader, memory) -> (u_x, u_theta, memory)",
    "init": "init(gains, period, follower, leader) -> Memory",
    "warnings": "warnings(gains, limits) -> tuple[str, ...]",
}
