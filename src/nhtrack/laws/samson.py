"""The law of Samson as De Luca, Oriolo and Samson (1998) have it: global, for a leader that does not stop.

De Luca, Oriolo and Samson, "Feedback control of a nonholonomic car-like robot", Springer 1998:

    k = 2 zeta sqrt(omega_r^2 + b v_r^2)
    v_c = v_r cos e_theta + k e_x,   omega_c = omega_r + k e_theta + b v_r sinc(e_theta) e_y

lifted to accelerations by `inner_loop`; sinc(x) = sin(x)/x. The idea is C. Samson's (ICRA 1991, Int. J. Robotics
Research 1993); robotics libraries know the law as Ramsete. e_theta enters itself, so whole turns are taken off it,
counted in the memory with hysteresis. k has a corner where the leader stands still; there k' is the derivative to
come, `2 zeta sqrt(u_theta_r^2 + b u_xr^2)`.

Assumes: velocities that the robot takes at once (here after the inner loop has settled); v_r, omega_r bounded with
bounded derivatives. Needs: v_r or omega_r that does not tend to zero. Claims: global asymptotic stability then,
by `b (e_x^2 + e_y^2)/2 + e_theta^2/2`; all gains vanish with the leader's velocities.
Checked: tests/laws/test_baselines.py (`test_samson_s_storage_...`).
"""

from __future__ import annotations

from math import sqrt
from typing import Annotated, NamedTuple

import numpy as np

from nhtrack import planar
from nhtrack.compiled import compiled
from nhtrack.laws.contract import Follower, Gain, Leader, LeaderMotion, Limits
from nhtrack.laws.gains import STIFFNESS, Hysteresis, InnerGain, PlaceDeadZoneSpeed
from nhtrack.laws.inner_loop import Velocities, inner_loop
from nhtrack.laws.leader_bounds import errors_left, not_brought_down
from nhtrack.laws.relative_motion import unturned, view, view_turns


class Gains(NamedTuple):
    """Gains of Samson's law; the defaults suit leaders of about 1 m/s and starts 10 m away."""

    zeta: Annotated[
        float, Gain("1", "damping ratio of the linearised error; below 1", search=(0.2, 0.99), above=0.0)
    ] = 0.7
    b: Annotated[float, Gain("1/L^2", "weight of place against heading", search=STIFFNESS, above=0.0)] = 1.0
    k_inner: InnerGain = 5.0
    hysteresis: Hysteresis = 0.25
    dead_zone_speed: PlaceDeadZoneSpeed = 1e-3


class Memory(NamedTuple):
    """Memory of the law.

    Attributes:
        turns: winding number of e_theta.
    """

    turns: int


def init(gains: Gains, period: float, follower: Follower, leader: Leader) -> Memory:
    """Returns the winding number of e_theta; pi and -pi keep their signs."""
    return Memory(view_turns(follower, leader))


def command(
    gains: Gains, period: float, limits: Limits, follower: Follower, leader: Leader, memory: Memory
) -> tuple[float, float, Memory]:
    """Returns u_x [m/s^2] and u_theta [rad/s^2], which lead to v_c and omega_c with their exact derivatives."""
    v_r, omega_r, u_r, alpha_r = leader.v_x, leader.omega, leader.u_x, leader.u_theta
    e = view(follower, leader)
    e_theta, turns = unturned(e, memory.turns, gains.hysteresis)
    k, k_rate = _gain(gains.zeta, gains.b, leader)
    ratio, slope = planar.sinc_and_slope(e_theta)
    aside = ratio * e.y
    aside_rate = slope * e.theta_rate * e.y + ratio * e.y_rate
    commanded = Velocities(
        v=v_r * e.cos + k * e.x,
        omega=omega_r + k * e_theta + gains.b * v_r * aside,
        v_rate=u_r * e.cos - v_r * e.sin * e.theta_rate + k_rate * e.x + k * e.x_rate,
        omega_rate=alpha_r + k_rate * e_theta + k * e.theta_rate + gains.b * (u_r * aside + v_r * aside_rate),
    )
    u_x, u_theta = inner_loop(follower, commanded, gains.k_inner)
    return u_x, u_theta, Memory(turns)


@compiled
def _gain(zeta: float, b: float, leader: Leader) -> tuple[float, float]:
    """Returns k [1/s] and k' [1/s^2]."""
    v_r, omega_r, u_r, alpha_r = leader.v_x, leader.omega, leader.u_x, leader.u_theta
    size = sqrt(omega_r * omega_r + b * v_r * v_r)
    if size == 0.0:
        growth = sqrt(alpha_r * alpha_r + b * u_r * u_r)
    else:
        growth = (omega_r * alpha_r + b * v_r * u_r) / size
    return 2 * zeta * size, 2 * zeta * growth


def beyond(gains: Gains, period: float, leader: LeaderMotion) -> tuple[str, ...]:
    """Returns that small errors are not brought down behind a leader, with the factor."""
    k = 2 * gains.zeta * np.hypot(leader.omega, sqrt(gains.b) * leader.v_x)
    left = errors_left(period, leader, k, gains.b * leader.v_x, k)
    return not_brought_down(left, period, leader, "its gains vanish with v_0 and omega_0")


def warnings(gains: Gains, limits: Limits) -> tuple[str, ...]:
    """Returns what the gains break of the source's conditions."""
    if gains.zeta < 1:
        return ()
    return (f"zeta = {gains.zeta:g} is not below 1: its source designs for complex poles, 0 < zeta < 1",)
