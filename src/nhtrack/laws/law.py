"""A law as the package holds it: what its file defines, and the same with gains in robot units."""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import ModuleType
from typing import Any, get_type_hints

import numpy as np

from nhtrack.laws.contract import Gain, LeaderMotion, Limits
from nhtrack.laws.faults import contract_faults
from nhtrack.laws.functions import as_python
from nhtrack.laws.leader_bounds import turns_too_far
from nhtrack.laws.own_file import LawError as LawError
from nhtrack.laws.own_file import place_of
from nhtrack.laws.slots import slots_of


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
        beyond: says what of a leader's motion is not known to be followed, or None.
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
    beyond: Callable[..., tuple[str, ...]] | None = field(repr=False)
    file: str
    source: str = field(repr=False)
    summary: str
    built_in: bool = False

    @classmethod
    def of(
        cls, module: ModuleType, name: str | None = None, source: str | None = None, *, built_in: bool = False
    ) -> LawKind:
        """Returns the law of a module.

        Args:
            module: of its file.
            name: what to call it; the file's name by default.
            source: the text of the file; read by default.
            built_in: whether it is one of the package's own.

        Raises:
            LawError: everything in which the module does not keep the contract, with file and line.
        """
        file = str(module.__file__)
        source = inspect.getsource(module) if source is None else source
        faults = contract_faults(module, source)
        if faults:
            raise LawError("\n".join(f"{file}:{line}: {message}" for line, message in sorted(faults)))
        return cls(
            name=name or module.__name__.rpartition(".")[2],
            gains=module.Gains,
            memory=getattr(module, "Memory", None),
            init=getattr(module, "init", None),
            command=module.command,
            warn=getattr(module, "warnings", None),
            beyond=getattr(module, "beyond", None),
            file=file,
            source=source,
            summary=(module.__doc__ or "").strip().partition("\n")[0],
            built_in=built_in,
        )

    @cached_property
    def described(self) -> Mapping[str, Gain]:
        """What there is to know of each gain, by its field's name."""
        hints = get_type_hints(self.gains, include_extras=True)
        return {name: _described(hints[name]) for name in self.gains._fields}

    @property
    def account(self) -> dict[str, str]:
        """What a recording keeps of it, for it to be run again: name, file, its hash and its text."""
        return {"name": self.name, "file": self.file, "sha256": self.hash, "source": self.source}

    @property
    def hash(self) -> str:
        """SHA-256 of the text of its file."""
        return hashlib.sha256(self.source.encode()).hexdigest()

    @cached_property
    def memory_size(self) -> int:
        """Number of values in its memory, items of tuples each."""
        return 0 if self.memory is None else len(slots_of(self.memory))

    @cached_property
    def memory_sizes(self) -> Mapping[str, int]:
        """How many items each field of its memory has that is a tuple; 0 where it is a number."""
        slots = () if self.memory is None else slots_of(self.memory)
        return {name: sum(slot.field == name and slot.item >= 0 for slot in slots) for name, _, _ in slots}

    @cached_property
    def modes(self) -> tuple[int, ...]:
        """Places in its memory that hold whole numbers and truth values: what it has decided, not what it filters."""
        if self.memory is None:
            return ()
        return tuple(i for i, slot in enumerate(slots_of(self.memory)) if slot.kind in (int, bool))

    @cached_property
    def python(self) -> Mapping[str, Callable[..., Any]]:
        """Its `init` and `command` as Python, with all that they call."""
        functions = {"init": self.init, "command": self.command}
        return {name: as_python(function) for name, function in functions.items() if function is not None}

    def __call__(self, *, limits: Limits | None = None, delay_periods: int = 0, **gains: Any) -> Law:
        """Returns the law with gains in robot units."""
        return Law(self, self.gains(**gains), limits or Limits(), delay_periods)


@dataclass(frozen=True)
class Law:
    """A law with gains in robot units.

    Attributes:
        kind: what its file defines.
        gains: numbers, or arrays of shape (b,) or (b, 1) that make it one of b laws.
        limits: of the robot.
        delay_periods: control periods by which it is asked ahead, see `nhtrack.experiment.link`.
    """

    kind: LawKind
    gains: Any
    limits: Limits = field(default_factory=Limits)
    delay_periods: int = 0

    def warnings(self) -> tuple[str, ...]:
        """Returns what the gains break, with the formula; empty where nothing is known to be wrong."""
        return () if self.kind.warn is None else tuple(self.kind.warn(self.gains, self.limits))

    def beyond(self, period: float, leader: LeaderMotion) -> tuple[str, ...]:
        """Returns what of a leader's motion the law is not known to follow, in sentences.

        Args:
            period: control period [s].
            leader: how it is to move.

        Raises:
            LawError: the law's own `beyond` raised an exception, with its line.
        """
        try:
            own = () if self.kind.beyond is None else tuple(self.kind.beyond(self.gains, period, leader))
        except Exception as error:
            place = place_of(error, self.kind.file)
            raise LawError(f"{place}: `beyond` raised {type(error).__name__}: {error}") from error
        return (*turns_too_far(period, leader), *own)

    @property
    def account(self) -> dict[str, Any]:
        """What a recording keeps of a law that is not the package's own: gains in robot units, and all of its file."""
        return self.kind.account | {"gains": {name: float(gain) for name, gain in self.gains._asdict().items()}}

    @property
    def gain_rows(self) -> np.ndarray:
        """The gains as rows, shape (1 or b, number of gains)."""
        columns = np.broadcast_arrays(*(np.asarray(gain, dtype=float).reshape(-1) for gain in self.gains))
        return np.ascontiguousarray(np.stack(columns, axis=-1)) if columns else np.zeros((1, 0))


def _described(hint: Any) -> Gain:
    found = [extra for extra in getattr(hint, "__metadata__", ()) if isinstance(extra, Gain)]
    return found[0] if found else Gain("1", "")
