"""The paper's plant and laws written a second time, from the paper alone, one robot at a time.

Homogeneous 3x3 matrices, scipy's matrix exponential, components in the paper's order (theta, x, y), the general
form of the control input (eq. 25) instead of its components; nothing of `nhtrack` is used. Slow, and plain to
compare with the text.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm, logm

Robot = np.ndarray
"""State (x, y, theta, v, omega) of one robot."""

Motion = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Pose matrix, body twist and body acceleration, both (omega, x, y)."""


def pose_matrix(robot: Robot) -> np.ndarray:
    """g of eq. (1)."""
    c, s = math.cos(robot[2]), math.sin(robot[2])
    return np.array([[c, -s, robot[0]], [s, c, robot[1]], [0.0, 0.0, 1.0]])


def hat(omega: float, x: float, y: float) -> np.ndarray:
    """se(2) matrix of (omega, x, y)."""
    return np.array([[0.0, -omega, x], [omega, 0.0, y], [0.0, 0.0, 0.0]])


def vee(matrix: np.ndarray) -> np.ndarray:
    """(omega, x, y) of an se(2) matrix."""
    return np.array([matrix[1, 0], matrix[0, 2], matrix[1, 2]])


def exponential_coordinates(theta: float, r: np.ndarray) -> np.ndarray:
    """q = A(theta)^-1 r; A is the integral of rotations, which the exponential of a block matrix holds."""
    block = np.zeros((4, 4))
    block[:2, :2] = [[0.0, -theta], [theta, 0.0]]
    block[:2, 2:] = np.eye(2)
    return np.linalg.solve(expm(block)[:2, 2:], r)


def arctan(y: float, x: float, dead_zone: float) -> float:
    """arctan(y/x), +-pi/2 at x = 0, and 0 where (x, y) is no longer than the dead zone."""
    if math.hypot(x, y) <= dead_zone:
        return 0.0
    return math.copysign(math.pi / 2, y) if x == 0 else math.atan(y / x)


@dataclass
class Branch:
    """Whole turns taken off a relative heading: the first call takes the nearest, later ones keep it a while."""

    hysteresis: float
    turns: int | None = None

    def reduce(self, theta: float) -> float:
        if self.turns is None or abs(theta - 2 * math.pi * self.turns) > math.pi + self.hysteresis:
            self.turns = 0
            while theta - 2 * math.pi * self.turns > math.pi:
                self.turns += 1
            while theta - 2 * math.pi * self.turns < -math.pi:
                self.turns -= 1
        return theta - 2 * math.pi * self.turns


@dataclass(frozen=True)
class PaperLaw:
    """Theorem 1 (with `ke` and the leader's motion) or Lemma 1 (`stabiliser`), gains as in the paper."""

    kp: float
    kd: float
    ke: float
    k: float
    bracket: bool = False
    stabiliser: bool = False
    dead_zone_length: float = 0.0
    dead_zone_speed: float = 0.0

    def __call__(self, follower: Robot, leader: Robot, u_0: np.ndarray, branch: Branch) -> np.ndarray:
        """Returns (u_x, u_theta) for the leader's input u_0 = (u_x0, u_theta0)."""
        still = (pose_matrix(leader), np.array([leader[4], leader[3], 0.0]), np.array([u_0[1], u_0[0], 0.0]))
        return self.track(follower, still, branch.reduce(follower[2] - leader[2]))

    def track(self, follower: Robot, leader: Motion, theta: float) -> np.ndarray:
        """Returns (u_x, u_theta) for a leader that may have lateral velocity; theta is the relative heading."""
        g_0, twist, force = leader
        g_01 = np.linalg.inv(g_0) @ pose_matrix(follower)
        q_x, q_y = exponential_coordinates(theta, g_01[:2, 2])
        beta = -arctan(q_y, q_x, self.dead_zone_length)
        if self.stabiliser:
            u = -self.kp * np.array([theta + self.k * beta, q_x]) - self.kd * np.array(
                [follower[4], follower[3]]
            )
            return u[::-1]
        xi_0, xi_1 = hat(*twist), hat(follower[4], follower[3], 0.0)
        xi_01 = xi_1 - np.linalg.inv(g_01) @ xi_0 @ g_01
        r_x, r_y = g_01[:2, 2]
        omega_0, v_0, v_y0 = twist
        attitude = arctan(v_y0 + omega_0 * r_x, v_0 - omega_0 * r_y, self.dead_zone_speed)
        u_e = -self.ke * np.array([theta - attitude, 0.0, 0.0])
        stabilising = np.array([theta + self.k * beta, q_x, 0.0])
        damping = vee(xi_01) * [1.0, 1.0, 0.0]
        feedforward = vee(np.linalg.inv(g_01) @ hat(*force) @ g_01)
        u = u_e - self.kp * stabilising - self.kd * damping + feedforward
        if self.bracket:
            u = u + vee(xi_1 @ xi_01 - xi_01 @ xi_1)
        return np.array([u[1], u[0]])


