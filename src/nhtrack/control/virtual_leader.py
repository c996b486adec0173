"""Virtual leaders: what a follower with several parents, or with a place in a formation, tracks.

A virtual leader is folded over a follower's parents, left to right (paper eq. 30): each fold moves from what has been
folded so far towards the next parent along the geodesic between them,

    g_c = g_a exp(lambda X),  X = log(g_a^-1 g_b).

The paper gives it the same combination of twists and inputs, which is not its velocity (docs/theory.md, slip 5); `exact`
differentiates the geodesic instead.
"""

from __future__ import annotations

from math import pi
from typing import Literal, TypeAlias

from nhtrack import se2
from nhtrack.arrays import Array, namespace
from nhtrack.control.law import Leader
from nhtrack.control.relative import arctan_ratio

Combination: TypeAlias = Literal["convex", "exact"]
Transform: TypeAlias = Literal["printed", "exact"]

HYSTERESIS = 0.25  # [rad] how far past the antipode the branch of log between two parents is kept


def fold(a: Leader, b: Leader, weight: Array, combination: Combination, turns: Array | None) -> tuple[Leader, Array]:
    """Returns the virtual leader between two leaders, and the winding number of the heading between them.

    `convex` (paper eqs. 30 to 32): `g_c = g_a exp(lambda X)`, `xi_c = (1 - lambda) xi_a + lambda xi_b`, u_c alike.
    `exact`: with h = exp(lambda X), X' = J_r(X)^-1 xi_ab and zeta = lambda J_r(lambda X) X',

        xi_c = Ad_{h^-1} xi_a + zeta,   u_c = Ad_{h^-1} u_a - [zeta, Ad_{h^-1} xi_a] + zeta'

    the true body twist and acceleration of g_c.

    Args:
        a: the first leader, shapes (..., 3).
        b: the second, likewise.
        weight: lambda in [0, 1], shape (...); 0 gives a, 1 gives b.
        combination: which twist and input.
        turns: winding numbers of the last call, or None at the start.
    """
    xp = namespace(a.g, b.g)
    g_ab = se2.between(a.g, b.g)
    turns = se2.winding_number(g_ab[..., 2], turns, HYSTERESIS)
    g_ab = xp.stack([g_ab[..., 0], g_ab[..., 1], g_ab[..., 2] - 2 * pi * turns], axis=-1)
    X, share = se2.log(g_ab), weight[..., None]
    h = se2.exp(share * X)
    if combination == "convex":
        return Leader(se2.compose(a.g, h), (1 - share) * a.xi + share * b.xi, (1 - share) * a.u + share * b.u), turns
    carried = se2.Ad_inverse(g_ab, a.xi)
    xi_ab = b.xi - carried
    u_ab = b.u - se2.Ad_inverse(g_ab, a.u) + se2.ad(xi_ab, carried)
    inverse = se2.right_jacobian_inverse(X)
    rate = _apply(inverse, xi_ab)
    bend = _apply(se2.right_jacobian_derivative(X, rate), rate)
    second = _apply(inverse, u_ab - bend)
    jacobian = se2.right_jacobian(share * X)
    zeta = share * _apply(jacobian, rate)
    bend_c = _apply(se2.right_jacobian_derivative(share * X, share * rate), rate)
    zeta_rate = share * (_apply(jacobian, second) + bend_c)
    xi_a = se2.Ad_inverse(h, a.xi)
    u_c = se2.Ad_inverse(h, a.u) - se2.ad(zeta, xi_a) + zeta_rate
    return Leader(se2.compose(a.g, h), xi_a + zeta, u_c), turns


def displace(
    leader: Leader,
    offset: Array,
    transform: Transform,
    dead_zone_speed: float,
    attitude_acceleration: Array | float = 0.0,
) -> tuple[Leader, Array]:
    """Returns the leader moved to a place in its own frame, `g_a = g_c gbar` (Theorem 3), and the rate of thetabar.

    gbar = (xbar, ybar, thetabar), with V = (v_c - omega_c ybar, v_yc + omega_c xbar) the velocity that a point fixed
    there has and thetabar = arctan(V_y/V_x) its direction (paper eq. 35, with v_c and omega_c read for v_x0 and
    omega_ci i), so that the displaced leader has no lateral velocity. `printed` carries the twist and input rigidly,
    `Ad_{gbar^-1}`, as if thetabar stood still; `exact` adds its motion: omega_a = omega_c + thetabar',
    u_theta,a = u_theta,c + thetabar''.

    Args:
        leader: what to displace, shapes (..., 3).
        offset: places (xbar, ybar) [m], shape (..., 2).
        transform: whether thetabar's motion is left out or added.
        dead_zone_speed: |V| below which thetabar is taken as 0 [m/s].
        attitude_acceleration: thetabar'' [rad/s^2], which takes the leader's jerk and so must come from outside.
    """
    xp = namespace(leader.g, offset)
    x, y = offset[..., 0], offset[..., 1]
    zero = xp.zeros_like(x)
    lever = xp.stack([x, y, zero], axis=-1)
    point, force = se2.Ad_inverse(lever, leader.xi), se2.Ad_inverse(lever, leader.u)
    attitude = arctan_ratio(point[..., 1], point[..., 0], dead_zone_speed)
    square = point[..., 0] ** 2 + point[..., 1] ** 2
    moving = square > dead_zone_speed**2
    cross = point[..., 0] * force[..., 1] - point[..., 1] * force[..., 0]
    rate = xp.where(moving, cross / xp.where(moving, square, xp.ones_like(square)), xp.zeros_like(square))
    gbar = xp.stack(xp.broadcast_arrays(x, y, attitude), axis=-1)
    turn = xp.stack([zero, zero, attitude], axis=-1)
    along = xp.asarray([1.0, 0.0, 1.0])  # no lateral part: of xi by the choice of thetabar, of u because the law has none
    xi, u = along * se2.Ad_inverse(turn, point), along * se2.Ad_inverse(turn, force)
    if transform == "exact":
        spin = xp.stack(xp.broadcast_arrays(zero, zero, rate), axis=-1)
        swing = xp.stack(xp.broadcast_arrays(zero, zero, zero + attitude_acceleration), axis=-1)
        xi, u = xi + spin, u + swing
    return Leader(se2.compose(leader.g, gbar), xi, u), rate


def _apply(matrices: Array, vectors: Array) -> Array:
    """Returns the product of matrices (..., 3, 3) and vectors (..., 3)."""
    return (matrices @ vectors[..., None])[..., 0]
