"""Static input-output linearisation of a point ahead of the axle: places the point, leaves the heading.

Tracking by the point a distance d ahead of the axle (Siciliano et al., "Robotics", 2009, section 11.6):

    z = p + d (cos theta, sin theta),   z_r likewise of the leader,   w = z_r' + k (z_r - z)
    v_c = w_x,   omega_c = w_y/d,   w in the follower's frame

lifted to accelerations by `inner_loop`. z can be moved in any direction, so z - z_r decays as e^(-k t) once the inner
loop has settled. The leader may have lateral velocity. Only sine and cosine of the heading enter: no memory.

Assumes: velocities that the robot takes at once (here after the inner loop has settled). Needs: nothing for the
point; v_r > 0 for the heading, which z does not determine: on target `e_theta' = omega_r (1 - cos e_theta)
- (v_r/d) sin e_theta`, so it aligns behind a leader that drives forward, turns away from one in reverse, and stays
where it is with one at rest, which leaves the axle up to 2 d from its place.
Claims: global exponential stability of z - z_r. Checked: tests/laws/test_baselines.py (`test_look_ahead_...`).
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from nhtrack.laws.contract import Follower, Gain, Leader, LeaderMotion, Limits
from nhtrack.laws.gains import DAMPING, InnerGain, PlaceDeadZoneSpeed
from nhtrack.laws.inner_loop import Velocities, inner_loop
from nhtrack.laws.leader_bounds import not_brought_down
from nhtrack.laws.relative_motion import turned, view


class Gains(NamedTuple):
    """Gains of the law of the point ahead, d being the distance.

    The defaults suit leaders of about 1 m/s and starts 10 m away.
    """

    distance: Annotated[
        float, Gain("L", "how far ahead of the axle the point is", search=(1e-3, 0.2), above=0.0)
    ] = 0.5
    k: Annotated[float, Gain("1/T", "gain on the point's distance", search=DAMPING, above=0.0)] = 1.0
    k_inner: InnerGain = 5.0
    dead_zone_speed: PlaceDeadZoneSpeed = 1e-3


def command(
    gains: Gains, period: float, limits: Limits, follower: Follower, leader: Leader, memory: tuple[()]
) -> tuple[float, float, tuple[()]]:
    """Returns u_x [m/s^2] and u_theta [rad/s^2]; vectors are in the follower's frame, derivatives exact."""
    d, k = gains.distance, gains.k
    v, omega, v_r, omega_r = follower.v_x, follower.omega, leader.v_x, leader.omega
    e = view(follower, leader)
    aside = leader.v_y + d * omega_r
    z_r_x, z_r_y = turned(e, v_r, aside)  # z_r'
    jolt_x, jolt_y = turned(e, leader.u_x - omega_r * aside, leader.u_y + d * leader.u_theta + omega_r * v_r)  # z_r''
    w_x = z_r_x + k * (e.x + d * e.cos - d)
    w_y = z_r_y + k * (e.y + d * e.sin)
    w_x_rate = jolt_x + k * (z_r_x - v)
    w_y_rate = jolt_y + k * (z_r_y - d * omega)
    # The components of w change with the world's w and with the turning of the frame they are in.
    commanded = Velocities(w_x, w_y / d, w_x_rate + omega * w_y, (w_y_rate - omega * w_x) / d)
    u_x, u_theta = inner_loop(follower, commanded, gains.k_inner)
    return u_x, u_theta, memory


def beyond(gains: Gains, period: float, leader: LeaderMotion) -> tuple[str, ...]:
    """Returns that small errors of heading are not brought down behind a leader, with the factor."""
    left = float(np.exp(np.clip(-period * np.sum(leader.v_x) / gains.distance, -500.0, 500.0)))
    reason = "headings align by exp(-s/distance), s the way that the leader drives ahead less that in reverse"
    return not_brought_down(left, period, leader, reason)


def warnings(gains: Gains, limits: Limits) -> tuple[str, ...]:
    """Returns nothing: positive gains are all that is needed."""
    return ()
