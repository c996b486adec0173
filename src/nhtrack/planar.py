"""The group SE(2) of planar poses for compiled code: tuples of floats in and out, one pose at a time.

Conventions and formulas are those of `nhtrack.se2`, which has them for arrays: a pose g = (x, y, theta) with unwrapped
heading, a twist xi = (v_x, v_y, omega) in the body frame, exponential coordinates X = (q_x, q_y, theta) with
g = exp(X). Operations come in the same order there and here, so the two agree to the rounding of sine and cosine.
Matrices are not formed: the Jacobians are given as what they do to a vector.
"""

from __future__ import annotations

from math import cos, pi, sin
from typing import TypeAlias

import numpy as np

from nhtrack.compiled import compiled, compiled_inside

__all__ = [
    "Ad_inverse", "Triple", "ad", "between", "clip", "compose", "exp", "log", "right_jacobian",
    "right_jacobian_derivative", "right_jacobian_inverse", "sinc", "sinc_and_slope", "winding_number",
    "winding_number_after", "wrap",
]  # fmt: skip

Triple: TypeAlias = tuple[float, float, float]


# Poses and twists -----------------------------------------------------------------------------------------------------


@compiled
def compose(a: Triple, b: Triple) -> Triple:
    """Returns the product a b = `(p_a + R(theta_a) p_b, theta_a + theta_b)`; headings add unwrapped."""
    c, s = cos(a[2]), sin(a[2])
    return a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], a[2] + b[2]


@compiled
def between(a: Triple, b: Triple) -> Triple:
    """Returns the pose of b seen from a (paper eq. 5), a^-1 b = `(R(theta_a)^T (p_b - p_a), theta_b - theta_a)`."""
    c, s = cos(a[2]), sin(a[2])
    dx, dy = b[0] - a[0], b[1] - a[1]
    return c * dx + s * dy, c * dy - s * dx, b[2] - a[2]


@compiled
def exp(X: Triple) -> Triple:
    """Returns the pose reached after unit time at the constant body twist X = (q_x, q_y, theta).

    exp X = `(V(theta) q, theta)`, V = [[s, -c], [c, s]], s = sin(theta)/theta, c = (1 - cos theta)/theta.
    """
    s, c = _sine_quotients(X[2])
    return s * X[0] - c * X[1], c * X[0] + s * X[1], X[2]


@compiled
def log(g: Triple) -> Triple:
    """Returns the exponential coordinates X = (q_x, q_y, theta) with exp X = g (paper eq. 4); |theta| < 2 pi.

    log g = `(V^-1(theta) p, theta)`, V^-1 = [[a, h], [-h, a]], h = theta/2, a = h cot(h). The branch is the one that
    the value of theta names; `winding_number` brings an unwrapped heading into its range.
    """
    half = g[2] / 2
    a = cos(half) / sinc(half)
    return a * g[0] + half * g[1], a * g[1] - half * g[0], g[2]


@compiled
def Ad_inverse(g: Triple, xi: Triple) -> Triple:
    """Returns Ad_{g^-1} xi = `(R^T (v + omega (-y, x)), omega)`.

    With g = between(i, j): the twist of i carried rigidly to the place of j, in the frame of j.
    """
    c, s = cos(g[2]), sin(g[2])
    w_x, w_y = xi[0] - xi[2] * g[1], xi[1] + xi[2] * g[0]
    return c * w_x + s * w_y, c * w_y - s * w_x, xi[2]


@compiled
def ad(xi: Triple, eta: Triple) -> Triple:
    """Returns the bracket [xi, eta] = `(omega_eta v_y - omega_xi w_y, omega_xi w_x - omega_eta v_x, 0)`.

    For xi = (v_x, v_y, omega_xi) and eta = (w_x, w_y, omega_eta).
    """
    return eta[2] * xi[1] - xi[2] * eta[1], xi[2] * eta[0] - eta[2] * xi[0], 0.0


# Jacobians of exp -----------------------------------------------------------------------------------------------------


@compiled
def right_jacobian(X: Triple, v: Triple) -> Triple:
    """Returns J_r(X) v; `xi = J_r(X) dX/dt` is the body twist along g = exp(X(t)).

    J_r(X) = [[s, c, m_x], [-c, s, m_y], [0, 0, 1]] with s and c as in `exp`, m_x = e q_x - f q_y and
    m_y = f q_x + e q_y, where e = (theta - sin theta)/theta^2 and f = (1 - cos theta)/theta^2.
    """
    s, c = _sine_quotients(X[2])
    m_x, m_y = _last_column(X)
    return s * v[0] + c * v[1] + m_x * v[2], -c * v[0] + s * v[1] + m_y * v[2], v[2]


@compiled
def right_jacobian_inverse(X: Triple, v: Triple) -> Triple:
    """Returns J_r(X)^-1 v; `dX/dt = J_r(X)^-1 xi` along g = exp(X(t)); |theta| < 2 pi.

    J_r(X)^-1 = [[a, -h, -(a m_x - h m_y)], [h, a, -(h m_x + a m_y)], [0, 0, 1]] with a and h as in `log`.
    """
    half = X[2] / 2
    a = cos(half) / sinc(half)
    m_x, m_y = _last_column(X)
    x = a * v[0] - half * v[1] - (a * m_x - half * m_y) * v[2]
    y = half * v[0] + a * v[1] - (half * m_x + a * m_y) * v[2]
    return x, y, v[2]


