"""The group SE(2) of planar poses and its algebra, batched and free of branches.

Conventions (docs/theory.md):

- pose `g = (x, y, theta)`: position [m] and heading [rad] in the parent frame. `theta` is a continuous real,
  not wrapped: `log` uses the branch that its value names, so pi and -pi are different arguments.
- twist `xi = (v_x, v_y, omega)`: velocity [m/s, m/s, rad/s] in the body frame, linear part first.
- exponential coordinates `X = (q_x, q_y, theta)`: `g = exp(X)`.

Every function maps arrays of shape (..., 3) to arrays of shape (..., 3), broadcasting over the leading axes,
and runs on any array-API library. The trigonometric quotients of `exp` and `log` are written with `sinc` of
the half angle, which has no singular argument inside |theta| < 2 pi, so they need no Taylor switch and lose
no digits.
"""

from __future__ import annotations

from math import pi

from nhtrack.arrays import Array, Namespace, namespace, require_last_axis

__all__ = [
    "Ad", "Ad_inverse", "Ad_matrix", "act", "ad", "ad_matrix", "ad_transpose", "between", "compose", "exp",
    "hat", "identity", "inverse", "left_jacobian", "log", "matrix", "right_jacobian",
    "right_jacobian_derivative", "right_jacobian_inverse", "rotate", "vee", "winding_number", "wrap",
]  # fmt: skip


def _sinc(xp: Namespace, x: Array) -> Array:
    """Returns sin(x)/x, 1 at x = 0; exact to rounding for every x."""
    at_zero = x == 0
    safe = xp.where(at_zero, xp.ones_like(x), x)
    return xp.where(at_zero, xp.ones_like(x), xp.sin(safe) / safe)


def _columns(name: str, array: Array) -> tuple[Array, Array, Array]:
    require_last_axis(name, array, 3)
    return array[..., 0], array[..., 1], array[..., 2]


def _stack(xp: Namespace, *columns: Array) -> Array:
    return xp.stack(xp.broadcast_arrays(*columns), axis=-1)


def identity(xp: Namespace, batch: tuple[int, ...] = ()) -> Array:
    """Returns the identity pose (0, 0, 0), shape (*batch, 3), in namespace `xp`."""
    return xp.zeros((*batch, 3))


def rotate(theta: Array, p: Array) -> Array:
    """Returns R(theta) p for planar vectors.

    Args:
        theta: angles [rad], shape (...).
        p: vectors, shape (..., 2).
    """
    xp = namespace(theta, p)
    require_last_axis("p", p, 2)
    c, s = xp.cos(theta), xp.sin(theta)
    return _stack(xp, c * p[..., 0] - s * p[..., 1], s * p[..., 0] + c * p[..., 1])


def compose(a: Array, b: Array) -> Array:
    """Returns the product a b = `(p_a + R(theta_a) p_b, theta_a + theta_b)`; headings add unwrapped."""
    xp = namespace(a, b)
    x_a, y_a, theta_a = _columns("a", a)
    x_b, y_b, theta_b = _columns("b", b)
    c, s = xp.cos(theta_a), xp.sin(theta_a)
    return _stack(xp, x_a + c * x_b - s * y_b, y_a + s * x_b + c * y_b, theta_a + theta_b)


def inverse(g: Array) -> Array:
    """Returns g^-1 = `(-R(theta)^T p, -theta)`."""
    xp = namespace(g)
    x, y, theta = _columns("g", g)
    c, s = xp.cos(theta), xp.sin(theta)
    return _stack(xp, -c * x - s * y, s * x - c * y, -theta)


def between(a: Array, b: Array) -> Array:
    """Returns the pose of b seen from a (paper eq. 5).

    a^-1 b = `(R(theta_a)^T (p_b - p_a), theta_b - theta_a)`. Positions are subtracted before they are
    rotated, so two poses far from the origin and close to each other lose no digits.
    """
    xp = namespace(a, b)
    x_a, y_a, theta_a = _columns("a", a)
    x_b, y_b, theta_b = _columns("b", b)
    c, s = xp.cos(theta_a), xp.sin(theta_a)
    dx, dy = x_b - x_a, y_b - y_a
    return _stack(xp, c * dx + s * dy, c * dy - s * dx, theta_b - theta_a)


