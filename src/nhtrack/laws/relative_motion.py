"""Relative motion of a follower and its leader, seen from either of them: what the laws are written in."""

from __future__ import annotations

from math import atan2, cos, hypot, pi, sin
from typing import NamedTuple

from nhtrack import planar
from nhtrack.compiled import compiled
from nhtrack.laws.contract import Follower, Leader


class Relative(NamedTuple):
    """The follower seen from its leader, as the paper writes it.

    Attributes:
        x: r_x, how far ahead of the leader the follower is, in the leader's frame [m].
        y: r_y, how far to the left [m].
        theta: theta_01, heading within pi + hysteresis [rad].
        cos: cos theta_01.
        sin: sin theta_01.
        q_x: exponential coordinate of the pose [m].
        q_y: the other [m].
        v_x: forward part of the relative twist xi_1 - Ad_{g^-1} xi_0 in the follower's frame (paper eq. 15) [m/s].
        v_y: its lateral part [m/s].
        omega: omega_01 [rad/s].
        carried_x: leader's velocity at the follower's place, in the leader's frame, v_0 - omega_0 r_y [m/s]: the
            velocity that a point fixed in the leader's frame has.
        carried_y: v_y0 + omega_0 r_x [m/s].
        turns: winding number taken off the relative heading; the memory of the next call.
    """

    x: float
    y: float
    theta: float
    cos: float
    sin: float
    q_x: float
    q_y: float
    v_x: float
    v_y: float
    omega: float
    carried_x: float
    carried_y: float
    turns: int


@compiled
def relative_motion(follower: Follower, leader: Leader, turns: int, hysteresis: float) -> Relative:
    """Returns the follower's motion relative to its leader.

    Args:
        follower: the follower.
        leader: what it tracks; a lateral velocity v_y0 is allowed.
        turns: winding number of the last call; `relative_turns` at the start.
        hysteresis: of the winding number [rad], see `planar.winding_number_after`.
    """
    x, y, heading = planar.between((leader.x, leader.y, leader.theta), (follower.x, follower.y, follower.theta))
    turn = planar.winding_number_after(heading, float(turns), hysteresis)
    theta = heading - 2 * pi * turn
    q_x, q_y, _ = planar.log((x, y, theta))
    c, s = cos(theta), sin(theta)
    carried_x, carried_y = leader.v_x - leader.omega * y, leader.v_y + leader.omega * x
    return Relative(
        x, y, theta, c, s, q_x, q_y,
        follower.v_x - (c * carried_x + s * carried_y),
        follower.v_y - (c * carried_y - s * carried_x),
        follower.omega - leader.omega,
        carried_x, carried_y, int(turn),
    )  # fmt: skip


@compiled
def relative_turns(follower: Follower, leader: Leader) -> int:
    """Returns the winding number of the relative heading to begin with; pi and -pi keep their signs."""
    return int(planar.winding_number(follower.theta - leader.theta))


@compiled
def arctan_ratio(y: float, x: float, dead_zone: float) -> float:
    """Returns arctan(y/x) in [-pi/2, pi/2], +-pi/2 where x = 0, and 0 where |(x, y)| <= dead_zone.

    The paper's two angles are such quotients, and both become 0/0 where tracking should end: there the direction of
    (x, y) is noise. It jumps by pi where x changes sign, as the paper's does.
    """
    if not hypot(x, y) > dead_zone:
        return 0.0
    return atan2(-y if x < 0.0 else y, abs(x))


@compiled
def side_angle(relative: Relative, dead_zone: float) -> float:
    """Returns beta = -arctan(q_y/q_x), the angle of q in the body frame (Lemma 1)."""
    return -arctan_ratio(relative.q_y, relative.q_x, dead_zone)


@compiled
def adjoint_attitude(relative: Relative, dead_zone: float) -> float:
    """Returns theta~01 = arctan(omega_0 r_x / (v_0 - omega_0 r_y)) (paper eq. 17).

    The relative heading for which the relative velocity has no lateral part. With lateral leader velocity the
    numerator is v_y0 + omega_0 r_x.
    """
    return arctan_ratio(relative.carried_y, relative.carried_x, dead_zone)


