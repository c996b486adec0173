"""Twists: their matrices, the adjoint actions and the bracket."""

from __future__ import annotations

from nhtrack.arrays import Array, namespace, require_last_axis
from nhtrack.se2.columns import columns, stack


def hat(xi: Array) -> Array:
    """Returns the se(2) matrix of a twist, [[0, -omega, v_x], [omega, 0, v_y], [0, 0, 0]] (paper eq. 2)."""
    xp = namespace(xi)
    v_x, v_y, omega = columns("xi", xi)
    zero = xp.zeros_like(omega)
    rows = [stack(xp, zero, -omega, v_x), stack(xp, omega, zero, v_y), stack(xp, zero, zero, zero)]
    return xp.stack(rows, axis=-2)


def vee(matrix_: Array) -> Array:
    """Returns the twist (v_x, v_y, omega) of an se(2) matrix, (..., 3, 3) -> (..., 3); inverse of `hat`."""
    xp = namespace(matrix_)
    require_last_axis("matrix_", matrix_, 3)
    return xp.stack([matrix_[..., 0, 2], matrix_[..., 1, 2], matrix_[..., 1, 0]], axis=-1)


def Ad(g: Array, xi: Array) -> Array:
    """Returns Ad_g xi, the twist of `g hat(xi) g^-1` (paper eq. 3).

    `(R v + omega (y, -x), omega)`: a twist given in the frame of g, expressed in the parent frame.
    """
    xp = namespace(g, xi)
    x, y, theta = columns("g", g)
    v_x, v_y, omega = columns("xi", xi)
    c, s = xp.cos(theta), xp.sin(theta)
    return stack(xp, c * v_x - s * v_y + omega * y, s * v_x + c * v_y - omega * x, omega)


def Ad_inverse(g: Array, xi: Array) -> Array:
    """Returns Ad_{g^-1} xi = `(R^T (v + omega (-y, x)), omega)`.

    With g = between(i, j): the twist of i carried rigidly to the place of j, in the frame of j.
    """
    xp = namespace(g, xi)
    x, y, theta = columns("g", g)
    v_x, v_y, omega = columns("xi", xi)
    c, s = xp.cos(theta), xp.sin(theta)
    w_x, w_y = v_x - omega * y, v_y + omega * x
    return stack(xp, c * w_x + s * w_y, c * w_y - s * w_x, omega)


def Ad_matrix(g: Array) -> Array:
    """Returns the matrix of Ad_g acting on (v_x, v_y, omega), shape (..., 3, 3)."""
    xp = namespace(g)
    x, y, theta = columns("g", g)
    c, s = xp.cos(theta), xp.sin(theta)
    zero, one = xp.zeros_like(theta), xp.ones_like(theta)
    rows = [stack(xp, c, -s, y), stack(xp, s, c, -x), stack(xp, zero, zero, one)]
    return xp.stack(rows, axis=-2)


def ad(xi: Array, eta: Array) -> Array:
    """Returns the bracket [xi, eta] = ad_xi eta, the twist of `hat(xi) hat(eta) - hat(eta) hat(xi)`.

    `(omega_eta v_y - omega_xi w_y, omega_xi w_x - omega_eta v_x, 0)` for xi = (v_x, v_y, omega_xi) and
    eta = (w_x, w_y, omega_eta).
    """
    xp = namespace(xi, eta)
    v_x, v_y, omega_xi = columns("xi", xi)
    w_x, w_y, omega_eta = columns("eta", eta)
    first = omega_eta * v_y - omega_xi * w_y
    return stack(xp, first, omega_xi * w_x - omega_eta * v_x, xp.zeros_like(first))


def ad_matrix(xi: Array) -> Array:
    """Returns the matrix of ad_xi acting on (v_x, v_y, omega), shape (..., 3, 3)."""
    xp = namespace(xi)
    v_x, v_y, omega = columns("xi", xi)
    zero = xp.zeros_like(omega)
    rows = [stack(xp, zero, -omega, v_y), stack(xp, omega, zero, -v_x), stack(xp, zero, zero, zero)]
    return xp.stack(rows, axis=-2)


def ad_transpose(xi: Array, momentum: Array) -> Array:
    """Returns ad_xi^T mu for momenta mu = (p_x, p_y, l): the coadjoint term of the Euler-Poincare equation.

    `(omega p_y, -omega p_x, v_y p_x - v_x p_y)`.
    """
    xp = namespace(xi, momentum)
    v_x, v_y, omega = columns("xi", xi)
    p_x, p_y, _ = columns("momentum", momentum)
    return stack(xp, omega * p_y, -omega * p_x, v_y * p_x - v_x * p_y)
