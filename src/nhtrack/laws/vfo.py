"""Vector field orientation (Michalek and Kozlowski 2010): tracking of a leader that drives, and parking at one at rest.

Michalek and Kozlowski, "Vector-field-orientation feedback control method for a differentially driven vehicle", IEEE
Trans. Control Systems Technology 18, 2010, which has both tasks. With p the follower's place, e = p_r - p and g_r
the direction of the leader's heading, the convergence field and its direction are

    h = k_p e + p_r',                  sigma = sign v_r                        while |v_r| > least_speed,
    h = k_p e + p_r' - eta sigma |e| g_r   (0 < eta < k_p), sigma as it was    at rest,
    theta_a = angle(sigma h)

and the follower is pushed along its own axis and oriented along the field,

    v_c = |h| cos(angle of h to the heading),   omega_c = theta_a' + k_a (theta_a - theta)

lifted to accelerations by `inner_loop`. theta_a' takes the leader's acceleration, omega_c' its jerk and the
follower's own acceleration; u_r' is not known and counts as zero, as it is while an input is held. Once the heading
is on the field `e' = -k_p e`; at rest the term with eta turns e into the leader's axis, `phi' = -eta sin phi`, and
`|e|' = -(k_p - eta cos phi) |e|`, phi being the angle of sigma e to g_r.

The source knows beforehand which of the two tasks it is given; the switch by `least_speed` is ours, and so is p_r'
in the second line, zero in the source. At rest sigma is that of the last motion; at the start it is 1 behind the
leader and -1 ahead of it. As in the source theta_a is the leader's heading where h has no direction, here within
`dock_radius` of a leader at rest, whose term with eta is left out there.

Assumes: velocities that the robot takes at once (here after the inner loop has settled). Needs: v_r that stays away
from zero and keeps its sign, or a leader at rest. Claims: asymptotic tracking, asymptotic parking; h = 0 on the way
is left out.
Checked: tests/laws/test_further_baselines.py (`test_vfo_...`).
"""

from __future__ import annotations

from math import atan2, pi, sqrt
from typing import Annotated, NamedTuple

from nhtrack import planar
from nhtrack.compiled import compiled
from nhtrack.laws.contract import Follower, Gain, Leader, LeaderMotion, Limits
from nhtrack.laws.gains import DAMPING, Hysteresis, InnerGain, PlaceDeadZoneSpeed
from nhtrack.laws.inner_loop import Velocities, inner_loop
from nhtrack.laws.leader_bounds import reverses
from nhtrack.laws.relative_motion import View, direction_rates, leader_derivatives, turned, view

Vector = tuple[float, float]

OFTEN = 7.9  # reversals that come sooner, in units of 1/sqrt(k_p k_a), drive a follower off


class Gains(NamedTuple):
    """Gains of vector field orientation; the defaults suit leaders of about 1 m/s and starts 10 m away."""

    k_p: Annotated[float, Gain("1/T", "rate at which places settle", search=DAMPING, above=0.0)] = 1.0
    k_a: Annotated[float, Gain("1/T", "gain on the heading's error", search=DAMPING, above=0.0)] = 2.0
    eta: Annotated[
        float, Gain("1/T", "rate of turning into the axis of a leader at rest; below k_p", search=DAMPING, above=0.0)
    ] = 0.6
    k_inner: InnerGain = 5.0
    least_speed: Annotated[float, Gain("L/T", "leader speed up to which it counts as at rest", above=0.0)] = 0.1
    dock_radius: Annotated[
        float, Gain("L", "distance from a leader at rest within which its heading is taken: the accuracy", above=0.0)
    ] = 0.005
    hysteresis: Hysteresis = 0.25
    dead_zone_speed: PlaceDeadZoneSpeed = 1e-3


class Memory(NamedTuple):
    """Memory of the law.

    Attributes:
        gear: sigma, 1 or -1.
        turns: winding number of theta_a - theta.
    """

    gear: int
    turns: int


class _Field(NamedTuple):
    """The convergence field and its derivatives, in the follower's frame."""

    h: Vector
    rate: Vector
    second: Vector


def init(gains: Gains, period: float, follower: Follower, leader: Leader) -> Memory:
    """Returns the side that the follower is on, and the winding number of the heading's error."""
    e = view(follower, leader)
    gear = _gear(gains, leader, 1 if e.cos * e.x + e.sin * e.y >= 0.0 else -1)
    return Memory(gear, int(planar.winding_number(_heading_error(gains, e, leader, gear))))


