"""Virtual leaders: what a follower with several parents, or with a place in a formation, tracks.

A virtual leader is folded over a follower's parents, left to right (paper eq. 30): each fold moves from what has been
folded so far towards the next parent along the geodesic between them,

    g_c = g_a exp(lambda X),  X = log(g_a^-1 g_b).

The paper gives it the same combination of twists and inputs, which is not its velocity (docs/theory.md); `exact`
differentiates the geodesic instead. A place in a formation is then a displacement of the folded leader.
"""

from __future__ import annotations

from math import cos, pi, sin

from nhtrack import planar
from nhtrack.compiled import compiled, compiled_inside
from nhtrack.laws.contract import Leader
from nhtrack.laws.relative_motion import arctan_ratio
from nhtrack.planar import Triple

HYSTERESIS = 0.25  # [rad] how far past the antipode the branch of log between two parents is kept


@compiled
def fold(a: Leader, b: Leader, weight: float, exact: bool, turns: float, known: bool) -> tuple[Leader, float]:
    """Returns the virtual leader between two leaders, and the winding number of the heading between them.

    Printed (paper eqs. 30 to 32): `g_c = g_a exp(lambda X)`, `xi_c = (1 - lambda) xi_a + lambda xi_b`, u_c alike.
    Exact: with h = exp(lambda X), X' = J_r(X)^-1 xi_ab and zeta = lambda J_r(lambda X) X',

        xi_c = Ad_{h^-1} xi_a + zeta,   u_c = Ad_{h^-1} u_a - [zeta, Ad_{h^-1} xi_a] + zeta'

    the true body twist and acceleration of g_c.

    Args:
        a: the first leader.
        b: the second.
        weight: lambda in [0, 1]; 0 gives a, 1 gives b.
        exact: which twist and input.
        turns: winding number of the last call.
        known: whether there was one; False at the start.
    """
    g_a = (a.x, a.y, a.theta)
    x, y, heading = planar.between(g_a, (b.x, b.y, b.theta))
    if known:
        turns = planar.winding_number_after(heading, turns, HYSTERESIS)
    else:
        turns = planar.winding_number(heading)
    g_ab = (x, y, heading - 2 * pi * turns)
    X = planar.log(g_ab)
    h = planar.exp(_scale(weight, X))
    if exact:
        xi, u = _along_the_geodesic(a, b, weight, g_ab, X, h)
    else:
        xi, u = _mean(1 - weight, _twist(a), weight, _twist(b)), _mean(1 - weight, _input(a), weight, _input(b))
    return _leader(planar.compose(g_a, h), xi, u), turns


@compiled_inside
def _along_the_geodesic(
    a: Leader, b: Leader, weight: float, g_ab: Triple, X: Triple, h: Triple
) -> tuple[Triple, Triple]:
    """Returns xi_c and u_c of the exact `fold`."""
    carried = planar.Ad_inverse(g_ab, _twist(a))
    xi_ab = _difference(_twist(b), carried)
    u_ab = _sum(_difference(_input(b), planar.Ad_inverse(g_ab, _input(a))), planar.ad(xi_ab, carried))
    rate = planar.right_jacobian_inverse(X, xi_ab)  # X'
    bend = planar.right_jacobian_derivative(X, rate, rate)
    second = planar.right_jacobian_inverse(X, _difference(u_ab, bend))  # X''
    part, part_rate = _scale(weight, X), _scale(weight, rate)
    zeta = _scale(weight, planar.right_jacobian(part, rate))
    bend_c = planar.right_jacobian_derivative(part, part_rate, rate)
    zeta_rate = _scale(weight, _sum(planar.right_jacobian(part, second), bend_c))
    xi_a = planar.Ad_inverse(h, _twist(a))
    u_c = _sum(_difference(planar.Ad_inverse(h, _input(a)), planar.ad(zeta, xi_a)), zeta_rate)
    return _sum(xi_a, zeta), u_c


@compiled
def displace(
    leader: Leader, offset_x: float, offset_y: float, exact: bool, dead_zone_speed: float, rate_limit: float
) -> tuple[Leader, float]:
    """Returns the leader moved to a place in its own frame, `g_a = g_c gbar` (Theorem 3), and the rate of thetabar.

    gbar = (xbar, ybar, thetabar), with V = (v_c - omega_c ybar, v_yc + omega_c xbar) the velocity that a point fixed
    there has and thetabar = arctan(V_y/V_x) its direction (paper eq. 35, with v_c and omega_c read for v_x0 and
    omega_ci i), so that the displaced leader has no lateral velocity. Printed, twist and input are carried rigidly,
    `Ad_{gbar^-1}`, as if thetabar stood still; exact adds its rate, omega_a = omega_c + thetabar'. The other half of
    its motion, u_theta,a = u_theta,c + thetabar'', takes the leader's jerk, so the caller adds it as a difference of
    rates.

    Args:
        leader: what to displace.
        offset_x: xbar, how far ahead [m].
        offset_y: ybar, how far to the left [m].
        exact: whether thetabar's motion is added.
        dead_zone_speed: |V| below which thetabar and its rate are taken as 0 [m/s].
        rate_limit: largest |thetabar'| [rad/s]: it is unbounded where V comes close to 0.
    """
    v_x, v_y = leader.v_x - leader.omega * offset_y, leader.v_y + leader.omega * offset_x
    u_x, u_y = leader.u_x - leader.u_theta * offset_y, leader.u_y + leader.u_theta * offset_x
    attitude = arctan_ratio(v_y, v_x, dead_zone_speed)
    square, rate = v_x * v_x + v_y * v_y, 0.0
    if square > dead_zone_speed * dead_zone_speed:
        rate = planar.clip((v_x * u_y - v_y * u_x) / square, -rate_limit, rate_limit)
    c, s = cos(attitude), sin(attitude)
    omega = leader.omega + rate if exact else leader.omega
    pose = planar.compose((leader.x, leader.y, leader.theta), (offset_x, offset_y, attitude))
    # No lateral part: of xi by the choice of thetabar, and so of its rate.
    return _leader(pose, (c * v_x + s * v_y, 0.0, omega), (c * u_x + s * u_y, 0.0, leader.u_theta)), rate


# Leaders as poses, twists and inputs ----------------------------------------------------------------------------------


@compiled_inside
def _leader(g: Triple, xi: Triple, u: Triple) -> Leader:
    return Leader(g[0], g[1], g[2], xi[0], xi[1], xi[2], u[0], u[1], u[2])


@compiled_inside
def _twist(leader: Leader) -> Triple:
    return leader.v_x, leader.v_y, leader.omega


@compiled_inside
def _input(leader: Leader) -> Triple:
    return leader.u_x, leader.u_y, leader.u_theta


@compiled_inside
def _sum(a: Triple, b: Triple) -> Triple:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@compiled_inside
def _difference(a: Triple, b: Triple) -> Triple:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@compiled_inside
def _scale(factor: float, a: Triple) -> Triple:
    return factor * a[0], factor * a[1], factor * a[2]


@compiled_inside
def _mean(share_a: float, a: Triple, share_b: float, b: Triple) -> Triple:
    return _sum(_scale(share_a, a), _scale(share_b, b))