def act(g: Array, p: Array) -> Array:
    """Returns the points R(theta) p + (x, y), shape (..., 2), for points p of shape (..., 2)."""
    return g[..., :2] + rotate(g[..., 2], p)


def exp(X: Array) -> Array:
    """Returns the pose reached after unit time at the constant body twist X = (q_x, q_y, theta).

    exp X = `(V(theta) q, theta)`, V = [[s, -c], [c, s]], s = sin(theta)/theta, c = (1 - cos theta)/theta.
    With h = theta/2: s = sinc(theta), c = sin(h) sinc(h).
    """
    xp = namespace(X)
    q_x, q_y, theta = _columns("X", X)
    half = theta / 2
    s, c = _sinc(xp, theta), xp.sin(half) * _sinc(xp, half)
    return _stack(xp, s * q_x - c * q_y, c * q_x + s * q_y, theta)


def log(g: Array) -> Array:
    """Returns the exponential coordinates X = (q_x, q_y, theta) with exp X = g (paper eq. 4).

    log g = `(V^-1(theta) p, theta)`, V^-1 = [[a, h], [-h, a]], h = theta/2, a = h cot(h) = cos(h)/sinc(h).
    The branch is the one that the value of theta names: at |theta| = pi, where the logarithm of the rotation
    has two values, the sign of theta decides.

    Args:
        g: poses, shape (..., 3), with |theta| < 2 pi (the map is singular at +-2 pi); see `winding_number`
            for bringing an unwrapped heading into that range.
    """
    xp = namespace(g)
    x, y, theta = _columns("g", g)
    half = theta / 2
    a = xp.cos(half) / _sinc(xp, half)
    return _stack(xp, a * x + half * y, a * y - half * x, theta)


def hat(xi: Array) -> Array:
    """Returns the se(2) matrix of a twist, [[0, -omega, v_x], [omega, 0, v_y], [0, 0, 0]] (paper eq. 2)."""
    xp = namespace(xi)
    v_x, v_y, omega = _columns("xi", xi)
    zero = xp.zeros_like(omega)
    rows = [_stack(xp, zero, -omega, v_x), _stack(xp, omega, zero, v_y), _stack(xp, zero, zero, zero)]
    return xp.stack(rows, axis=-2)


def vee(matrix_: Array) -> Array:
    """Returns the twist (v_x, v_y, omega) of an se(2) matrix, (..., 3, 3) -> (..., 3); inverse of `hat`."""
    xp = namespace(matrix_)
    require_last_axis("matrix_", matrix_, 3)
    return xp.stack([matrix_[..., 0, 2], matrix_[..., 1, 2], matrix_[..., 1, 0]], axis=-1)


def matrix(g: Array) -> Array:
    """Returns the homogeneous matrix [[R, p], [0, 1]] of a pose, shape (..., 3, 3) (paper eq. 1)."""
    xp = namespace(g)
    x, y, theta = _columns("g", g)
    c, s = xp.cos(theta), xp.sin(theta)
    zero, one = xp.zeros_like(theta), xp.ones_like(theta)
    rows = [_stack(xp, c, -s, x), _stack(xp, s, c, y), _stack(xp, zero, zero, one)]
    return xp.stack(rows, axis=-2)


def Ad(g: Array, xi: Array) -> Array:
    """Returns Ad_g xi, the twist of `g hat(xi) g^-1` (paper eq. 3).

    `(R v + omega (y, -x), omega)`: a twist given in the frame of g, expressed in the parent frame.
    """
    xp = namespace(g, xi)
    x, y, theta = _columns("g", g)
    v_x, v_y, omega = _columns("xi", xi)
    c, s = xp.cos(theta), xp.sin(theta)
    return _stack(xp, c * v_x - s * v_y + omega * y, s * v_x + c * v_y - omega * x, omega)


