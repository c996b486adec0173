"""The pose stabiliser of the paper (Lemma 1): brings a follower to a leader at rest.

    u_theta = -kp (theta + k beta) - kd omega,   u_x = -kp q_x - kd v

with (q_x, q_y, theta) the exponential coordinates of the follower seen from the leader, beta = -arctan(q_y/q_x), and
the follower's own velocities.

Assumes: a leader at rest (its motion is not looked at); states measured without error. Claims: convergence to the
leader's pose from any start; needs k > 2 and kd >= 2 sqrt(kp), which the paper does not say
(tests/laws/test_claims.py).
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from nhtrack.laws.contract import Follower, Gain, Leader, LeaderMotion, Limits
from nhtrack.laws.gains import DAMPING, STEERING, STIFFNESS, DeadZoneLength, DeadZoneSpeed, Hysteresis
from nhtrack.laws.leader_bounds import moves
from nhtrack.laws.published import gain_warnings
from nhtrack.laws.relative_motion import relative_motion, relative_turns, side_angle


class Gains(NamedTuple):
    """Gains of Lemma 1."""

    kp: Annotated[float, Gain("1/T^2", "position gain", search=STIFFNESS, above=0.0)]
    kd: Annotated[float, Gain("1/T", "damping gain; advised kd >= 2 sqrt(kp)", search=DAMPING, least=0.0)]
    k: Annotated[float, Gain("1", "steering gain on beta; advised k > 2", search=STEERING)]
    hysteresis: Hysteresis = 0.25
    dead_zone_length: DeadZoneLength = 1e-6
    dead_zone_speed: DeadZoneSpeed = 1e-3


class Memory(NamedTuple):
    """Memory of the law.

    Attributes:
        turns: winding number of the relative heading.
    """

    turns: int


def init(gains: Gains, period: float, follower: Follower, leader: Leader) -> Memory:
    """Returns the winding number of the relative heading; pi and -pi keep their signs."""
    return Memory(relative_turns(follower, leader))


def command(
    gains: Gains, period: float, limits: Limits, follower: Follower, leader: Leader, memory: Memory
) -> tuple[float, float, Memory]:
    """Returns u_x [m/s^2] and u_theta [rad/s^2] of Lemma 1, and the winding number."""
    kp, kd, k = gains.kp, gains.kd, gains.k
    relative = relative_motion(follower, leader, memory.turns, gains.hysteresis)
    beta = side_angle(relative, gains.dead_zone_length)
    u_theta = -kp * (relative.theta + k * beta) - kd * follower.omega
    u_x = -kp * relative.q_x - kd * follower.v_x
    return u_x, u_theta, Memory(relative.turns)


def beyond(gains: Gains, period: float, leader: LeaderMotion) -> tuple[str, ...]:
    """Returns that the leader moves."""
    return moves(period, leader)


def warnings(gains: Gains, limits: Limits) -> tuple[str, ...]:
    """Returns what the gains break, with the formula."""
    return gain_warnings(gains.kp, gains.kd, 0.0, gains.k)
