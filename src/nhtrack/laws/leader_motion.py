"""What a law has seen of its leader's motion, kept from one control period to the next, and what it makes of that."""

from __future__ import annotations

from math import atan2, cos, exp, hypot, sin, sqrt
from typing import NamedTuple, TypeAlias

from nhtrack import planar
from nhtrack.compiled import compiled
from nhtrack.laws.contract import Follower, Leader

HOLD = 4.0  # peaks of means fade so many times slower than the means
SLOWEST, FASTEST = 0.25, 4.0  # bounds of the natural frequency behind k_x [rate]

SeenRow: TypeAlias = tuple[
    float, float, float, float, float, float, float, float, float, float, float, float, float, float
]


class Seen(NamedTuple):
    """A leader's motion as it was seen; means fade with the time constant `window`.

    Attributes:
        speed_2: v_0^2 [m^2/s^2], peaks of it held and fading.
        turning_2: omega_0^2 [rad^2/s^2], likewise.
        psi: what a heading error of gain k_theta makes of v_0: psi' = v_0 - k_theta psi [m].
        reach_2: L^2, mean of psi^2 [m^2].
        held_2: H, peaks of L^2, which fade more slowly [m^2].
        axis_x: mean of cos 2 theta_0.
        axis_y: mean of sin 2 theta_0.
        weight_x: mean of psi^2 cos 2 theta_0 [m^2].
        weight_y: mean of psi^2 sin 2 theta_0 [m^2].
        speed: v_0 smoothed [m/s].
        turning: omega_0 smoothed [rad/s].
        heading: theta_0 smoothed, unwrapped [rad].
        velocity_x: velocity in the world, smoothed [m/s].
        velocity_y: the same [m/s].
    """

    speed_2: float
    turning_2: float
    psi: float
    reach_2: float
    held_2: float
    axis_x: float
    axis_y: float
    weight_x: float
    weight_y: float
    speed: float
    turning: float
    heading: float
    velocity_x: float
    velocity_y: float


@compiled
def world_velocity(leader: Leader) -> tuple[float, float]:
    """Returns the leader's velocity in the world frame [m/s]."""
    c, s = cos(leader.theta), sin(leader.theta)
    return leader.v_x * c - leader.v_y * s, leader.v_x * s + leader.v_y * c


@compiled
def world_acceleration(leader: Leader) -> tuple[float, float]:
    """Returns the leader's acceleration in the world frame [m/s^2]."""
    c, s = cos(leader.theta), sin(leader.theta)
    ahead, aside = leader.u_x - leader.omega * leader.v_y, leader.u_y + leader.omega * leader.v_x
    return ahead * c - aside * s, ahead * s + aside * c


@compiled
def first_seen(leader: Leader, k_theta: float, window: float, smoothing: float) -> SeenRow:
    """Returns what would have been seen of a leader that has always driven and turned as it does now.

    The mean of e^(i omega t) over the past, fading with the time constant T, is e^(i omega t)/(1 + i omega T).
    """
    v, omega, heading = leader.v_x, leader.omega, leader.theta
    psi = v / k_theta
    square = psi * psi
    axis_x, axis_y = _lagging(cos(2 * heading), sin(2 * heading), 2 * omega * window)
    V_x, V_y = world_velocity(leader)
    Vbar_x, Vbar_y = _lagging(V_x, V_y, omega * smoothing)
    return (
        v * v, omega * omega, psi, square, square, axis_x, axis_y, square * axis_x, square * axis_y,
        v, omega, heading, Vbar_x, Vbar_y,
    )  # fmt: skip


@compiled
def _lagging(x: float, y: float, lag: float) -> tuple[float, float]:
    """Returns (x + i y)/(1 + i lag)."""
    size = 1 + lag * lag
    return (x + lag * y) / size, (y - lag * x) / size


