"""The law `universal` for a follower that knows its own pose to 1 mm and 2 mrad only."""

from __future__ import annotations

from math import floor, sin
from typing import NamedTuple

from nhtrack.laws import Follower, Leader, Limits, compiled, universal

Gains = universal.Gains

_init = compiled(universal.init)
_command = compiled(universal.command)


class Memory(NamedTuple):
    """That of `universal`, and where the noise is."""

    side: int
    gear: int
    docked: bool
    turns: int
    phase: float


def init(gains: Gains, period: float, follower: Follower, leader: Leader) -> Memory:
    kept = _init(gains, period, follower, leader)
    return Memory(kept.side, kept.gear, kept.docked, kept.turns, _scattered(follower.x + 3.7 * follower.y))


def command(
    gains: Gains, period: float, limits: Limits, follower: Follower, leader: Leader, memory: Memory
) -> tuple[float, float, Memory]:
    a = _scattered(memory.phase)
    b = _scattered(a)
    c = _scattered(b)
    seen = Follower(
        follower.x + 1e-3 * _noise(a), follower.y + 1e-3 * _noise(b), follower.theta + 2e-3 * _noise(c), follower.v_x,
        follower.v_y, follower.omega,
    )  # fmt: skip
    held = universal.Memory(memory.side, memory.gear, memory.docked, memory.turns)
    u_x, u_theta, kept = _command(gains, period, limits, seen, leader, held)
    return u_x, u_theta, Memory(kept.side, kept.gear, kept.docked, kept.turns, c)


def _scattered(phase: float) -> float:
    """The next of numbers that look drawn from [0, 1)."""
    value = 43758.5453 * sin(78.233 * phase + 12.9898)
    return value - floor(value)


def _noise(phase: float) -> float:
    """Of unit variance and zero mean."""
    return 3.4641 * (phase - 0.5)
