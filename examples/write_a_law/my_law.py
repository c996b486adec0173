"""A law to start from: it leads the robot's velocities to those of Kanayama et al. (1990).

    v_c     = v_r cos e_theta + k_x e_x,   omega_c = omega_r + v_r (k_y e_y + k_theta sin e_theta)
    u_x     = k_inner (v_c - v) + (v_c - its last value)/period          and so u_theta, with omega

e = (e_x, e_y, e_theta): the leader's pose seen from the follower. Lengths are metres, angles radians, times seconds.
It settles near a leader that drives forward; next to one that stands it stops, but does not park.
"""

from math import cos, sin, sqrt
from typing import Annotated, NamedTuple

from nhtrack.laws import Follower, Gain, Leader, Limits, compiled


class Gains(NamedTuple):
    """What scenarios set. `nhtrack tune` looks for gains with `search`, in units of the run's duration and size."""

    k_x: Annotated[float, Gain("1/T", "gain on the distance ahead", search=(6, 1000), above=0.0)] = 1.0
    k_y: Annotated[float, Gain("1/L^2", "gain on the distance aside", search=(9, 4e4), above=0.0)] = 4.0
    k_theta: Annotated[float, Gain("1/L", "gain on the heading", search=(6, 1000), above=0.0)] = 4.0
    k_inner: Annotated[float, Gain("1/T", "how fast velocities follow", search=(6, 1000), above=0.0)] = 5.0


class Memory(NamedTuple):
    """What the law keeps from one control period to the next; leave it out, with `init`, if there is nothing."""

    commanded: tuple[float, float]


@compiled
def velocities(gains: Gains, follower: Follower, leader: Leader) -> tuple[float, float]:
    """Returns v_c [m/s] and omega_c [rad/s]."""
    c, s = cos(follower.theta), sin(follower.theta)
    dx, dy, e_theta = leader.x - follower.x, leader.y - follower.y, leader.theta - follower.theta
    e_x, e_y = c * dx + s * dy, c * dy - s * dx
    v = leader.v_x * cos(e_theta) + gains.k_x * e_x
    return v, leader.omega + leader.v_x * (gains.k_y * e_y + gains.k_theta * sin(e_theta))


def init(gains: Gains, period: float, follower: Follower, leader: Leader) -> Memory:
    """Returns the memory to begin with."""
    return Memory(velocities(gains, follower, leader))


def command(
    gains: Gains, period: float, limits: Limits, follower: Follower, leader: Leader, memory: Memory
) -> tuple[float, float, Memory]:
    """Returns u_x [m/s^2] and u_theta [rad/s^2] of the coming control period, and the memory for the next one."""
    v, omega = velocities(gains, follower, leader)
    last_v, last_omega = memory.commanded
    u_x = gains.k_inner * (v - follower.v_x) + (v - last_v) / period
    u_theta = gains.k_inner * (omega - follower.omega) + (omega - last_omega) / period
    return clipped(u_x, limits.acceleration), clipped(u_theta, limits.yaw_acceleration), Memory((v, omega))


@compiled
def clipped(value: float, most: float) -> float:
    """Returns a value within a limit, which is infinite where a scenario sets none."""
    return min(max(value, -most), most)


def warnings(gains: Gains, limits: Limits) -> tuple[str, ...]:
    """Returns what to warn of before a run, a sentence each. `nhtrack tune` takes no gains that are warned of."""
    bound = 2 * sqrt(gains.k_y)
    if gains.k_theta < bound:
        return (f"k_theta = {gains.k_theta:g} is below 2 sqrt(k_y) = {bound:g}: it swings onto a line",)
    return ()
