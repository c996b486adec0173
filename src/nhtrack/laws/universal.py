"""A hybrid law for slow leaders: at rest, in motion, stopping, reversing with periods of 12 s or more, spinning.

Head along the leader's velocity plus a field that leads in tangentially, and drive at their sum. With r the follower's
place in the leader's frame, rho and phi the polar coordinates of b r, J a quarter turn and s = +-1 the gear,

    F     = -b c rho cos(phi/2) (cos m phi, sin m phi),   sigma = 1/sqrt(1 + (c rho / field_speed)^2)
    w     = (v_0, v_y0) + sigma (omega_0 J r + F),        a = angle(s w)
    u_theta = -k1 (theta_01 - a) - k2 (omega_01 - a') + u_theta0
    u_x     = -k3 (v_1 - v_d) + v_d',                     v_d = <w, (cos theta_01, sin theta_01)>

with the exact derivatives a', clipped to `turn_rate`, and v_d' along the motion. The side b = +-1 (ahead, behind)
changes where |phi| > 0.6 pi; the gear where |a| > 0.6 pi, or > 0.9 pi where the field is larger than the leader's
velocity. Within `dock_radius` of a leader slower than `dock_speed` the follower is docked: a = 0 and
w = (v_0, v_y0) - c r, so that |r| does not grow while the heading settles; docking ends at twice either.

With limits, velocities and accelerations stay within them once they are (k2 and k3 times the control period must
be below 1); then the brake of the heading follows sqrt(alpha (|e| - e_0/2)) instead of a straight line.

Sources: adjoint velocity of the paper (Lemma 4); vector-field orientation, M. Michalek and K. Kozlowski, IEEE
Transactions on Control Systems Technology 18(1), 2010. Assumes: states measured without error, the leader's
acceleration known. Claims: the follower ends within the docking radius of its leader, and on it where the leader
keeps moving (tests/laws/test_universal.py). What is proved and what is measured: docs/theory.md.
"""

from __future__ import annotations

from math import atan2, cos, pi, sin, sqrt
from typing import Annotated, NamedTuple

from nhtrack import planar
from nhtrack.compiled import compiled
from nhtrack.laws.contract import Follower, Gain, Leader, LeaderMotion, Limits
from nhtrack.laws.gains import DAMPING, PlaceDeadZoneSpeed
from nhtrack.laws.leader_bounds import reverses, turns
from nhtrack.laws.limited import field_warnings, return_rate, within

SIDE_SWITCH = cos(0.6 * pi)  # polar angle beyond which the other side's field is taken; it starts at 0.4 pi
GEAR_SWITCH_MOVING = cos(0.6 * pi)  # heading off the leader's beyond which the gear is changed; then 0.4 pi are left
GEAR_SWITCH_RESTING = cos(0.9 * pi)  # the same where the field outweighs the leader's own velocity
HYSTERESIS = 0.25  # [rad] how far past pi a heading error goes before a whole turn is dropped
OFTEN = 5.9  # reversals that come sooner, in units of sqrt(k2/(c k1)), drive a follower off
UNDOCK = 2.0  # docking ends at so many times the radius or the speed at which it begins


class Gains(NamedTuple):
    """Gains of the universal law; the defaults suit leaders of about 1 m/s and starts up to 20 m away."""

    k1: Annotated[float, Gain("1/T^2", "heading gain; advised k1 >= 36 c^2", search=(400.0, 1e6), above=0.0)] = 16.0
    k2: Annotated[float, Gain("1/T", "yaw-rate gain; advised k2 >= 2 sqrt(k1)", search=DAMPING, above=0.0)] = 8.0
    k3: Annotated[float, Gain("1/T", "speed gain", search=DAMPING, above=0.0)] = 6.0
    c: Annotated[
        float,
        Gain("1/T", "field gain: rate at which distance shrinks near the leader", search=(2.0, 100.0), above=0.0),
    ] = 0.5
    m: Annotated[
        float, Gain("1", "how often the field turns faster than the polar angle of the place", above=1.0, below=2.0)
    ] = 1.5
    # Lengths and speeds of this law are the scenario's own and are not searched.
    field_speed: Annotated[float, Gain("L/T", "largest speed that the field adds", above=0.0)] = 2.0
    turn_rate: Annotated[
        float,
        Gain(
            "1/T",
            "largest rate of the wanted heading that is fed forward, and of the attitude of a place with "
            "`formation: exact`, in radians",
            above=0.0,
        ),
    ] = 4.0
    dock_radius: Annotated[
        float,
        Gain(
            "L",
            "distance within which a follower stands and only aligns while its leader is slower than `dock_speed`: "
            "the accuracy at a leader at rest, and several times the noise of poses",
            above=0.0,
        ),
    ] = 0.005
    dock_speed: Annotated[float, Gain("L/T", "leader speed below which followers dock", above=0.0)] = 0.02
    dead_zone_speed: PlaceDeadZoneSpeed = 1e-3


