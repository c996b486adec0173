"""The law of Kanayama et al. (1990): local, for a leader that drives forward.

Kanayama, Kimura, Miyazaki and Noguchi, "A stable tracking control method for an autonomous mobile robot", ICRA 1990:

    v_c = v_r cos e_theta + k_x e_x,   omega_c = omega_r + v_r (k_y e_y + k_theta sin e_theta)

lifted to accelerations by `inner_loop`. Only sine and cosine of the heading enter: no memory.

Assumes: velocities that the robot takes at once (here after the inner loop has settled); v_r > 0, slowly varying.
Needs: a leader that moves forward; at rest e_y and e_theta are left as they are.
Claims: local asymptotic stability, by `(e_x^2 + e_y^2)/2 + (1 - cos e_theta)/k_y`; e_theta = pi is an equilibrium
too, unstable for v_r > 0. Critically damped on a line where k_theta^2 = 4 k_y.
Checked: tests/laws/test_baselines.py (`test_kanayama_s_storage_...`).
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from nhtrack.laws.contract import Follower, Gain, Leader, LeaderMotion, Limits
from nhtrack.laws.gains import DAMPING, STIFFNESS, InnerGain, PlaceDeadZoneSpeed
from nhtrack.laws.inner_loop import Velocities, inner_loop
from nhtrack.laws.leader_bounds import errors_left, not_brought_down
from nhtrack.laws.relative_motion import view


class Gains(NamedTuple):
    """Gains of Kanayama's law; the defaults suit leaders of about 1 m/s and starts 10 m away."""

    k_x: Annotated[float, Gain("1/T", "gain on the distance ahead", search=DAMPING, above=0.0)] = 1.0
    k_y: Annotated[float, Gain("1/L^2", "gain on the distance aside", search=STIFFNESS, above=0.0)] = 1.0
    k_theta: Annotated[
        float, Gain("1/L", "gain on the heading; 2 sqrt(k_y) damps a line critically", search=DAMPING, above=0.0)
    ] = 2.0
    k_inner: InnerGain = 5.0
    dead_zone_speed: PlaceDeadZoneSpeed = 1e-3


def command(
    gains: Gains, period: float, limits: Limits, follower: Follower, leader: Leader, memory: tuple[()]
) -> tuple[float, float, tuple[()]]:
    """Returns u_x [m/s^2] and u_theta [rad/s^2], which lead to v_c and omega_c with their exact derivatives."""
    k_x, k_y, k_theta = gains.k_x, gains.k_y, gains.k_theta
    v_r, omega_r, u_r, alpha_r = leader.v_x, leader.omega, leader.u_x, leader.u_theta
    e = view(follower, leader)
    steering = k_y * e.y + k_theta * e.sin
    steering_rate = k_y * e.y_rate + k_theta * e.cos * e.theta_rate
    commanded = Velocities(
        v=v_r * e.cos + k_x * e.x,
        omega=omega_r + v_r * steering,
        v_rate=u_r * e.cos - v_r * e.sin * e.theta_rate + k_x * e.x_rate,
        omega_rate=alpha_r + u_r * steering + v_r * steering_rate,
    )
    u_x, u_theta = inner_loop(follower, commanded, gains.k_inner)
    return u_x, u_theta, memory


def beyond(gains: Gains, period: float, leader: LeaderMotion) -> tuple[str, ...]:
    """Returns that small errors are not brought down behind a leader, with the factor."""
    v = leader.v_x
    left = errors_left(period, leader, np.full_like(v, gains.k_x), gains.k_y * v, gains.k_theta * v)
    return not_brought_down(left, period, leader, "it steers by v_0 alone, and the wrong way where v_0 < 0")


def warnings(gains: Gains, limits: Limits) -> tuple[str, ...]:
    """Returns nothing: the source asks for positive gains only."""
    return ()
