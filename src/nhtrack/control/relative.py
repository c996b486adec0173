"""Relative motion of a follower seen from its leader, as every tracking law needs it."""

from __future__ import annotations

from math import pi
from typing import NamedTuple

from nhtrack import se2
from nhtrack.arrays import Array, namespace
from nhtrack.control.law import Leader, Robots


class Relative(NamedTuple):
    """Relative configuration and velocity; every array has the shape (...) or (..., components).

    Attributes:
        g: pose of the follower seen from the leader, (r_x, r_y, theta01), heading within pi + hysteresis, shape (...,
            3).
        q: exponential coordinates (q_x, q_y), shape (..., 2).
        xi: relative twist xi_1 - Ad_{g^-1} xi_0 in the follower's frame (paper eq. 15), shape (..., 3).
        carried: leader's velocity at the follower's place, in the leader's frame (v_0 - omega_0 r_y, v_y0 + omega_0
            r_x), shape (..., 2): the velocity a point fixed in the leader's frame has.
        turns: winding number taken off the relative heading, shape (...); the memory of the next call.
    """

    g: Array
    q: Array
    xi: Array
    carried: Array
    turns: Array


def relative_motion(follower: Robots, leader: Leader, turns: Array | None, hysteresis: float) -> Relative:
    """Returns the follower's motion relative to its leader.

    Args:
        follower: the follower.
        leader: what it tracks; a lateral velocity v_y0 is allowed.
        turns: winding numbers of the last call, or None at the start.
        hysteresis: of the winding number [rad], see `se2.winding_number`.
    """
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
    """Returns arctan(y/x) in [-pi/2, pi/2], +-pi/2 where x = 0, and 0 where |(x, y)| < dead_zone.

    The paper's two angles are such quotients, and both become 0/0 where tracking should end: there the direction of
    (x, y) is noise. It jumps by pi where x changes sign, as the paper's does.
    """
    xp = namespace(y, x)
    angle = xp.atan2(xp.where(x < 0, -y, y), xp.abs(x))
    return xp.where(xp.hypot(x, y) > dead_zone, angle, xp.zeros_like(angle))


def side_angle(relative: Relative, dead_zone: float) -> Array:
    """Returns beta = -arctan(q_y/q_x), the angle of q in the body frame (Lemma 1), shape (...)."""
    return -arctan_ratio(relative.q[..., 1], relative.q[..., 0], dead_zone)


def adjoint_attitude(relative: Relative, dead_zone: float) -> Array:
    """Returns theta~01 = arctan(omega_0 r_x / (v_0 - omega_0 r_y)) (paper eq. 17), shape (...).

    The relative heading for which the relative velocity has no lateral part. With lateral leader velocity the
    numerator is v_y0 + omega_0 r_x.
    """
    return arctan_ratio(relative.carried[..., 1], relative.carried[..., 0], dead_zone)