class Memory(NamedTuple):
    """Memory of the law.

    Attributes:
        side: b, 1 where the follower comes in from ahead of its leader, -1 from behind.
        gear: s, 1 where it drives forward along the field, -1 in reverse.
        docked: whether it stands in its leader's place and only aligns.
        turns: winding number of the heading error.
    """

    side: int
    gear: int
    docked: bool
    turns: int


class _View(NamedTuple):
    """The follower seen from its leader, in the leader's frame.

    Attributes:
        x: r_x [m].
        y: r_y [m].
        distance: |r| [m].
        heading: theta_01, unwrapped [rad].
        x_rate: r_x' [m/s].
        y_rate: r_y' [m/s].
        cos: cos theta_01.
        sin: sin theta_01.
    """

    x: float
    y: float
    distance: float
    heading: float
    x_rate: float
    y_rate: float
    cos: float
    sin: float


class _Aim(NamedTuple):
    """What the follower is to do: w [m/s] and w' [m/s^2] in the leader's frame, a [rad] and a' [rad/s]."""

    w_x: float
    w_y: float
    w_x_rate: float
    w_y_rate: float
    heading: float
    turn: float


def init(gains: Gains, period: float, follower: Follower, leader: Leader) -> Memory:
    """Returns the memory to begin with: the side the follower is on, and the gear that side asks for at rest."""
    r = _seen(follower, leader)
    side = -1 if r.x < 0.0 else 1
    memory, aim = _aim(gains, r, leader, Memory(side, -side, False, 0))
    return Memory(memory.side, memory.gear, memory.docked, int(planar.winding_number(r.heading - aim.heading)))


def command(
    gains: Gains, period: float, limits: Limits, follower: Follower, leader: Leader, memory: Memory
) -> tuple[float, float, Memory]:
    """Returns u_x [m/s^2] and u_theta [rad/s^2] as above, and the memory for the next period."""
    r = _seen(follower, leader)
    memory, aim = _aim(gains, r, leader, memory)
    omega_01 = follower.omega - leader.omega
    turns = planar.winding_number_after(r.heading - aim.heading, float(memory.turns), HYSTERESIS)
    error = r.heading - aim.heading - 2 * pi * turns
    back, _ = return_rate(gains.k1 / gains.k2, limits.yaw_acceleration, error)
    u_theta = leader.u_theta - gains.k2 * (omega_01 - aim.turn + back)
    v_d = aim.w_x * r.cos + aim.w_y * r.sin
    v_d_rate = aim.w_x_rate * r.cos + aim.w_y_rate * r.sin + omega_01 * (r.cos * aim.w_y - r.sin * aim.w_x)
    u_x = v_d_rate - gains.k3 * (follower.v_x - v_d)
    u_x = within(u_x, follower.v_x, gains.k3, limits.speed, limits.acceleration)
    u_theta = within(u_theta, follower.omega, gains.k2, limits.yaw_rate, limits.yaw_acceleration)
    return u_x, u_theta, Memory(memory.side, memory.gear, memory.docked, int(turns))


@compiled
def _seen(follower: Follower, leader: Leader) -> _View:
    """Returns the follower seen from its leader."""
    x, y, heading = planar.between((leader.x, leader.y, leader.theta), (follower.x, follower.y, follower.theta))
    c, s, v = cos(heading), sin(heading), follower.v_x
    carried_x, carried_y = leader.v_x - leader.omega * y, leader.v_y + leader.omega * x
    return _View(x, y, sqrt(x * x + y * y), heading, v * c - carried_x, v * s - carried_y, c, s)


@compiled
def _aim(gains: Gains, r: _View, leader: Leader, memory: Memory) -> tuple[Memory, _Aim]:
    """Returns the modes of this period, and where they lead."""
    side, docked = _side_and_dock(gains, r, leader, memory)
    gear, c = memory.gear, gains.c
    if docked:
        w_x, w_y = leader.v_x - c * r.x, leader.v_y - c * r.y
        aim = _Aim(w_x, w_y, leader.u_x - c * r.x_rate, leader.u_y - c * r.y_rate, 0.0, 0.0)
        return Memory(side, gear, docked, memory.turns), aim
    w_x, w_y, w_x_rate, w_y_rate, field = _field(gains, r, leader, side)
    # The leader's velocity leads where it is larger than the field.
    leads = leader.v_x * leader.v_x + leader.v_y * leader.v_y > field
    least = GEAR_SWITCH_MOVING if leads else GEAR_SWITCH_RESTING
    square = w_x * w_x + w_y * w_y
    if gear * w_x < least * sqrt(square):
        gear = -gear
    turn = (w_x * w_y_rate - w_y * w_x_rate) / (square if square > 0.0 else 1.0)
    turn = planar.clip(turn, -gains.turn_rate, gains.turn_rate)
    aim = _Aim(w_x, w_y, w_x_rate, w_y_rate, atan2(gear * w_y, gear * w_x), turn)
    return Memory(side, gear, docked, memory.turns), aim


