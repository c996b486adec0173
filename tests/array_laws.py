"""The package's compiled laws and virtual leaders asked with arrays of any shape, as property tests speak of them."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, make_dataclass
from functools import cached_property
from typing import Any, ClassVar, NamedTuple, Self, TypeAlias, get_type_hints

import numpy as np

from nhtrack.compiled import compiled
from nhtrack.laws import Law, LawKind, Limits, contract, law_named, virtual_leader
from nhtrack.laws.evaluate import commands, first_memories

Memory: TypeAlias = Any


class Robots(NamedTuple):
    """Followers: poses and twists, shape (..., 3)."""

    g: np.ndarray
    xi: np.ndarray


class Leader(NamedTuple):
    """What they track: poses, twists and accelerations, shape (..., 3)."""

    g: np.ndarray
    xi: np.ndarray
    u: np.ndarray


def rows(parts: tuple[np.ndarray, ...], shape: tuple[int, ...] | None = None) -> np.ndarray:
    """Poses, twists and accelerations side by side, one robot a row."""
    joined = np.concatenate(np.broadcast_arrays(*parts), axis=-1, dtype=float)
    return (joined if shape is None else np.broadcast_to(joined, (*shape, joined.shape[-1]))).reshape(
        -1, joined.shape[-1]
    )


@dataclass(frozen=True)
class ArrayLaw:
    """A law of the package with its gains as fields; gains of shape (b, 1) make it one of b laws."""

    kind: ClassVar[LawKind]

    @classmethod
    def of(cls, law: Law) -> Self:
        """The law of an experiment."""
        assert law.kind is cls.kind
        own: dict[str, Any] = {name: getattr(law, name) for name in ("limits",) if name in cls.__dataclass_fields__}
        return cls(*law.gains, **own)

    @cached_property
    def gains(self) -> dict[str, Any]:
        """Its gains by name, choices as numbers."""
        found = {each.name: getattr(self, each.name) for each in fields(self) if each.name != "limits"}
        choices = {name: gain.choices for name, gain in self.kind.described.items() if gain.choices}
        return {
            name: choices[name].index(value) if isinstance(value, str) else value for name, value in found.items()
        }

    def bound(self, shape: tuple[int, ...] = ()) -> Law:
        """The law as the loop takes it, with a row of gains for each robot where gains are arrays."""
        gains = self.gains
        if any(np.ndim(gain) for gain in gains.values()):
            gains = {name: np.broadcast_to(gain, shape).reshape(-1) for name, gain in gains.items()}
        return self.kind(limits=getattr(self, "limits", None), **gains)

    def init(self, follower: Robots, leader: Leader) -> Memory:
        shape = np.broadcast_shapes(*(np.shape(part)[:-1] for part in (*follower, *leader)))
        return self._named(first_memories(self.bound(shape), rows(follower, shape), rows(leader, shape)), shape)

    def __call__(self, follower: Robots, leader: Leader, memory: Memory) -> tuple[np.ndarray, Memory]:
        shape = np.broadcast_shapes(*(np.shape(part)[:-1] for part in (*follower, *leader)))
        held = np.zeros((int(np.prod(shape)), self.kind.memory_size))
        for i, values in enumerate(memory):
            held[:, i] = np.broadcast_to(values, shape).reshape(-1)
        u, after = commands(self.bound(shape), rows(follower, shape), rows(leader, shape), held)
        return u.reshape(*shape, 2).copy(), self._named(after, shape)

    def warnings(self) -> tuple[str, ...]:
        return self.bound().warnings()

    def _named(self, memory: np.ndarray, shape: tuple[int, ...]) -> Memory:
        if self.kind.memory is None:
            return ()
        hints = get_type_hints(self.kind.memory)
        columns = memory.reshape(*shape, self.kind.memory_size)
        return self.kind.memory(
            *(columns[..., i].astype(hints[name]) for i, name in enumerate(self.kind.memory._fields))
        )


def _law(name: str, *, limited: bool = False) -> type[Any]:
    """The class of a law; those of the paper have no dead zones, which do not scale, unless a test sets them."""
    kind = law_named(name)
    without = ("dead_zone_length", "dead_zone_speed") if name in ("published", "stabiliser") else ()
    defaults = {each: 0.0 if each in without else value for each, value in kind.gains._field_defaults.items()}
    own = [(each, Any, field(default=defaults[each])) if each in defaults else (each, Any)
           for each in kind.gains._fields]  # fmt: skip
    limits = [("limits", Limits | None, field(default=None))] if limited else []
    return make_dataclass(name, [*own, *limits], bases=(ArrayLaw,), frozen=True, namespace={"kind": kind})


Published = _law("published")
Stabiliser = _law("stabiliser")
Universal = _law("universal", limited=True)
Kanayama = _law("kanayama")
Samson = _law("samson")
JiangNijmeijer = _law("jiang_nijmeijer")
FeedbackLinearisation = _law("feedback_linearisation")
LookAhead = _law("look_ahead")
Panteley = _law("panteley")
Vfo = _law("vfo")
GuidingField = _law("guiding_field")
PolarBackstepping = _law("polar_backstepping")


# -- virtual leaders --------------------------------------------------------------------------------


def fold(
    a: Leader, b: Leader, weight: Any, combination: str, turns: np.ndarray | None
) -> tuple[Leader, np.ndarray]:
    """The compiled fold of pairs of leaders, and their winding numbers."""
    shape = np.shape(a.g)[:-1]
    known = turns is not None
    before = np.broadcast_to(np.zeros(()) if turns is None else turns, shape).reshape(-1).astype(float)
    weights = np.broadcast_to(weight, shape).reshape(-1).astype(float)
    found, after = _folds(rows(a), rows(b), weights, combination == "exact", before, known)
    return _parted(found, shape), after.reshape(shape)


def displace(
    leader: Leader, offset: np.ndarray, transform: str, dead_zone_speed: float, rate_limit: float = np.inf
) -> tuple[Leader, np.ndarray]:
    """The compiled displacement of leaders, and the rates of thetabar."""
    shape = np.shape(leader.g)[:-1]
    offsets = np.broadcast_to(offset, (*shape, 2)).reshape(-1, 2).astype(float)
    found, rate = _places(rows(leader), offsets, transform == "exact", float(dead_zone_speed), float(rate_limit))
    return _parted(found, shape), rate.reshape(shape)


def _parted(found: np.ndarray, shape: tuple[int, ...]) -> Leader:
    return Leader(*(part.reshape(*shape, 3).copy() for part in np.split(found, 3, axis=-1)))


@compiled
def _leader(row: np.ndarray) -> contract.Leader:
    return contract.Leader(row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8])


@compiled
def _folds(
    a: np.ndarray, b: np.ndarray, weight: np.ndarray, exact: bool, turns: np.ndarray, known: bool
) -> tuple[np.ndarray, np.ndarray]:
    found, after = np.empty((len(a), 9)), np.empty(len(a))
    for k in range(len(a)):
        folded, after[k] = virtual_leader.fold(_leader(a[k]), _leader(b[k]), weight[k], exact, turns[k], known)
        for c, value in enumerate(folded):
            found[k, c] = value
    return found, after


@compiled
def _places(
    leader: np.ndarray, offset: np.ndarray, exact: bool, dead_zone_speed: float, rate_limit: float
) -> tuple[np.ndarray, np.ndarray]:
    found, rate = np.empty((len(leader), 9)), np.empty(len(leader))
    for k in range(len(leader)):
        place, rate[k] = virtual_leader.displace(
            _leader(leader[k]), offset[k, 0], offset[k, 1], exact, dead_zone_speed, rate_limit
        )
        for c, value in enumerate(place):
            found[k, c] = value
    return found, rate
