"""The law of Panteley, Lefeber, Loria and Nijmeijer (1998): linear, for a leader that keeps turning.

Panteley, Lefeber, Loria and Nijmeijer, "Exponential tracking control of a mobile car using a cascaded approach",
IFAC Workshop on Motion Control, Grenoble 1998, for their kinematic model:

    v_c = v_r + c_2 e_x,   omega_c = omega_r + c_1 e_theta

lifted to accelerations by `inner_loop`. e_theta falls by itself, and what is left is the linear system `e_x' = -c_2
e_x + omega_r e_y`, `e_y' = -omega_r e_x`, which e_theta only disturbs. Whole turns are taken off e_theta, counted
in the memory with hysteresis; the source has it in all real numbers.

Assumes: velocities that the robot takes at once (here after the inner loop has settled); v_r and omega_r bounded.
Needs: omega_r persistently exciting, that is, never without turning for long; v_r may vanish. Claims: global
K-exponential stability then (exponential, with a bound that grows with the start). On a line omega_r = 0 and e_y
stays.
Checked: tests/laws/test_further_baselines.py (`test_panteley_...`).
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from nhtrack.laws.contract import Follower, Gain, Leader, LeaderMotion, Limits
from nhtrack.laws.gains import DAMPING, Hysteresis, InnerGain, PlaceDeadZoneSpeed
from nhtrack.laws.inner_loop import Velocities, inner_loop
from nhtrack.laws.leader_bounds import errors_left, not_brought_down
from nhtrack.laws.relative_motion import unturned, view, view_turns


class Gains(NamedTuple):
    """Gains of the cascaded law, c_2 being k_x and c_1 k_theta.

    The defaults suit leaders of about 1 m/s and starts 10 m away.
    """

    k_x: Annotated[
        float, Gain("1/T", "gain on the distance ahead; 2 |omega_r| damps critically", search=DAMPING, above=0.0)
    ] = 1.0
    k_theta: Annotated[float, Gain("1/T", "gain on the heading", search=DAMPING, above=0.0)] = 1.0
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
    e = view(follower, leader)
    e_theta, turns = unturned(e, memory.turns, gains.hysteresis)
    commanded = Velocities(
        v=leader.v_x + gains.k_x * e.x,
        omega=leader.omega + gains.k_theta * e_theta,
        v_rate=leader.u_x + gains.k_x * e.x_rate,
        omega_rate=leader.u_theta + gains.k_theta * e.theta_rate,
    )
    u_x, u_theta = inner_loop(follower, commanded, gains.k_inner)
    return u_x, u_theta, Memory(turns)


def beyond(gains: Gains, period: float, leader: LeaderMotion) -> tuple[str, ...]:
    """Returns that small errors are not brought down behind a leader, with the factor."""
    every = np.ones_like(leader.v_x)
    left = errors_left(period, leader, gains.k_x * every, 0 * every, gains.k_theta * every)
    return not_brought_down(left, period, leader, "errors across the leader's heading fall while it turns alone")


def warnings(gains: Gains, limits: Limits) -> tuple[str, ...]:
    """Returns nothing: the source asks for positive gains only."""
    return ()