def command(
    gains: Gains, period: float, limits: Limits, follower: Follower, leader: Leader, memory: Memory
) -> tuple[float, float, Memory]:
    """Returns u_x [m/s^2] and u_theta [rad/s^2], which lead to v_c and omega_c, and the memory."""
    e = view(follower, leader)
    gear, omega = _gear(gains, leader, memory.gear), follower.omega
    resting = _eta(gains, e, leader) * gear
    h, h_rate = _field(gains, resting, e, follower, leader, 0.0)[:2]
    along, along_rate = h[0], h_rate[0] + omega * h[1]
    u_x, _ = inner_loop(follower, Velocities(along, 0.0, along_rate, 0.0), gains.k_inner)

    error = _heading_error(gains, e, leader, gear)
    turns = planar.winding_number_after(error, float(memory.turns), gains.hysteresis)
    if _docked(gains, e, leader):
        turn, turn_rate = leader.omega, leader.u_theta
    else:
        field = _field(gains, resting, e, follower, leader, u_x)
        turn, turn_rate = direction_rates(field.h, field.rate, field.second, 0.0)
    commanded = Velocities(
        along, turn + gains.k_a * (error - 2 * pi * turns), along_rate, turn_rate + gains.k_a * (turn - omega)
    )
    u_x, u_theta = inner_loop(follower, commanded, gains.k_inner)
    return u_x, u_theta, Memory(gear, int(turns))


@compiled
def _gear(gains: Gains, leader: Leader, gear: int) -> int:
    """Returns sigma of this period; `gear` is that of the last."""
    if abs(leader.v_x) <= gains.least_speed:
        return gear
    return 1 if leader.v_x > 0.0 else -1


@compiled
def _docked(gains: Gains, e: View, leader: Leader) -> bool:
    """Returns whether the leader's heading is taken instead of the field's."""
    return abs(leader.v_x) <= gains.least_speed and sqrt(e.x * e.x + e.y * e.y) <= gains.dock_radius


@compiled
def _eta(gains: Gains, e: View, leader: Leader) -> float:
    """Returns eta where it acts [1/s]."""
    if abs(leader.v_x) > gains.least_speed or _docked(gains, e, leader):
        return 0.0
    return gains.eta


@compiled
def _heading_error(gains: Gains, e: View, leader: Leader, gear: int) -> float:
    """Returns theta_a - theta, unwrapped as the two headings are [rad]."""
    if _docked(gains, e, leader):
        return e.theta
    resting = _eta(gains, e, leader) * gear * sqrt(e.x * e.x + e.y * e.y)
    # in the leader's frame, where theta_a passes pi elsewhere than the error does
    h_x = gains.k_p * (e.cos * e.x + e.sin * e.y) + leader.v_x - resting
    h_y = gains.k_p * (e.cos * e.y - e.sin * e.x) + leader.v_y
    return e.theta + atan2(gear * h_y, gear * h_x)


@compiled
def _field(gains: Gains, resting: float, e: View, follower: Follower, leader: Leader, u_x: float) -> _Field:
    """Returns h, h' and h''; derivatives are those of the world, in the follower's frame.

    Args:
        gains: of the law.
        resting: eta sigma where it acts, else 0.
        e: the leader seen from the follower.
        follower: the follower.
        leader: what it tracks.
        u_x: acceleration of the follower; only h'' has it.
    """
    k_p, v, omega_r = gains.k_p, follower.v_x, leader.omega
    (acceleration, jerk), (g_x, g_y) = leader_derivatives(e, leader), turned(e, 1.0, 0.0)
    speed = turned(e, leader.v_x, leader.v_y)
    e_1 = (speed[0] - v, speed[1])
    e_2 = (acceleration[0] - u_x, acceleration[1] - v * follower.omega)
    n = sqrt(e.x * e.x + e.y * e.y)
    n_1 = n_2 = 0.0
    if n > 0.0:
        n_1 = (e.x * e_1[0] + e.y * e_1[1]) / n
        n_2 = (e_1[0] ** 2 + e_1[1] ** 2 + e.x * e_2[0] + e.y * e_2[1] - n_1**2) / n
    # (n g_r)' and (n g_r)'' along g_r and across
    across, along_2, across_2 = n * omega_r, n_2 - n * omega_r**2, 2 * n_1 * omega_r + n * leader.u_theta
    return _Field(
        (k_p * e.x + speed[0] - resting * n * g_x, k_p * e.y + speed[1] - resting * n * g_y),
        (
            k_p * e_1[0] + acceleration[0] - resting * (n_1 * g_x - across * g_y),
            k_p * e_1[1] + acceleration[1] - resting * (n_1 * g_y + across * g_x),
        ),
        (
            k_p * e_2[0] + jerk[0] - resting * (along_2 * g_x - across_2 * g_y),
            k_p * e_2[1] + jerk[1] - resting * (along_2 * g_y + across_2 * g_x),
        ),
    )


def beyond(gains: Gains, period: float, leader: LeaderMotion) -> tuple[str, ...]:
    """Returns that the leader reverses too often; the bound is measured."""
    sooner = OFTEN / sqrt(gains.k_p * gains.k_a)
    grows = f"{OFTEN:g}/sqrt(k_p k_a): errors grow with each reversal"
    return reverses(period, leader, gains.least_speed, sooner, grows)


def warnings(gains: Gains, limits: Limits) -> tuple[str, ...]:
    """Returns what the gains break of the source's conditions."""
    if gains.eta < gains.k_p:
        return ()
    return (
        f"eta = {gains.eta:g} is not below k_p = {gains.k_p:g}: on the axis of a leader at rest none comes nearer",
    )
