"""Pursuit of a leader from afar: the velocity that leads to it, the gear, and how far the heading is off.

The world frame does not turn with a leader that spins, as the leader's own frame does.
"""

from __future__ import annotations

from math import atan2, cos, hypot, pi, sin, sqrt

from nhtrack import planar
from nhtrack.compiled import compiled
from nhtrack.laws.contract import Follower, Leader
from nhtrack.laws.leader_motion import Seen, world_velocity

GEAR_SWITCH = cos(0.6 * pi)  # heading off w beyond which the gear is changed; then 0.4 pi are left
CLEAR = 2.0  # a field outweighs a leader's velocity for good once it is so many times as large
HYSTERESIS = 0.25  # [rad] how far past pi a heading error goes before a whole turn is dropped


@compiled
def velocity(
    c: float, field_speed: float, smoothing: float, follower: Follower, leader: Leader, seen: Seen
) -> tuple[float, float, float, float]:
    """Returns the velocity w that leads to a leader from far away [m/s], and w' [m/s^2], in the world frame.

        w = Vbar - c r/sqrt(1 + (c |r|/field_speed)^2),   Vbar' = (V - Vbar)/smoothing

    r is the follower's place less the leader's.
    """
    V_x, V_y = world_velocity(leader)
    r_x, r_y = follower.x - leader.x, follower.y - leader.y
    r_x_rate = follower.v_x * cos(follower.theta) - V_x
    r_y_rate = follower.v_x * sin(follower.theta) - V_y
    pull = (c / field_speed) ** 2
    q = sqrt(1 + pull * (r_x * r_x + r_y * r_y))
    q_rate = pull * (r_x * r_x_rate + r_y * r_y_rate) / q
    c = c / q
    w_x_rate = (V_x - seen.velocity_x) / smoothing - c * (r_x_rate - r_x * q_rate / q)
    w_y_rate = (V_y - seen.velocity_y) / smoothing - c * (r_y_rate - r_y * q_rate / q)
    return seen.velocity_x - c * r_x, seen.velocity_y - c * r_y, w_x_rate, w_y_rate


@compiled
def first_gear(follower: Follower, leader: Leader) -> int:
    """Returns 1 where the leader is ahead, -1 where it is behind."""
    ahead = (leader.x - follower.x) * cos(follower.theta) + (leader.y - follower.y) * sin(follower.theta)
    return -1 if ahead < 0.0 else 1


@compiled
def gear_after(gear: int, follower: Follower, leader: Leader, seen: Seen, w_x: float, w_y: float) -> int:
    """Returns the gear of this period: 1 where the follower drives forward along w, -1 in reverse.

    It brings the leader's heading where the leader's velocity outweighs the field, and asks for the smaller turn where
    the field clearly outweighs that velocity; between the two it is kept, so that it does not change to and fro.

    Args:
        gear: of the period before.
        follower: as it is now.
        leader: likewise.
        seen: its motion.
        w_x: velocity that leads to it, in the world frame [m/s].
        w_y: the same.
    """
    own, field = hypot(seen.velocity_x, seen.velocity_y), hypot(w_x - seen.velocity_x, w_y - seen.velocity_y)
    heading = leader.theta if own > field else follower.theta
    if own <= field <= CLEAR * own:
        return gear
    along = gear * (w_x * cos(heading) + w_y * sin(heading))
    return -gear if along < GEAR_SWITCH * hypot(w_x, w_y) else gear


@compiled
def off_course(follower: Follower, gear: int, w_x: float, w_y: float, before: float) -> float:
    """Returns how far the heading is off that of gear w [rad]: the value nearest to that of the period before.

    One farther than pi + `HYSTERESIS` loses its whole turns.
    """
    off = follower.theta - atan2(gear * w_y, gear * w_x)
    off += 2 * pi * round((before - off) / (2 * pi))
    if abs(off) > pi + HYSTERESIS:
        off -= 2 * pi * planar.winding_number(off)
    return off
