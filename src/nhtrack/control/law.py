"""What a tracking law is: the leader it sees and the contract it keeps."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol, TypeAlias

from nhtrack.arrays import Array


class Robots(NamedTuple):
    """Followers as a law sees them; `...` is any shape, usually (batch, robots of one level).

    Attributes:
        g: poses (x [m], y [m], theta [rad], unwrapped) in the world frame, shape (..., 3).
        xi: body twists (v_x [m/s], v_y [m/s], omega [rad/s]), shape (..., 3).
    """

    g: Array
    xi: Array


class Leader(NamedTuple):
    """What each follower tracks during one control period.

    Attributes:
        g: poses, as in `Robots`.
        xi: body twists, as in `Robots`.
        u: body accelerations (u_x, u_y [m/s^2], u_theta [rad/s^2]) the leader was commanded this period, before any
            saturation; for the root its input u0. u_y is zero but for `exact` virtual leaders. Shape (..., 3).
    """

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

    def warnings(self) -> tuple[str, ...]:
        """Returns what the gains break, with the formula; empty where nothing is known to be wrong."""
        ...
