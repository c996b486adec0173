"""From commanded velocities to accelerations (Fierro and Lewis 1997), as arrays: kept as second implementation."""

from __future__ import annotations

from typing import NamedTuple

from nhtrack.arrays import Array, namespace
from reference.laws.law import Robots


class Velocities(NamedTuple):
    """Velocities that a law commands, and their derivatives along the motion of follower and leader."""

    v: Array
    omega: Array
    v_rate: Array
    omega_rate: Array


def inner_loop(follower: Robots, commanded: Velocities, gain: float) -> Array:
    """Returns the accelerations (u_x, u_theta) that lead to commanded velocities, shape (..., 2)."""
    xp = namespace(follower.xi)
    u_x = commanded.v_rate - gain * (follower.xi[..., 0] - commanded.v)
    u_theta = commanded.omega_rate - gain * (follower.xi[..., 2] - commanded.omega)
    return xp.stack(xp.broadcast_arrays(u_x, u_theta), axis=-1)