def rate(robots: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Time derivative of robots (n, 5) under inputs (n, 2): the paper's system (3) with v_y = 0."""
    v, omega = robots[:, 3], robots[:, 4]
    return np.stack([v * np.cos(robots[:, 2]), v * np.sin(robots[:, 2]), omega, u[:, 0], u[:, 1]], axis=1)


def integrate(robots: np.ndarray, u: np.ndarray, dt: float) -> np.ndarray:
    """Robots (n, 5) after dt at held inputs, by DOP853."""
    solution = solve_ivp(
        lambda _, y: rate(y.reshape(-1, 5), u).ravel(), (0.0, dt), robots.ravel(),
        method="DOP853", rtol=1e-12, atol=1e-14, first_step=dt,
    )  # fmt: skip
    return solution.y[:, -1].reshape(-1, 5)


# -- virtual leaders: motions as matrices of Taylor coefficients ----------------------------------------


def jet(g: np.ndarray, xi: np.ndarray, u: np.ndarray) -> np.ndarray:
    """A motion to second order in time, a 9x9 matrix.

    [[g, g', g''/2], [0, g, g'], [0, 0, g]]: such matrices multiply, invert and have exponentials and logarithms as
    power series in t do, so that what is written for poses differentiates itself. `xi` and `u` are (omega, x, y).
    """
    first = g @ hat(*xi)
    second = (first @ hat(*xi) + g @ hat(*u)) / 2
    zero = np.zeros((3, 3))
    return np.block([[g, first, second], [zero, g, first], [zero, zero, g]])


def motion(series: np.ndarray) -> Motion:
    """Pose matrix, body twist and body acceleration, (omega, x, y), of a 9x9 matrix of Taylor coefficients."""
    g, first, second = series[:3, :3], series[:3, 3:6], 2 * series[:3, 6:]
    xi = np.linalg.solve(g, first)
    return g, vee(xi), vee(np.linalg.solve(g, second) - xi @ xi)


def folded(parents: list[Motion], weights: list[float], exact: bool) -> Motion:
    """Virtual leader of eqs. (30) to (32), or with the twist and acceleration that g_c really has.

    Parents are (g, xi, u), headings less than pi apart: the logarithm is the principal one.
    """
    g, xi, u = parents[0]
    series = jet(g, xi, u)
    for weight, (g_next, xi_next, u_next) in zip(weights, parents[1:], strict=True):
        g = g @ expm(weight * np.real(logm(np.linalg.solve(g, g_next))))
        xi, u = (1 - weight) * xi + weight * xi_next, (1 - weight) * u + weight * u_next
        if exact:
            between = np.linalg.solve(series, jet(g_next, xi_next, u_next))
            series = series @ expm(weight * np.real(logm(between)))
    return motion(series) if exact else (g, xi, u)


def turning(xi: np.ndarray, u: np.ndarray, offset: np.ndarray, dead_zone: float = 0.0) -> tuple[float, float]:
    """thetabar of eq. (35) and its rate, the rate by a complex step in time."""
    x, y = offset
    if math.hypot(xi[1] - xi[0] * y, xi[2] + xi[0] * x) <= dead_zone:
        return 0.0, 0.0
    step = 1e-30
    omega, v, side = xi + 1j * step * u
    return arctan(xi[2] + xi[0] * x, xi[1] - xi[0] * y, 0.0), float(
        np.arctan((side + omega * x) / (v - omega * y)).imag / step
    )


def placed(leader: Motion, offset: np.ndarray, exact: bool, second_rate: float = 0.0) -> Motion:
    """Transformed system of Theorem 3, or with the turning of thetabar; thetabar'' is given.

    A place has no lateral acceleration along a path; as printed what Ad gives there is dropped, since no robot follows.
    """
    g, xi, u = leader
    attitude, rate = turning(xi, u, offset)
    gbar = pose_matrix(np.array([*offset, attitude, 0.0, 0.0]))
    back = np.linalg.inv(gbar)
    xi_a, u_a = (vee(back @ hat(*values) @ gbar) for values in (xi, u))
    u_a[2] = 0.0
    if exact:
        xi_a[0] += rate
        u_a[0] += second_rate
    return g @ gbar, xi_a, u_a
