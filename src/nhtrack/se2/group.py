"""Poses: the group, its action on points, exponential and logarithm."""

from __future__ import annotations

from nhtrack.arrays import Array, Namespace, namespace, require_last_axis
from nhtrack.se2.columns import columns, sinc, stack


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
    return stack(xp, c * p[..., 0] - s * p[..., 1], s * p[..., 0] + c * p[..., 1])


def compose(a: Array, b: Array) -> Array:
    """Returns the product a b = `(p_a + R(theta_a) p_b, theta_a + theta_b)`; headings add unwrapped."""
    xp = namespace(a, b)
    x_a, y_a, theta_a = columns("a", a)
    x_b, y_b, theta_b = columns("b", b)
    c, s = xp.cos(theta_a), xp.sin(theta_a)
    return stack(xp, x_a + c * x_b - s * y_b, y_a + s * x_b + c * y_b, theta_a + theta_b)


def inverse(g: Array) -> Array:
    """Returns g^-1 = `(-R(theta)^T p, -theta)`."""
    xp = namespace(g)
    x, y, theta = columns("g", g)
    c, s = xp.cos(theta), xp.sin(theta)
    return stack(xp, -c * x - s * y, s * x - c * y, -theta)


def between(a: Array, b: Array) -> Array:
    """Returns the pose of b seen from a (paper eq. 5).

    a^-1 b = `(R(theta_a)^T (p_b - p_a), theta_b - theta_a)`. Positions are subtracted before they are
    rotated, so two poses far from the origin and close to each other lose no digits.
    """
    xp = namespace(a, b)
    x_a, y_a, theta_a = columns("a", a)
    x_b, y_b, theta_b = columns("b", b)
    c, s = xp.cos(theta_a), xp.sin(theta_a)
    dx, dy = x_b - x_a, y_b - y_a
    return stack(xp, c * dx + s * dy, c * dy - s * dx, theta_b - theta_a)


def act(g: Array, p: Array) -> Array:
    """Returns the points R(theta) p + (x, y), shape (..., 2), for points p of shape (..., 2)."""
    return g[..., :2] + rotate(g[..., 2], p)


def exp(X: Array) -> Array:
    """Returns the pose reached after unit time at the constant body twist X = (q_x, q_y, theta).

    exp X = `(V(theta) q, theta)`, V = [[s, -c], [c, s]], s = sin(theta)/theta, c = (1 - cos theta)/theta.
    With h = theta/2: s = sinc(theta), c = sin(h) sinc(h).
    """
    xp = namespace(X)
    q_x, q_y, theta = columns("X", X)
    half = theta / 2
    s, c = sinc(xp, theta), xp.sin(half) * sinc(xp, half)
    return stack(xp, s * q_x - c * q_y, c * q_x + s * q_y, theta)


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
    x, y, theta = columns("g", g)
    half = theta / 2
    a = xp.cos(half) / sinc(xp, half)
    return stack(xp, a * x + half * y, a * y - half * x, theta)


def matrix(g: Array) -> Array:
    """Returns the homogeneous matrix [[R, p], [0, 1]] of a pose, shape (..., 3, 3) (paper eq. 1)."""
    xp = namespace(g)
    x, y, theta = columns("g", g)
    c, s = xp.cos(theta), xp.sin(theta)
    zero, one = xp.zeros_like(theta), xp.ones_like(theta)
    rows = [stack(xp, c, -s, x), stack(xp, s, c, y), stack(xp, zero, zero, one)]
    return xp.stack(rows, axis=-2)