@compiled
def seen_after(row: SeenRow, leader: Leader, period: float, k_theta: float, window: float, smoothing: float) -> SeenRow:
    """Returns what has been seen with another period.

    Args:
        row: what had been seen before.
        leader: as it is now.
        period: control period [s].
        k_theta: see `Seen.psi` [1/s].
        window: time constant of means and peaks [s].
        smoothing: of what is smoothed [s].
    """
    m = Seen(*row)
    v, omega, heading = leader.v_x, leader.omega, leader.theta
    c, s = cos(2 * heading), sin(2 * heading)
    new, fade, smooth = 1 - exp(-period / window), exp(-2 * period / window), 1 - exp(-period / smoothing)
    psi = m.psi + (1 - exp(-k_theta * period)) * (v / k_theta - m.psi)
    square = psi * psi
    reach_2 = m.reach_2 + new * (square - m.reach_2)
    ahead = m.heading + period * m.turning
    V_x, V_y = world_velocity(leader)
    return (
        max(m.speed_2 * fade, v * v),
        max(m.turning_2 * fade, omega * omega),
        psi,
        reach_2,
        max(m.held_2 * exp(-period / (HOLD * window)), reach_2),
        m.axis_x + new * (c - m.axis_x),
        m.axis_y + new * (s - m.axis_y),
        m.weight_x + new * (square * c - m.weight_x),
        m.weight_y + new * (square * s - m.weight_y),
        m.speed + smooth * (v - m.speed),
        m.turning + smooth * (omega - m.turning),
        ahead + smooth * (heading - ahead),
        m.velocity_x + smooth * (V_x - m.velocity_x),
        m.velocity_y + smooth * (V_y - m.velocity_y),
    )


class Schedule(NamedTuple):
    """Gains for a leader that moves as it has been seen to.

    Attributes:
        b: weight of place against heading [1/m^2].
        k_x: gain on the distance ahead [1/s].
        contraction: lambda, the mean rate at which small place errors shrink with them [1/s].
    """

    b: float
    k_x: float
    contraction: float


@compiled
def schedule(seen: Seen, rate: float, k_theta: float, k_inner: float, zeta: float, least_speed: float) -> Schedule:
    """Returns the gains for a leader's motion.

        b = min(k_inner^2/(E_v + least_speed^2), rate/(k_theta H))
        k_x = 2 zeta clip(sqrt(E_w + (b k_theta L^2)^2), rate/4, 4 rate)
        lambda = (k_x + b k_theta L^2 - |k_x z_e - b k_theta z_m|)/2

    lambda is the least eigenvalue of k_x <e e^T> + b k_theta <psi^2 n n^T>: errors along the leader's heading e shrink
    at k_x, those across it, along n, by steering (docs/theory.md).
    """
    b = k_inner**2 / (seen.speed_2 + least_speed**2)
    if b * k_theta * seen.held_2 > rate:
        b = rate / (k_theta * seen.held_2)
    steering = b * k_theta
    aside = steering * seen.reach_2
    wanted = sqrt(seen.turning_2 + aside * aside)
    k_x = 2 * zeta * planar.clip(wanted, SLOWEST * rate, FASTEST * rate)
    uneven = hypot(k_x * seen.axis_x - steering * seen.weight_x, k_x * seen.axis_y - steering * seen.weight_y)
    return Schedule(b, k_x, (k_x + aside - uneven) / 2)


@compiled
def behind_smoothed(follower: Follower, leader: Leader, seen: Seen, smoothing: float) -> tuple[Follower, Leader, float]:
    """Returns a follower less what it carries, its smoothed leader, and the acceleration of what it carries [m/s^2].

    It carries what the smoothed leader leaves out of the leader's velocity, as far as that is along its heading.
    """
    T, v, heading = smoothing, seen.speed, seen.heading
    omega = seen.turning + (leader.theta - heading) / T
    v_rate, omega_rate = (leader.v_x - v) / T, (2 * leader.omega - seen.turning - omega) / T
    smooth = Leader(leader.x, leader.y, heading, v, 0.0, omega, v_rate, 0.0, omega_rate)
    V_x, V_y = world_velocity(leader)
    A_x, A_y = world_acceleration(leader)
    Vbar_x, Vbar_y = world_velocity(smooth)
    Abar_x, Abar_y = world_acceleration(smooth)
    left_x, left_y = V_x - Vbar_x, V_y - Vbar_y
    c, s = cos(follower.theta), sin(follower.theta)
    carried = left_x * c + left_y * s
    carried_rate = (A_x - Abar_x) * c + (A_y - Abar_y) * s + follower.omega * (left_y * c - left_x * s)
    rest = Follower(follower.x, follower.y, follower.theta, follower.v_x - carried, follower.v_y, follower.omega)
    return rest, smooth, carried_rate


@compiled
def slip_angle(leader: Leader, least_speed: float) -> tuple[float, float]:
    """Returns the angle of a leader's velocity off its heading [rad], and its rate; zero unless it moves sideways.

    angle = atan(v_0 v_y0/(v_0^2 + least_speed^2)): a leader that reverses is not to be turned round.
    """
    across, along = leader.v_x * leader.v_y, leader.v_x * leader.v_x + least_speed**2
    across_rate, along_rate = leader.u_x * leader.v_y + leader.v_x * leader.u_y, 2 * leader.v_x * leader.u_x
    return atan2(across, along), (along * across_rate - across * along_rate) / (along * along + across * across)
