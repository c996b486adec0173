"""Relative motion of follower and leader (paper eqs. 15 and 17), as arrays: kept as second implementation."""

from __future__ import annotations

from math import pi
from typing import NamedTuple

from nhtrack import se2
from nhtrack.arrays import Array, namespace
from reference.laws.law import Leader, Robots


class Relative(NamedTuple):
    """Relative configuration and velocity; every array has the shape (...) or (..., components)."""

    g: Array
    q: Array
    xi: Array
    carried: Array
    turns: Array


def relative_motion(follower: Robots, leader: Leader, turns: Array | None, hysteresis: float) -> Relative:
    """Returns the follower's motion relative to its leader."""
    xp = namespace(follower.g, leader.g)
    g = se2.between(leader.g, follower.g)
    turns = se2.winding_number(g[..., 2], turns, hysteresis)
    g = xp.stack([g[..., 0], g[..., 1], g[..., 2] - 2 * pi * turns], axis=-1)
    omega_0 = leader.xi[..., 2]
    carried = [leader.xi[..., 0] - omega_0 * g[..., 1], leader.xi[..., 1] + omega_0 * g[..., 0]]
    return Relative(
        g=g,
        q=se2.log(g)[..., :2],
        xi=follower.xi - se2.Ad_inverse(g, leader.xi),
        carried=xp.stack(xp.broadcast_arrays(*carried), axis=-1),
        turns=turns,
    )


def arctan_ratio(y: Array, x: Array, dead_zone: float) -> Array:
    """Returns arctan(y/x) in [-pi/2, pi/2], +-pi/2 where x = 0, and 0 where |(x, y)| < dead_zone."""
    xp = namespace(y, x)
    angle = xp.atan2(xp.where(x < 0, -y, y), xp.abs(x))
    return xp.where(xp.hypot(x, y) > dead_zone, angle, xp.zeros_like(angle))


def side_angle(relative: Relative, dead_zone: float) -> Array:
    """Returns beta = -arctan(q_y/q_x), the angle of q in the body frame (Lemma 1), shape (...)."""
    return -arctan_ratio(relative.q[..., 1], relative.q[..., 0], dead_zone)


def adjoint_attitude(relative: Relative, dead_zone: float) -> Array:
    """Returns theta~01 = arctan(omega_0 r_x / (v_0 - omega_0 r_y)) (paper eq. 17), shape (...)."""
    return arctan_ratio(relative.carried[..., 1], relative.carried[..., 0], dead_zone)
