"""The law of Jiang and Nijmeijer (1997) for accelerations: global, for a leader that does not stop.

Jiang and Nijmeijer, "Tracking control of mobile robots: a case study in backstepping", Automatica 33 (1997) 1393-1399,
for their dynamic model, by backstepping through the velocities:

    v_c = v_r cos e_theta + k_x e_x,   omega_c = omega_r + k_theta e_theta + gamma v_r sinc(e_theta) e_y
    u_x = v_c' - K (v - v_c) + a e_x,   u_theta = omega_c' - K (omega - omega_c) + a e_theta

with sinc(x) = sin(x)/x. The storage function

    V = (e_x^2 + e_y^2)/2 + e_theta^2/(2 gamma) + ((v - v_c)^2 + (omega - omega_c)^2/gamma)/(2 a)

obeys `V' = -k_x e_x^2 - k_theta e_theta^2/gamma - K ((v - v_c)^2 + (omega - omega_c)^2/gamma)/a`. The source has no
a, which would add metres to metres per second, and 1/gamma in its place before e_theta; with gamma = 1/m^2 and
a = 1/s^2 the two are one. Whole turns are taken off e_theta, counted in the memory with hysteresis, which can only
lower V.

Assumes: v_r, omega_r and their derivatives bounded. Needs: v_r or omega_r that does not tend to zero. Claims:
global asymptotic tracking then. With the leader at rest e_x and e_theta vanish and e_y stays.
Checked: tests/laws/test_baselines.py (`test_jiang_nijmeijer_...`).
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from nhtrack import planar
from nhtrack.laws.contract import Follower, Gain, Leader, LeaderMotion, Limits
from nhtrack.laws.gains import DAMPING, STIFFNESS, Hysteresis, InnerGain, PlaceDeadZoneSpeed
from nhtrack.laws.inner_loop import Velocities, inner_loop
from nhtrack.laws.leader_bounds import errors_left, not_brought_down
from nhtrack.laws.relative_motion import unturned, view, view_turns


class Gains(NamedTuple):
    """Gains of Jiang and Nijmeijer's law, K being k_inner and a the coupling.

    The defaults suit leaders of about 1 m/s and starts 10 m away.
    """

    k_x: Annotated[float, Gain("1/T", "gain on the distance ahead", search=DAMPING, above=0.0)] = 1.0
    gamma: Annotated[float, Gain("1/L^2", "weight of place against heading", search=STIFFNESS, above=0.0)] = 1.0
    k_theta: Annotated[float, Gain("1/T", "gain on the heading", search=DAMPING, above=0.0)] = 1.0
    k_inner: InnerGain = 5.0
    coupling: Annotated[
        float, Gain("1/T^2", "what the errors add to the accelerations", search=STIFFNESS, above=0.0)
    ] = 1.0
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
    """Returns u_x [m/s^2] and u_theta [rad/s^2], with exact derivatives of v_c and omega_c, and the winding number."""
    k_x, gamma, k_theta, a = gains.k_x, gains.gamma, gains.k_theta, gains.coupling
    v_r, omega_r, u_r, alpha_r = leader.v_x, leader.omega, leader.u_x, leader.u_theta
    e = view(follower, leader)
    e_theta, turns = unturned(e, memory.turns, gains.hysteresis)
    ratio, slope = planar.sinc_and_slope(e_theta)
    aside = ratio * e.y
    aside_rate = slope * e.theta_rate * e.y + ratio * e.y_rate
    v_rate = u_r * e.cos - v_r * e.sin * e.theta_rate + k_x * e.x_rate
    omega_rate = alpha_r + k_theta * e.theta_rate + gamma * (u_r * aside + v_r * aside_rate)
    commanded = Velocities(
        v=v_r * e.cos + k_x * e.x,
        omega=omega_r + k_theta * e_theta + gamma * v_r * aside,
        v_rate=v_rate + a * e.x,
        omega_rate=omega_rate + a * e_theta,
    )
    u_x, u_theta = inner_loop(follower, commanded, gains.k_inner)
    return u_x, u_theta, Memory(turns)


def beyond(gains: Gains, period: float, leader: LeaderMotion) -> tuple[str, ...]:
    """Returns that small errors are not brought down behind a leader, with the factor."""
    v, more = leader.v_x, gains.coupling / gains.k_inner
    ahead, turning = np.full_like(v, gains.k_x + more), np.full_like(v, gains.k_theta + more)
    left = errors_left(period, leader, ahead, gains.gamma * v, turning)
    return not_brought_down(left, period, leader, "its gains on e_y vanish with v_0 and omega_0")


def warnings(gains: Gains, limits: Limits) -> tuple[str, ...]:
    """Returns nothing: the source asks for positive gains only."""
    return ()
