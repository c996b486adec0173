"""Commands what its leader was commanded in this period, and a bit more; remembers how often it was asked and what it
saw."""

from __future__ import annotations

from math import nan
from typing import NamedTuple

from nhtrack.laws import Follower, Leader, Limits


class Gains(NamedTuple):
    """What it does.

    Attributes:
        more: added to both accelerations.
        breaks: the call from which it commands what is not finite.
        raises: the call in which it raises an exception.
    """

    more: float = 1.0
    breaks: int = 1000000
    raises: int = 1000000


class Memory(NamedTuple):
    """Number of calls, and follower and leader as they were seen in the last."""

    calls: int
    own_x: float
    own_y: float
    own_theta: float
    own_v_x: float
    own_v_y: float
    own_omega: float
    x: float
    y: float
    theta: float
    v_x: float
    v_y: float
    omega: float
    u_x: float
    u_y: float
    u_theta: float


def init(gains: Gains, period: float, follower: Follower, leader: Leader) -> Memory:
    return _seen(0, follower, leader)


def command(
    gains: Gains, period: float, limits: Limits, follower: Follower, leader: Leader, memory: Memory
) -> tuple[float, float, Memory]:
    if memory.calls == gains.raises:
        raise ValueError("enough")
    u_x = nan if memory.calls >= gains.breaks else leader.u_x + gains.more
    return u_x, leader.u_theta + gains.more, _seen(memory.calls + 1, follower, leader)


def _seen(calls: int, a: Follower, b: Leader) -> Memory:
    return Memory(
        calls, a.x, a.y, a.theta, a.v_x, a.v_y, a.omega, b.x, b.y, b.theta, b.v_x, b.v_y, b.omega, b.u_x, b.u_y,
        b.u_theta,
    )  # fmt: skip
