"""Parking by backstepping in polar coordinates, after Todorovski, Kim and Krstic (2025): for a leader at rest.

Todorovski, Kim and Krstic, "Modular design of strict control Lyapunov functions for global stabilization of the
unicycle in polar coordinates", arXiv 2509.25575, 2025. rho is the distance to the leader, gamma the leader's
bearing and delta the same bearing in the leader's frame. The modules of the source: speed that takes rho out of the
angles' equations,

    v_c = k_rho rho cos gamma,   delta' = (k_rho/2) sin 2 gamma,   gamma' = delta' - omega,

and steering by backstepping. Its formulas could not be had; those here were derived anew from that description.
With gamma_d = -arctan(2 k_delta delta)/2, z = gamma - gamma_d, q = 1 + (2 k_delta delta)^2, D = (k_rho/2) sin 2
gamma and P = cos(gamma + gamma_d) sinc(z),

    omega_c = (1 + k_delta/q) D + k_gamma z + k_rho P delta,

lifted to accelerations by `inner_loop`. V = (delta^2 + z^2)/2 is strict: `V' = -k_rho k_delta delta^2/sqrt(q) -
k_gamma z^2`; then gamma vanishes, and rho falls as e^(-k_rho t).

At rho = 0 there is no bearing. Within `dock_radius` the follower turns to its leader's heading instead, `omega_c =
k_gamma e_theta`, and v_c = k_rho e_x takes it no further away: dock_radius bounds what is left of the position.
delta and gamma are followed through whole turns, and drop one with hysteresis.

Assumes: a leader at rest, its motion is not looked at; velocities that the robot takes at once (here after the
inner loop has settled). Claims: global asymptotic stability in polar coordinates, for a leader at rest only. One
that drives on a line is followed v_r/k_rho + v_r/k_inner behind it.
Checked: tests/laws/test_further_baselines.py (`test_parking_...`).
"""

from __future__ import annotations

from math import atan, atan2, cos, pi, sin, sqrt
from typing import Annotated, NamedTuple

from nhtrack import planar
from nhtrack.compiled import compiled
from nhtrack.laws.contract import Follower, Gain, Leader, LeaderMotion, Limits
from nhtrack.laws.gains import DAMPING, Hysteresis, InnerGain, PlaceDeadZoneSpeed
from nhtrack.laws.inner_loop import Velocities, inner_loop
from nhtrack.laws.leader_bounds import moves
from nhtrack.laws.relative_motion import View, view


class Gains(NamedTuple):
    """Gains of parking in polar coordinates; the defaults suit starts 10 m away."""

    k_rho: Annotated[float, Gain("1/T", "rate at which the distance falls", search=DAMPING, above=0.0)] = 0.5
    k_delta: Annotated[
        float, Gain("1", "how much the leader's direction steers its bearing", search=(0.2, 10.0), above=0.0)
    ] = 2.0
    k_gamma: Annotated[float, Gain("1/T", "gain on the bearing's error", search=DAMPING, above=0.0)] = 2.0
    k_inner: InnerGain = 5.0
    dock_radius: Annotated[
        float, Gain("L", "distance within which only the heading is turned: the accuracy", above=0.0)
    ] = 0.005
    hysteresis: Hysteresis = 0.25
    dead_zone_speed: PlaceDeadZoneSpeed = 1e-3


class Memory(NamedTuple):
    """Memory of the law.

    Attributes:
        delta: of the last period, unwrapped [rad].
        turns: winding number of gamma, and of e_theta within the docking radius.
    """

    delta: float
    turns: int


def init(gains: Gains, period: float, follower: Follower, leader: Leader) -> Memory:
    """Returns the direction of the leader and the winding number of its bearing."""
    e = view(follower, _resting(leader))
    delta = _direction(e) if sqrt(e.x * e.x + e.y * e.y) > gains.dock_radius else 0.0
    return Memory(delta, int(planar.winding_number(delta + e.theta)))


def command(
    gains: Gains, period: float, limits: Limits, follower: Follower, leader: Leader, memory: Memory
) -> tuple[float, float, Memory]:
    """Returns u_x [m/s^2] and u_theta [rad/s^2], which lead to v_c and omega_c with their exact derivatives."""
    e = view(follower, _resting(leader))
    square = e.x * e.x + e.y * e.y
    docked = sqrt(square) <= gains.dock_radius
    delta = 0.0
    if not docked:
        delta = memory.delta + planar.wrap(_direction(e) - memory.delta)
        delta -= 2 * pi * planar.winding_number_after(delta, 0.0, gains.hysteresis)
    turns = planar.winding_number_after(delta + e.theta, float(memory.turns), gains.hysteresis)
    gamma = delta + e.theta - 2 * pi * turns
    if docked:
        omega, omega_rate = gains.k_gamma * gamma, gains.k_gamma * e.theta_rate
    else:
        delta_rate = follower.v_x * e.y / square
        omega, omega_rate = _steering(gains, delta, gamma, delta_rate, delta_rate - follower.omega)
    commanded = Velocities(gains.k_rho * e.x, omega, gains.k_rho * e.x_rate, omega_rate)
    u_x, u_theta = inner_loop(follower, commanded, gains.k_inner)
    return u_x, u_theta, Memory(delta, int(turns))


@compiled
def _resting(leader: Leader) -> Leader:
    """Returns the leader as if it did not move."""
    return Leader(leader.x, leader.y, leader.theta, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@compiled
def _direction(e: View) -> float:
    """Returns the direction from the follower to the leader, in the leader's frame [rad]."""
    return atan2(e.cos * e.y - e.sin * e.x, e.cos * e.x + e.sin * e.y)


@compiled
def _steering(gains: Gains, delta: float, gamma: float, delta_rate: float, gamma_rate: float) -> tuple[float, float]:
    """Returns omega_c and its derivative."""
    k_rho, k_delta = gains.k_rho, gains.k_delta
    root = 1 + (2 * k_delta * delta) ** 2  # q
    root_rate = 8 * k_delta**2 * delta * delta_rate
    aim, aim_rate = -atan(2 * k_delta * delta) / 2, -k_delta * delta_rate / root  # gamma_d
    z, z_rate = gamma - aim, gamma_rate - aim_rate
    drift, drift_rate = k_rho / 2 * sin(2 * gamma), k_rho * cos(2 * gamma) * gamma_rate  # D
    ratio, slope = planar.sinc_and_slope(z)
    both = gamma + aim
    part = cos(both) * ratio  # P
    part_rate = cos(both) * slope * z_rate - sin(both) * (gamma_rate + aim_rate) * ratio
    omega = (1 + k_delta / root) * drift + gains.k_gamma * z + k_rho * part * delta
    omega_rate = (
        (1 + k_delta / root) * drift_rate
        - k_delta * drift * root_rate / root**2
        + gains.k_gamma * z_rate
        + k_rho * (part_rate * delta + part * delta_rate)
    )
    return omega, omega_rate


def beyond(gains: Gains, period: float, leader: LeaderMotion) -> tuple[str, ...]:
    """Returns that the leader moves."""
    return moves(period, leader)


def warnings(gains: Gains, limits: Limits) -> tuple[str, ...]:
    """Returns nothing: the proof asks for positive gains only."""
    return ()
