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

from nhtrack.se2.algebra import Ad, Ad_inverse, Ad_matrix, ad, ad_matrix, ad_transpose, hat, vee
from nhtrack.se2.angles import winding_number, wrap
from nhtrack.se2.group import act, between, compose, exp, identity, inverse, log, matrix, rotate
from nhtrack.se2.jacobians import left_jacobian, right_jacobian, right_jacobian_derivative, right_jacobian_inverse

__all__ = [
    "Ad", "Ad_inverse", "Ad_matrix", "act", "ad", "ad_matrix", "ad_transpose", "between", "compose", "exp",
    "hat", "identity", "inverse", "left_jacobian", "log", "matrix", "right_jacobian",
    "right_jacobian_derivative", "right_jacobian_inverse", "rotate", "vee", "winding_number", "wrap",
]  # fmt: skip