def Ad_inverse(g: Array, xi: Array) -> Array:
    """Returns Ad_{g^-1} xi = `(R^T (v + omega (-y, x)), omega)`.

    With g = between(i, j): the twist of i carried rigidly to the place of j, in the frame of j.
    """
    xp = namespace(g, xi)
    x, y, theta = _columns("g", g)
    v_x, v_y, omega = _columns("xi", xi)
    c, s = xp.cos(theta), xp.sin(theta)
    w_x, w_y = v_x - omega * y, v_y + omega * x
    return _stack(xp, c * w_x + s * w_y, c * w_y - s * w_x, omega)


def Ad_matrix(g: Array) -> Array:
    """Returns the matrix of Ad_g acting on (v_x, v_y, omega), shape (..., 3, 3)."""
    xp = namespace(g)
    x, y, theta = _columns("g", g)
    c, s = xp.cos(theta), xp.sin(theta)
    zero, one = xp.zeros_like(theta), xp.ones_like(theta)
    rows = [_stack(xp, c, -s, y), _stack(xp, s, c, -x), _stack(xp, zero, zero, one)]
    return xp.stack(rows, axis=-2)


def ad(xi: Array, eta: Array) -> Array:
    """Returns the bracket [xi, eta] = ad_xi eta, the twist of `hat(xi) hat(eta) - hat(eta) hat(xi)`.

    `(omega_eta v_y - omega_xi w_y, omega_xi w_x - omega_eta v_x, 0)` for xi = (v_x, v_y, omega_xi) and
    eta = (w_x, w_y, omega_eta).
    """
    xp = namespace(xi, eta)
    v_x, v_y, omega_xi = _columns("xi", xi)
    w_x, w_y, omega_eta = _columns("eta", eta)
    first = omega_eta * v_y - omega_xi * w_y
    return _stack(xp, first, omega_xi * w_x - omega_eta * v_x, xp.zeros_like(first))


def ad_matrix(xi: Array) -> Array:
    """Returns the matrix of ad_xi acting on (v_x, v_y, omega), shape (..., 3, 3)."""
    xp = namespace(xi)
    v_x, v_y, omega = _columns("xi", xi)
    zero = xp.zeros_like(omega)
    rows = [_stack(xp, zero, -omega, v_y), _stack(xp, omega, zero, -v_x), _stack(xp, zero, zero, zero)]
    return xp.stack(rows, axis=-2)


def ad_transpose(xi: Array, momentum: Array) -> Array:
    """Returns ad_xi^T mu for momenta mu = (p_x, p_y, l): the coadjoint term of the Euler-Poincare equation.

    `(omega p_y, -omega p_x, v_y p_x - v_x p_y)`.
    """
    xp = namespace(xi, momentum)
    v_x, v_y, omega = _columns("xi", xi)
    p_x, p_y, _ = _columns("momentum", momentum)
    return _stack(xp, omega * p_y, -omega * p_x, v_y * p_x - v_x * p_y)