@compiled
def _side_and_dock(gains: Gains, r: _View, leader: Leader, memory: Memory) -> tuple[int, bool]:
    """Returns side and docking of this period; within the docking radius the side is noise."""
    widened = UNDOCK if memory.docked else 1.0
    near = r.distance < widened * gains.dock_radius
    speed = sqrt(leader.v_x * leader.v_x + leader.v_y * leader.v_y)
    docked = near and speed < widened * gains.dock_speed
    beyond = memory.side * r.x < SIDE_SWITCH * r.distance
    if beyond and r.distance > gains.dock_radius and not memory.docked:
        return -memory.side, docked
    return memory.side, docked


@compiled
def _field(gains: Gains, r: _View, leader: Leader, b: int) -> tuple[float, float, float, float, float]:
    """Returns w, w' and the square of sigma F."""
    c, m, rho = gains.c, gains.m, r.distance
    phi = atan2(b * r.y, b * r.x)
    inverse = 1 / rho if rho > 0.0 else 1.0
    e_x, e_y = inverse * r.x, inverse * r.y  # 0 on the leader, where the field has a corner: its rate counts as 0
    rho_rate, across = e_x * r.x_rate + e_y * r.y_rate, e_x * r.y_rate - e_y * r.x_rate  # rho', rho phi'
    half_cos, half_sin = cos(phi / 2), sin(phi / 2)
    along_x, along_y = -c * b * cos(m * phi), -c * b * sin(m * phi)
    lengthening, turning = rho_rate * half_cos - across * half_sin / 2, m * across * half_cos
    field_x, field_y = rho * half_cos * along_x, rho * half_cos * along_y  # F
    field_x_rate, field_y_rate = lengthening * along_x - turning * along_y, lengthening * along_y + turning * along_x
    sigma = 1 / sqrt(1 + (c * rho / gains.field_speed) ** 2)
    sigma_rate = -(sigma**3) * (c / gains.field_speed) ** 2 * rho * rho_rate

    omega, alpha = leader.omega, leader.u_theta
    sum_x, sum_y = field_x - omega * r.y, field_y + omega * r.x  # omega_0 J r + F
    sum_x_rate = field_x_rate - alpha * r.y - omega * r.y_rate
    sum_y_rate = field_y_rate + alpha * r.x + omega * r.x_rate
    w_x, w_y = leader.v_x + sigma * sum_x, leader.v_y + sigma * sum_y
    w_x_rate = leader.u_x + (sigma * sum_x_rate + sigma_rate * sum_x)
    w_y_rate = leader.u_y + (sigma * sum_y_rate + sigma_rate * sum_y)
    return w_x, w_y, w_x_rate, w_y_rate, sigma**2 * (field_x * field_x + field_y * field_y)


def beyond(gains: Gains, period: float, leader: LeaderMotion) -> tuple[str, ...]:
    """Returns that the leader reverses too often, or turns too fast for too long; the bounds are measured."""
    c, k_turn = gains.c, gains.k1 / gains.k2
    sooner = OFTEN / sqrt(c * k_turn)
    grows = f"{OFTEN:g} sqrt(k2/(c k1)): errors grow with each reversal"
    near = f"k1/k2: it need not be reached from farther than field_speed/c = {gains.field_speed / c:.3g} m"
    return (
        *reverses(period, leader, gains.dock_speed, sooner, grows),
        *turns(period, leader, 1 / c, k_turn, near),
    )


def warnings(gains: Gains, limits: Limits) -> tuple[str, ...]:
    """Returns what the gains break, with the formula, and what the limits leave no room for."""
    k1, k2, c, m = gains.k1, gains.k2, gains.c, gains.m
    found = []
    if not 1 < m < 2:
        found.append(f"m = {m:g} is not between 1 and 2: headings do not settle on the field")
    if k2 < 2 * sqrt(k1):
        found.append(f"k2 = {k2:g} is below 2 sqrt(k1) = {2 * sqrt(k1):g}: the heading overshoots")
    if k1 < 36 * c**2:
        found.append(
            f"k1 = {k1:g} is below 36 c^2 = {36 * c**2:g}: the heading lags behind the field, and some "
            "starts do not converge to a leader that reverses"
        )
    return (*found, *field_warnings(c, gains.field_speed, limits))
