"""The rival laws a second time: one robot, complex scalars, world frame, straight from their sources' equations.

Nothing is differentiated by hand. A commanded velocity is a function of the state; its derivative along the motion is
the complex step `Im f(state + i h state')/h`, which has no cancellation and is exact to rounding for tiny h.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass

STEP = 1e-30

# Pose (x, y, theta) and velocities (v, omega) of follower and leader, and the leader's accelerations.
State = tuple[complex, ...]
Commanded = Callable[[State], tuple[complex, complex]]


@dataclass(frozen=True)
class Pair:
    """A follower and its leader: (x, y, theta, v, omega) each, and the leader's (u_x, u_theta)."""

    follower: tuple[float, ...]
    leader: tuple[float, ...]
    u: tuple[float, float]

    @property
    def state(self) -> State:
        return (*self.follower, *self.leader)

    def moving(self, u_x: float = 0.0) -> State:
        """Returns state + i h state'; the follower accelerates with u_x, its omega' enters nothing."""
        theta, v, omega = self.follower[2:]
        thetar, vr, omegar = self.leader[2:]
        rate = (v * math.cos(theta), v * math.sin(theta), omega, u_x, 0.0)
        rate += (vr * math.cos(thetar), vr * math.sin(thetar), omegar, *self.u)
        return tuple(s + 1j * STEP * r for s, r in zip(self.state, rate, strict=True))


def error(state: State) -> tuple[complex, complex, complex]:
    """Returns Kanayama's error (e_x, e_y, e_theta), the heading within pi."""
    x, y, theta = state[:3]
    xr, yr, thetar = state[5:8]
    c, s = cmath.cos(theta), cmath.sin(theta)
    heading = thetar - theta
    heading -= 2 * math.pi * round(heading.real / (2 * math.pi))
    return c * (xr - x) + s * (yr - y), -s * (xr - x) + c * (yr - y), heading


def lifted(pair: Pair, commanded: Commanded, K: float) -> tuple[float, float]:
    """Returns u = commanded' - K (velocity - commanded)."""
    now, soon = commanded(tuple(map(complex, pair.state))), commanded(pair.moving())
    v, omega = pair.follower[3:]
    u_x = soon[0].imag / STEP - K * (v - now[0].real)
    return u_x, soon[1].imag / STEP - K * (omega - now[1].real)


def kanayama(pair: Pair, k_x: float, k_y: float, k_theta: float, K: float) -> tuple[float, float]:
    def commanded(state: State) -> tuple[complex, complex]:
        e_x, e_y, e = error(state)
        vr, wr = state[8:]
        return vr * cmath.cos(e) + k_x * e_x, wr + vr * (k_y * e_y + k_theta * cmath.sin(e))

    return lifted(pair, commanded, K)


def samson(pair: Pair, zeta: float, b: float, K: float) -> tuple[float, float]:
    def commanded(state: State) -> tuple[complex, complex]:
        e_x, e_y, e = error(state)
        vr, wr = state[8:]
        k = 2 * zeta * cmath.sqrt(wr**2 + b * vr**2)
        return vr * cmath.cos(e) + k * e_x, wr + k * e + b * vr * cmath.sin(e) / e * e_y

    return lifted(pair, commanded, K)


def jiang_nijmeijer(pair: Pair, k_x: float, gamma: float, k_theta: float, K: float, a: float) -> tuple[float, float]:
    def commanded(state: State) -> tuple[complex, complex]:
        e_x, e_y, e = error(state)
        vr, wr = state[8:]
        return vr * cmath.cos(e) + k_x * e_x, wr + gamma * vr * e_y * cmath.sin(e) / e + k_theta * e

    e_x, _, e = error(pair.state)
    u_x, u_theta = lifted(pair, commanded, K)
    return u_x + a * e_x.real, u_theta + a * e.real


def look_ahead(pair: Pair, d: float, k: float, K: float) -> tuple[float, float]:
    def commanded(state: State) -> tuple[complex, complex]:
        x, y, theta = state[:3]
        xr, yr, thetar, vr, wr = state[5:]
        c, s, cr, sr = cmath.cos(theta), cmath.sin(theta), cmath.cos(thetar), cmath.sin(thetar)
        w_1 = vr * cr - d * wr * sr + k * (xr + d * cr - x - d * c)
        w_2 = vr * sr + d * wr * cr + k * (yr + d * sr - y - d * s)
        return c * w_1 + s * w_2, (-s * w_1 + c * w_2) / d

    return lifted(pair, commanded, K)


def feedback_linearisation(pair: Pair, kp: float, kd: float, K: float, v_min: float) -> tuple[float, float]:
    def wanted(state: State) -> tuple[complex, complex]:
        """Returns w along and across the follower's heading."""
        x, y, theta, v = state[:4]
        xr, yr, thetar, vr, wr = state[5:]
        c, s, cr, sr = cmath.cos(theta), cmath.sin(theta), cmath.cos(thetar), cmath.sin(thetar)
        w_1 = pair.u[0] * cr - vr * wr * sr + kd * (vr * cr - v * c) + kp * (xr - x)
        w_2 = pair.u[0] * sr + vr * wr * cr + kd * (vr * sr - v * s) + kp * (yr - y)
        return c * w_1 + s * w_2, c * w_2 - s * w_1

    v, omega = pair.follower[3:]
    vr = pair.leader[3]
    deciding = vr if abs(vr) > v_min else v
    sign = -1.0 if deciding < 0 else 1.0
    along = wanted(pair.state)[0].real
    regular = sign * v >= v_min

    def turning(state: State) -> complex:
        return wanted(state)[1] / (state[3] if regular else sign * v_min)

    now, soon = turning(pair.state).real, turning(pair.moving(u_x=along)).imag / STEP
    u_x = along
    if abs(vr) > v_min and not regular:
        u_x = sign * max(sign * along, 0.0) - K * (v - sign * v_min)
    return u_x, soon - K * (omega - now)
