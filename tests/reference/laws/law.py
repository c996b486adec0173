"""What an array law sees and the contract it keeps."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol, TypeAlias

from nhtrack.arrays import Array


class Robots(NamedTuple):
    """Followers as a law sees them; `...` is any shape, usually (batch, robots of one level)."""

    g: Array
    xi: Array


class Leader(NamedTuple):
    """What each follower tracks during one control period."""

    g: Array
    xi: Array
    u: Array


# A law's memory is a tuple of arrays (winding numbers, hysteresis bits) that only the law reads.
Memory: TypeAlias = Any


class Law(Protocol):
    """A tracking law: a frozen set of gains with pure methods; memory goes in and comes out."""

    def init(self, follower: Robots, leader: Leader) -> Memory:
        """Returns the memory to begin with."""
        ...

    def __call__(self, follower: Robots, leader: Leader, memory: Memory) -> tuple[Array, Memory]:
        """Returns the accelerations u = (u_x, u_theta), shape (..., 2), and the memory for the next period."""
        ...
