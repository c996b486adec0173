"""The flow of the ideal robot under constant accelerations, compiled.

    x' = v cos(theta), y' = v sin(theta), theta' = omega, v' = u_x, omega' = u_theta    (the paper's system, eq. 3)

Velocities and heading are polynomials in time; the position is their quadrature by Gauss-Legendre nodes, written in the
frame of the starting heading. Twelve nodes are exact to rounding while a robot turns less than pi per period; the less
it turns the fewer are needed.
"""

from __future__ import annotations

import math

import numpy as np

from nhtrack.compiled import compiled_inside, compiled_loop


def _rule(count: int) -> np.ndarray:
    """Returns nodes and weights on [0, 1], shape (2, count)."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return np.stack([(nodes + 1) / 2, weights / 2])


_FEW, _SOME, _MANY = _rule(4), _rule(6), _rule(12)
# Turns [rad] by the yaw rate, and by the yaw acceleration, whose powers of time are twice as high, up to which 4 and 6
# nodes leave less than 1e-16 of the path; below the first, five terms of the series of sine and cosine are exact to
# rounding.
_FEW_TURN, _SOME_TURN = (0.1, 5e-4), (0.8, 0.03)


@compiled_inside
def displacement(v: float, omega: float, u_x: float, u_theta: float, dt: float) -> tuple[float, float]:
    """Returns how far a robot comes ahead and to its left [m], in the frame of its heading at the start.

    Args:
        v: forward velocity at the start [m/s].
        omega: yaw rate at the start [rad/s].
        u_x: forward acceleration [m/s^2].
        u_theta: yaw acceleration [rad/s^2].
        dt: time [s].
    """
    by_rate, by_acceleration = abs(omega * dt), 0.5 * abs(u_theta) * dt * dt
    if by_rate <= _FEW_TURN[0] and by_acceleration <= _FEW_TURN[1]:
        return _few(v, omega, u_x, u_theta, dt)
    rule = _SOME if by_rate <= _SOME_TURN[0] and by_acceleration <= _SOME_TURN[1] else _MANY
    ahead, aside = 0.0, 0.0
    for k in range(rule.shape[1]):
        s = dt * rule[0, k]
        turned = omega * s + 0.5 * u_theta * s * s
        way = (v + u_x * s) * (dt * rule[1, k])
        ahead += way * math.cos(turned)
        aside += way * math.sin(turned)
    return ahead, aside


@compiled_inside
def _few(v: float, omega: float, u_x: float, u_theta: float, dt: float) -> tuple[float, float]:
    """Returns the displacement of a robot that hardly turns."""
    ahead, aside = 0.0, 0.0
    for k in range(4):
        s = dt * _FEW[0, k]
        turned = omega * s + 0.5 * u_theta * s * s
        way = (v + u_x * s) * (dt * _FEW[1, k])
        square = turned * turned
        cosine = 1 - square / 2 * (1 - square / 12 * (1 - square / 30 * (1 - square / 56)))
        sine = turned * (1 - square / 6 * (1 - square / 20 * (1 - square / 42 * (1 - square / 72))))
        ahead += way * cosine
        aside += way * sine
    return ahead, aside


@compiled_inside
def advance(g: np.ndarray, xi: np.ndarray, u: np.ndarray, dt: float) -> None:
    """Moves one robot through a period in place: pose g (3,), twist xi (3,) under accelerations u (2,)."""
    v, omega = xi[0], xi[2]
    ahead, aside = displacement(v, omega, u[0], u[1], dt)
    cosine, sine = math.cos(g[2]), math.sin(g[2])
    g[0] += cosine * ahead - sine * aside
    g[1] += sine * ahead + cosine * aside
    g[2] += omega * dt + 0.5 * u[1] * dt**2
    xi[0] = v + u[0] * dt
    xi[1] = 0.0
    xi[2] = omega + u[1] * dt


@compiled_loop
def advance_all(g: np.ndarray, xi: np.ndarray, u: np.ndarray, dt: float) -> None:
    """Moves robots in place: g and xi of shape (k, 3), u of shape (k, 2)."""
    for i in range(g.shape[0]):
        advance(g[i], xi[i], u[i], dt)