class View(NamedTuple):
    """The leader seen from its follower, as the rivals' sources write it.

    The tracking error e = (e_x, e_y, e_theta) is the leader's pose in the follower's frame, with

        e_x' = omega e_y - v + V_x,   e_y' = -omega e_x + V_y,   e_theta' = omega_r - omega,

    (v, omega) the follower's velocities, omega_r the leader's turning rate and V = R(e_theta) (v_r, v_yr) the leader's
    velocity in the follower's frame.

    Attributes:
        x: e_x, how far ahead the leader is [m].
        y: e_y, how far to the left [m].
        theta: e_theta = theta_r - theta, unwrapped [rad].
        cos: cos e_theta.
        sin: sin e_theta.
        x_rate: e_x' [m/s].
        y_rate: e_y' [m/s].
        theta_rate: e_theta' [rad/s].
    """

    x: float
    y: float
    theta: float
    cos: float
    sin: float
    x_rate: float
    y_rate: float
    theta_rate: float


@compiled
def view(follower: Follower, leader: Leader) -> View:
    """Returns the leader seen from its follower; a lateral velocity v_yr of the leader enters the rates."""
    x, y, theta = planar.between((follower.x, follower.y, follower.theta), (leader.x, leader.y, leader.theta))
    c, s, omega = cos(theta), sin(theta), follower.omega
    forward, aside = c * leader.v_x - s * leader.v_y, s * leader.v_x + c * leader.v_y
    return View(
        x, y, theta, c, s, forward - follower.v_x + omega * y, aside - omega * x, leader.omega - omega
    )  # fmt: skip


@compiled
def turned(e: View, x: float, y: float) -> tuple[float, float]:
    """Returns a vector of the leader's frame in the follower's."""
    return e.cos * x - e.sin * y, e.sin * x + e.cos * y


@compiled
def leader_derivatives(e: View, leader: Leader) -> tuple[tuple[float, float], tuple[float, float]]:
    """Returns p_r'' and p_r''' in the follower's frame, the latter for accelerations that are held."""
    v, aside, omega = leader.v_x, leader.v_y, leader.omega
    x, y = leader.u_x - omega * aside, leader.u_y + omega * v
    jerk_x = -leader.u_theta * aside - omega * leader.u_y - omega * y
    jerk_y = leader.u_theta * v + omega * leader.u_x + omega * x
    return turned(e, x, y), turned(e, jerk_x, jerk_y)


@compiled
def direction_rates(
    vector: tuple[float, float], rate: tuple[float, float], second: tuple[float, float], shortest: float
) -> tuple[float, float]:
    """Returns the first and second derivative of a vector's direction [rad/s, rad/s^2].

    With a x b = a_x b_y - a_y b_x: `w x w'/|w|^2` and `w x w''/|w|^2 - 2 (w x w') (w . w')/|w|^4`; both are 0 where |w|
    is at most `shortest`, where the direction is noise.

    Args:
        vector: w.
        rate: w'.
        second: w''.
        shortest: in the unit of w.
    """
    square = vector[0] * vector[0] + vector[1] * vector[1]
    if not square > shortest * shortest:
        return 0.0, 0.0
    turn = (vector[0] * rate[1] - vector[1] * rate[0]) / square
    growth = (vector[0] * rate[0] + vector[1] * rate[1]) / square
    return turn, (vector[0] * second[1] - vector[1] * second[0]) / square - 2 * turn * growth


@compiled
def unturned(e: View, turns: int, hysteresis: float) -> tuple[float, int]:
    """Returns e_theta less whole turns [rad], and their number; see `planar.winding_number_after`.

    Args:
        e: the leader seen from its follower.
        turns: their number in the last call; `view_turns` at the start.
        hysteresis: how far past pi e_theta goes before a turn is dropped [rad].
    """
    now = planar.winding_number_after(e.theta, float(turns), hysteresis)
    return e.theta - 2 * pi * now, int(now)


@compiled
def theta_to_come(e: View, inner: float) -> float:
    """Returns what e_theta will be once velocities have caught up at the rate `inner` [1/s], as far as they are off."""
    return e.theta + e.theta_rate / inner


@compiled
def view_turns(follower: Follower, leader: Leader) -> int:
    """Returns the winding number of e_theta to begin with; pi and -pi keep their signs."""
    return int(planar.winding_number(leader.theta - follower.theta))
