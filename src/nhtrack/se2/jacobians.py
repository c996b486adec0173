"""Jacobians of the exponential, their inverse and their derivative."""

from __future__ import annotations

from nhtrack.arrays import Array, Namespace, namespace
from nhtrack.se2.columns import columns, sinc, stack


def right_jacobian(X: Array) -> Array:
    """Returns J_r(X), shape (..., 3, 3), with body twist `xi = J_r(X) dX/dt` along g = exp(X(t)).

    J_r(X) = sum_k (-ad_X)^k / (k + 1)! = [[s, c, m_x], [-c, s, m_y], [0, 0, 1]] with s and c as in `exp`,
    m_x = e q_x - f q_y and m_y = f q_x + e q_y, where e = (theta - sin theta)/theta^2 and
    f = (1 - cos theta)/theta^2 = sinc(theta/2)^2 / 2.
    """
    xp = namespace(X)
    q_x, q_y, theta = columns("X", X)
    half = theta / 2
    s, c = sinc(xp, theta), xp.sin(half) * sinc(xp, half)
    e, f = theta * _sine_remainder(xp, theta), sinc(xp, half) ** 2 / 2
    zero, one = xp.zeros_like(theta), xp.ones_like(theta)
    rows = [
        stack(xp, s, c, e * q_x - f * q_y),
        stack(xp, -c, s, f * q_x + e * q_y),
        stack(xp, zero, zero, one),
    ]
    return xp.stack(rows, axis=-2)


def left_jacobian(X: Array) -> Array:
    """Returns J_l(X) = J_r(-X), with spatial twist `xi^s = J_l(X) dX/dt` along g = exp(X(t))."""
    return right_jacobian(-X)


def right_jacobian_inverse(X: Array) -> Array:
    """Returns J_r(X)^-1, shape (..., 3, 3), with `dX/dt = J_r(X)^-1 xi` along g = exp(X(t)).

    The blocks of `right_jacobian` inverted: [[a, -h, -(a m_x - h m_y)], [h, a, -(h m_x + a m_y)], [0, 0, 1]]
    with a and h as in `log`; |theta| < 2 pi.
    """
    xp = namespace(X)
    q_x, q_y, theta = columns("X", X)
    half = theta / 2
    a = xp.cos(half) / sinc(xp, half)
    e, f = theta * _sine_remainder(xp, theta), sinc(xp, half) ** 2 / 2
    m_x, m_y = e * q_x - f * q_y, f * q_x + e * q_y
    zero, one = xp.zeros_like(theta), xp.ones_like(theta)
    rows = [
        stack(xp, a, -half, -(a * m_x - half * m_y)),
        stack(xp, half, a, -(half * m_x + a * m_y)),
        stack(xp, zero, zero, one),
    ]
    return xp.stack(rows, axis=-2)


def right_jacobian_derivative(X: Array, dX: Array) -> Array:
    """Returns the derivative of J_r(X) in the direction dX, shape (..., 3, 3).

    `d/dt J_r(X(t))` for dX = dX/dt, which accelerations of g = exp(X(t)) need: with s, c, e, f of `right_jacobian`,
    ds = e - c, dc = s - f, de = f - 2 e/theta and df = sinc(h) (e(h) - c(h))/2 at h = theta/2, per radian of theta.
    """
    xp = namespace(X, dX)
    q_x, q_y, theta = columns("X", X)
    dq_x, dq_y, turn = columns("dX", dX)
    half = theta / 2
    s, c = sinc(xp, theta), xp.sin(half) * sinc(xp, half)
    remainder = _sine_remainder(xp, theta)
    e, f = theta * remainder, sinc(xp, half) ** 2 / 2
    ds, dc, de = e - c, s - f, f - 2 * remainder
    quarter = half / 2
    df = sinc(xp, half) * (half * _sine_remainder(xp, half) - xp.sin(quarter) * sinc(xp, quarter)) / 2
    zero = xp.zeros_like(theta * turn)
    rows = [
        stack(xp, ds * turn, dc * turn, (de * q_x - df * q_y) * turn + e * dq_x - f * dq_y),
        stack(xp, -dc * turn, ds * turn, (df * q_x + de * q_y) * turn + f * dq_x + e * dq_y),
        stack(xp, zero, zero, zero),
    ]
    return xp.stack(rows, axis=-2)


def _sine_remainder(xp: Namespace, theta: Array) -> Array:
    """Returns (theta - sin theta)/theta^3, by its Taylor series where the difference would cancel."""
    near = xp.abs(theta) < 1.0
    safe = xp.where(near, xp.ones_like(theta), theta)
    far_value = (safe - xp.sin(safe)) / (safe * safe * safe)
    small = xp.where(near, theta, xp.zeros_like(theta))
    square = small * small
    # 1/3! - theta^2/5! + ...: what nine terms leave out is 1/21! at |theta| = 1, 1e-19 of the sum
    series, term = xp.zeros_like(theta), xp.full_like(theta, 1 / 6)
    for k in range(4, 22, 2):
        series = series + term
        term = -term * square / (k * (k + 1))
    return xp.where(near, series, far_value)