@compiled
def right_jacobian_derivative(X: Triple, dX: Triple, v: Triple) -> Triple:
    """Returns the derivative of J_r(X) in the direction dX, applied to v.

    With s, c, e, f of `right_jacobian`, per radian of theta: ds = e - c, dc = s - f, de = f - 2 e/theta and
    df = sinc(h) (e(h) - c(h))/2 at h = theta/2.
    """
    q_x, q_y, theta = X
    dq_x, dq_y, turn = dX
    half = theta / 2
    s, c = _sine_quotients(theta)
    remainder = _sine_remainder(theta)
    e, f = theta * remainder, sinc(half) * sinc(half) / 2
    ds, dc, de = e - c, s - f, f - 2 * remainder
    df = sinc(half) * (half * _sine_remainder(half) - _sine_quotients(half)[1]) / 2
    m_x = (de * q_x - df * q_y) * turn + e * dq_x - f * dq_y
    m_y = (df * q_x + de * q_y) * turn + f * dq_x + e * dq_y
    x = ds * turn * v[0] + dc * turn * v[1] + m_x * v[2]
    y = -dc * turn * v[0] + ds * turn * v[1] + m_y * v[2]
    return x, y, 0.0


@compiled_inside
def _last_column(X: Triple) -> tuple[float, float]:
    """Returns m_x and m_y of `right_jacobian`."""
    ratio = sinc(X[2] / 2)
    e, f = X[2] * _sine_remainder(X[2]), ratio * ratio / 2
    return e * X[0] - f * X[1], f * X[0] + e * X[1]


# Quotients of sine and cosine -----------------------------------------------------------------------------------------


@compiled
def sinc(x: float) -> float:
    """Returns sin(x)/x, 1 at x = 0; exact to rounding for every x."""
    return sin(x) / x if x != 0.0 else 1.0


@compiled
def sinc_and_slope(x: float) -> tuple[float, float]:
    """Returns sin(x)/x and its derivative (cos(x) - sin(x)/x)/x, 1 and 0 at x = 0.

    Below 0.1 rad the quotient of the derivative would lose digits; four terms of its series lose none.
    """
    value = sinc(x)
    if abs(x) < 0.1:
        square = x * x
        return value, -x * (1 / 3 - square * (1 / 30 - square * (1 / 840 - square / 45360)))
    return value, (cos(x) - value) / x


@compiled_inside
def _sine_quotients(theta: float) -> tuple[float, float]:
    """Returns sin(theta)/theta and (1 - cos theta)/theta = sin(h) sinc(h), h = theta/2."""
    half = theta / 2
    return sinc(theta), sin(half) * sinc(half)


@compiled_inside
def _sine_remainder(theta: float) -> float:
    """Returns (theta - sin theta)/theta^3, by its Taylor series where the difference would cancel."""
    if abs(theta) >= 1.0:
        return (theta - sin(theta)) / (theta * theta * theta)
    # 1/3! - theta^2/5! + ...: what nine terms leave out is 1/21! at |theta| = 1, 1e-19 of the sum
    square, series, term = theta * theta, 0.0, 1 / 6
    for k in range(4, 22, 2):
        series = series + term
        term = -term * square / (k * (k + 1))
    return series


# Angles ---------------------------------------------------------------------------------------------------------------


@compiled
def wrap(theta: float) -> float:
    """Returns the angle in [-pi, pi] that differs from theta by whole turns (an even number at odd pi)."""
    return float(theta - 2 * pi * np.rint(theta / (2 * pi)))


@compiled
def winding_number(theta: float) -> float:
    """Returns the whole turns w nearest to theta, so that theta - 2 pi w is in [-pi, pi].

    At an odd multiple of pi it is the one nearer zero, so that pi and -pi keep their signs.
    """
    turns = theta / (2 * pi)
    nearest = float(np.ceil(abs(turns) - 0.5))
    return nearest if turns > 0.0 else -nearest


@compiled
def winding_number_after(theta: float, previous: float, hysteresis: float) -> float:
    """Returns the whole turns to take off theta, which were `previous` at the last call.

    They change only once |theta - 2 pi previous| exceeds pi + hysteresis, so the turn cannot chatter at the antipode
    and `log` never comes to its singularity at 2 pi.

    Args:
        theta: unwrapped heading [rad].
        previous: winding number of the last call.
        hysteresis: how far past the antipode the old branch is kept [rad], in (0, pi).
    """
    if abs(theta - 2 * pi * previous) > pi + hysteresis:
        return winding_number(theta)
    return float(previous)


@compiled
def clip(x: float, low: float, high: float) -> float:
    """Returns x kept within [low, high]; what is not a number stays so."""
    if x < low:
        return low
    if x > high:
        return high
    return x