def right_jacobian(X: Array) -> Array:
    """Returns J_r(X), shape (..., 3, 3), with body twist `xi = J_r(X) dX/dt` along g = exp(X(t)).

    J_r(X) = sum_k (-ad_X)^k / (k + 1)! = [[s, c, m_x], [-c, s, m_y], [0, 0, 1]] with s and c as in `exp`,
    m_x = e q_x - f q_y and m_y = f q_x + e q_y, where e = (theta - sin theta)/theta^2 and
    f = (1 - cos theta)/theta^2 = sinc(theta/2)^2 / 2.
    """
    xp = namespace(X)
    q_x, q_y, theta = _columns("X", X)
    half = theta / 2
    s, c = _sinc(xp, theta), xp.sin(half) * _sinc(xp, half)
    e, f = theta * _sine_remainder(xp, theta), _sinc(xp, half) ** 2 / 2
    zero, one = xp.zeros_like(theta), xp.ones_like(theta)
    rows = [
        _stack(xp, s, c, e * q_x - f * q_y),
        _stack(xp, -c, s, f * q_x + e * q_y),
        _stack(xp, zero, zero, one),
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
    q_x, q_y, theta = _columns("X", X)
    half = theta / 2
    a = xp.cos(half) / _sinc(xp, half)
    e, f = theta * _sine_remainder(xp, theta), _sinc(xp, half) ** 2 / 2
    m_x, m_y = e * q_x - f * q_y, f * q_x + e * q_y
    zero, one = xp.zeros_like(theta), xp.ones_like(theta)
    rows = [
        _stack(xp, a, -half, -(a * m_x - half * m_y)),
        _stack(xp, half, a, -(half * m_x + a * m_y)),
        _stack(xp, zero, zero, one),
    ]
    return xp.stack(rows, axis=-2)


def right_jacobian_derivative(X: Array, dX: Array) -> Array:
    """Returns the derivative of J_r(X) in the direction dX, shape (..., 3, 3).

    `d/dt J_r(X(t))` for dX = dX/dt, which accelerations of g = exp(X(t)) need: with s, c, e, f of `right_jacobian`,
    ds = e - c, dc = s - f, de = f - 2 e/theta and df = sinc(h) (e(h) - c(h))/2 at h = theta/2, per radian of theta.
    """
    xp = namespace(X, dX)
    q_x, q_y, theta = _columns("X", X)
    dq_x, dq_y, turn = _columns("dX", dX)
    half = theta / 2
    s, c = _sinc(xp, theta), xp.sin(half) * _sinc(xp, half)
    remainder = _sine_remainder(xp, theta)
    e, f = theta * remainder, _sinc(xp, half) ** 2 / 2
    ds, dc, de = e - c, s - f, f - 2 * remainder
    quarter = half / 2
    df = _sinc(xp, half) * (half * _sine_remainder(xp, half) - xp.sin(quarter) * _sinc(xp, quarter)) / 2
    zero = xp.zeros_like(theta * turn)
    rows = [
        _stack(xp, ds * turn, dc * turn, (de * q_x - df * q_y) * turn + e * dq_x - f * dq_y),
        _stack(xp, -dc * turn, ds * turn, (df * q_x + de * q_y) * turn + f * dq_x + e * dq_y),
        _stack(xp, zero, zero, zero),
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


def wrap(theta: Array) -> Array:
    """Returns the angle in [-pi, pi] that differs from theta by whole turns (an even number at odd pi)."""
    xp = namespace(theta)
    return theta - 2 * pi * xp.round(theta / (2 * pi))


def winding_number(theta: Array, previous: Array | None = None, hysteresis: float = 0.25) -> Array:
    """Returns the whole turns w to take off an unwrapped heading so that theta - 2 pi w stays near [-pi, pi].

    The memory that a plain wrap lacks. Without `previous` the turn is the nearest one, and at an odd multiple
    of pi the one nearer zero, so that pi and -pi keep their signs. With `previous` the turn changes only once
    |theta - 2 pi previous| exceeds pi + hysteresis, so it cannot chatter at the antipode and never reaches
    the singularity of `log` at 2 pi.

    Args:
        theta: unwrapped headings [rad], shape (...).
        previous: winding numbers of the last call, shape (...), or None at the start.
        hysteresis: how far past the antipode the old branch is kept [rad], in (0, pi).
    """
    xp = namespace(theta)
    turns = theta / (2 * pi)
    nearest = xp.sign(turns) * xp.ceil(xp.abs(turns) - 0.5)
    if previous is None:
        return nearest
    return xp.where(xp.abs(theta - 2 * pi * previous) > pi + hysteresis, nearest, previous)
