"""Pulls its follower to the origin of the world along x, whatever its leader does."""

from __future__ import annotations

from typing import NamedTuple

from nhtrack.laws import Follower, Leader, Limits


class Gains(NamedTuple):
    """Stiffness and damping."""

    k: float = 2.0
    d: float = 1.0


def command(
    gains: Gains, period: float, limits: Limits, follower: Follower, leader: Leader, memory: tuple[()]
) -> tuple[float, float, tuple[()]]:
    return -gains.k * follower.x - gains.d * follower.v_x, 0.0, memory
