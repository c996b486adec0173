"""A hybrid law for leaders that reverse often, spin and circle fast, and for those that are slow or at rest.

It keeps a memory of how its leader has moved (`nhtrack.laws.leader_motion`) and sets its gains by that: with E_v, E_w
peaks of v_0^2 and omega_0^2, L^2 and H means of psi^2 and its peaks, z_e and z_m means of e^(2i theta_0) and
psi^2 e^(2i theta_0),

    b   = min(k_inner^2/(E_v + least_speed^2), rate/(k_theta H))
    k_x = 2 zeta clip(sqrt(E_w + (b k_theta L^2)^2), rate/4, 4 rate)
    lambda = (k_x + b k_theta L^2 - |k_x z_e - b k_theta z_m|)/2,

the rate at which place errors shrink, by averaging. A leader is lively from lambda > 0.4 rate on, until
lambda < 0.2 rate. Three modes:

    near   v_c = V_x + f(x),  omega_c = omega_0 + g(theta) + b v_0 sinc(theta) y/q        (x, y, theta): leader seen
    far    w = Vbar - c r/sqrt(1 + (c |r|/field_speed)^2) in the world,  v_c = <w, e>,  omega_c = angle(s w)' - h(error)
    calm   `universal` behind the smoothed leader; the rest of the leader's velocity is carried along the heading

f, g and h have the gains k_x, k_theta and k_turn and brake within limits; |f| < field_speed/2, |g| < 2 turn_rate; q^2 =
1 + b^2 E_v |r|^2/turn_rate^2; turn_rate is cut to what limits on turning allow. All commanded velocities are lifted to
accelerations by the inner loop. Near, whole turns are taken off theta + theta'/k_inner, about what theta will be once
velocities have caught up: a follower that spins at first goes on to the nearest turn. A lively leader is pursued until
it is near, and a calm one until the follower is within `dock_radius`, or within 4 sqrt(H) of one that sways steadily
(lambda > 0.1 rate, L^2 > H/2); twice as far, nearness ends.

Sources: near is Samson's law (`nhtrack.laws.samson`) saturated and with gains that do not vanish with the leader's
velocities; far is pursuit along a vector field. Assumes: states measured without error, the leader's acceleration
known. What is proved, what is only measured, and for which leaders: docs/theory.md.
"""

from __future__ import annotations

from math import cos, hypot, inf, pi, sin, sqrt
from typing import Annotated, NamedTuple

from nhtrack import planar
from nhtrack.compiled import compiled
from nhtrack.laws import leader_motion, pursuit, universal
from nhtrack.laws.contract import Follower, Gain, Leader, LeaderMotion, Limits
from nhtrack.laws.gains import DAMPING, InnerGain, PlaceDeadZoneSpeed
from nhtrack.laws.inner_loop import Velocities, inner_loop
from nhtrack.laws.leader_bounds import accelerates, sampled_too_seldom, starts_from_rest
from nhtrack.laws.leader_motion import Seen, SeenRow, schedule
from nhtrack.laws.limited import bounded, field_warnings, return_rate, turn_rate_within, within
from nhtrack.laws.relative_motion import theta_to_come, view

CALM, FAR, NEAR = 0, 1, 2
LIVELY, NO_LONGER_LIVELY = 0.4, 0.2  # predicted rates at which a leader begins and ceases to be lively [rate]
STEADY = 0.1  # predicted rate above which one that is not lively is near within its own swaying [rate]
WIDENED = 2.0  # a follower ceases to be near at so many times the distance at which it began
STEERABLE = 2.0  # the lateral error at which nearness begins asks for at most so many times `turn_rate`
SWAY = 4.0  # but nearness begins no later than at so many times the leader's own swaying, sqrt(H)
SHORT = 1.2  # margin on the distance that pursuit keeps from a leader that accelerates
LONG = 10.0  # [smoothing] how long a leader that accelerates hard is lost
RESTED, SUDDEN = 2.0, 0.25  # [window], [field_speed] a rest, and a start, after which an exact place is left
RETURN_SPEED = 0.5  # largest f [field_speed]
RETURN_TURN = 2.0  # largest g [turn_rate]
FIELD_TURNS = 1.5  # m of `universal`

_Calm, _CalmMemory = universal.Gains, universal.Memory
_calm_init, _calm_command = compiled(universal.init), compiled(universal.command)


class Gains(NamedTuple):
    """Gains of the agile law; the defaults suit leaders of about 1 m/s and starts up to 20 m away."""

    rate: Annotated[float, Gain("1/T", "rate at which places settle", search=(4.0, 200.0), above=0.0)] = 1.0
    k_theta: Annotated[float, Gain("1/T", "heading gain near the leader", search=DAMPING, above=0.0)] = 5.0
    k_turn: Annotated[float, Gain("1/T", "heading gain far from the leader", search=DAMPING, above=0.0)] = 2.0
    k_inner: InnerGain = 6.0
    zeta: Annotated[float, Gain("1", "damping ratio near the leader", above=0.0)] = 0.7
    c: Annotated[float, Gain("1/T", "rate of the approach from afar", search=(2.0, 100.0), above=0.0)] = 0.7
    # Lengths, speeds and times of this law are the scenario's own and are not searched.
    field_speed: Annotated[float, Gain("L/T", "largest speed that distance adds far from the leader", above=0.0)] = 1.8
    turn_rate: Annotated[
        float,
        Gain(
            "1/T",
            "largest rate of turning that distance asks for, and of the attitude of a place with `formation: exact`, "
            "in radians",
            above=0.0,
        ),
    ] = 3.0
    window: Annotated[float, Gain("T", "how long the leader's motion is remembered", above=0.0)] = 5.0
    smoothing: Annotated[float, Gain("T", "time constant of the leader's motion as it is pursued", above=0.0)] = 0.6
    near_radius: Annotated[float, Gain("L", "distance within which a lively leader is near", above=0.0)] = 0.75
    dock_radius: Annotated[
        float,
        Gain(
            "L",
            "distance within which a calm leader is near: the accuracy at a leader at rest, and several times the "
            "noise of poses",
            above=0.0,
        ),
    ] = 0.005
    least_speed: Annotated[float, Gain("L/T", "leader speed below which steering grows no stiffer", above=0.0)] = 0.1
    dead_zone_speed: PlaceDeadZoneSpeed = 1e-3


class Memory(NamedTuple):
    """Memory of the law.

    Attributes:
        mode: 0 calm, 1 far, 2 near.
        side: of `universal`, while calm.
        gear: 1 where it drives forward along the field, -1 in reverse; while calm or far.
        turns: whole turns taken off the heading error; near and calm.
        off: heading error less whole turns [rad]; far.
        seen: see `nhtrack.laws.leader_motion.Seen`.
    """

    mode: int
    side: int
    gear: int
    turns: int
    off: float
    seen: SeenRow


def init(gains: Gains, period: float, follower: Follower, leader: Leader) -> Memory:
    """Returns the memory to begin with: the leader has always moved as it does now."""
    seen = leader_motion.first_seen(leader, gains.k_theta, gains.window, gains.smoothing)
    mode = _mode(gains, follower, leader, CALM, seen)
    return _begun(gains, period, follower, leader, mode, seen)


def command(
    gains: Gains, period: float, limits: Limits, follower: Follower, leader: Leader, memory: Memory
) -> tuple[float, float, Memory]:
    """Returns u_x [m/s^2] and u_theta [rad/s^2] as above, and the memory for the next period."""
    seen = leader_motion.seen_after(memory.seen, leader, period, gains.k_theta, gains.window, gains.smoothing)
    gains = _within_limits(gains, limits)
    mode = _mode(gains, follower, leader, memory.mode, seen)
    if mode == memory.mode:
        memory = Memory(mode, memory.side, memory.gear, memory.turns, memory.off, seen)
    else:
        memory = _begun(gains, period, follower, leader, mode, seen)
    if mode == NEAR:
        u_x, u_theta, memory = _near(gains, limits, follower, leader, memory)
    elif mode == FAR:
        u_x, u_theta, memory = _far(gains, limits, follower, leader, memory)
    else:
        u_x, u_theta, memory = _calm(gains, period, limits, follower, leader, memory)
    u_x = within(u_x, follower.v_x, gains.k_inner, limits.speed, limits.acceleration)
    u_theta = within(u_theta, follower.omega, gains.k_inner, limits.yaw_rate, limits.yaw_acceleration)
    return u_x, u_theta, memory


@compiled
def _within_limits(gains: Gains, limits: Limits) -> Gains:
    """Returns the gains with a `turn_rate` that the limits allow."""
    return Gains(
        gains.rate, gains.k_theta, gains.k_turn, gains.k_inner, gains.zeta, gains.c, gains.field_speed,
        turn_rate_within(gains.turn_rate, limits), gains.window, gains.smoothing, gains.near_radius,
        gains.dock_radius, gains.least_speed, gains.dead_zone_speed,
    )  # fmt: skip


@compiled
def _mode(gains: Gains, follower: Follower, leader: Leader, mode: int, row: SeenRow) -> int:
    """Returns the mode of this period; `mode` is that of the last, or CALM at the start."""
    seen = Seen(*row)
    scheduled = schedule(seen, gains.rate, gains.k_theta, gains.k_inner, gains.zeta, gains.least_speed)
    lively = scheduled.contraction > gains.rate * (LIVELY if mode == CALM else NO_LONGER_LIVELY)
    distance = hypot(follower.x - leader.x, follower.y - leader.y)
    if not lively:
        sways = scheduled.contraction > STEADY * gains.rate and seen.reach_2 > seen.held_2 / 2
        reach = max(gains.dock_radius, SWAY * sqrt(seen.held_2) if sways else 0.0)
        return NEAR if distance < reach * (WIDENED if mode == NEAR else 1.0) else CALM
    V_x, V_y = leader_motion.world_velocity(leader)
    short = SHORT / gains.c * hypot(V_x - seen.velocity_x, V_y - seen.velocity_y)
    if mode == NEAR:
        return NEAR if distance < WIDENED * gains.near_radius + short else FAR
    reach = gains.near_radius + short
    stiffness, most = scheduled.b * sqrt(seen.speed_2), STEERABLE * gains.turn_rate
    if stiffness * reach > most:
        reach = max(most / stiffness, min(reach, SWAY * sqrt(seen.held_2)))
    return NEAR if distance < max(reach, gains.dock_radius) else FAR


@compiled
def _begun(gains: Gains, period: float, follower: Follower, leader: Leader, mode: int, row: SeenRow) -> Memory:
    """Returns the memory of a mode that begins."""
    seen = Seen(*row)
    if mode == NEAR:
        turns = planar.winding_number(theta_to_come(view(follower, leader), gains.k_inner))
        return Memory(mode, 1, 1, int(turns), 0.0, row)
    if mode == FAR:
        gear = pursuit.first_gear(follower, leader)
        w_x, w_y, _, _ = pursuit.velocity(gains.c, gains.field_speed, gains.smoothing, follower, leader, seen)
        return Memory(mode, 1, gear, 0, pursuit.off_course(follower, gear, w_x, w_y, 0.0), row)
    rest, smooth, _ = leader_motion.behind_smoothed(follower, leader, seen, gains.smoothing)
    began = _calm_init(_universal(gains), period, rest, smooth)
    return Memory(mode, began.side, began.gear, began.turns, 0.0, row)


@compiled
def _near(
    gains: Gains, limits: Limits, follower: Follower, leader: Leader, memory: Memory
) -> tuple[float, float, Memory]:
    """Returns the accelerations near a leader, and the memory."""
    seen = Seen(*memory.seen)
    scheduled = schedule(seen, gains.rate, gains.k_theta, gains.k_inner, gains.zeta, gains.least_speed)
    e = view(follower, leader)
    turns = planar.winding_number_after(theta_to_come(e, gains.k_inner), float(memory.turns), pursuit.HYSTERESIS)
    theta = e.theta - 2 * pi * turns
    v, u, b = leader.v_x, leader.u_x, scheduled.b
    pull = (b / gains.turn_rate) ** 2 * seen.speed_2
    q = sqrt(1 + pull * (e.x * e.x + e.y * e.y))
    q_rate = pull * (e.x * e.x_rate + e.y * e.y_rate) / q
    y = e.y / q
    y_rate = (e.y_rate - y * q_rate) / q
    ratio, slope = planar.sinc_and_slope(theta)
    aside, aside_rate = ratio * y, slope * e.theta_rate * y + ratio * y_rate
    lead, lead_rate = leader_motion.slip_angle(leader, gains.least_speed)
    ahead, ahead_slope = bounded(
        RETURN_SPEED * gains.field_speed, *return_rate(scheduled.k_x, limits.acceleration, e.x)
    )
    turn, turn_slope = bounded(
        RETURN_TURN * gains.turn_rate, *return_rate(gains.k_theta, limits.yaw_acceleration, theta + lead)
    )
    V_x, V_y = e.cos * v - e.sin * leader.v_y, e.sin * v + e.cos * leader.v_y
    u_x, u_theta = inner_loop(
        follower,
        Velocities(
            v=V_x + ahead,
            omega=leader.omega + turn + b * v * aside,
            v_rate=e.cos * u - e.sin * leader.u_y - e.theta_rate * V_y + ahead_slope * e.x_rate,
            omega_rate=leader.u_theta + turn_slope * (e.theta_rate + lead_rate) + b * (u * aside + v * aside_rate),
        ),
        gains.k_inner,
    )
    return u_x, u_theta, Memory(memory.mode, memory.side, memory.gear, int(turns), 0.0, memory.seen)


@compiled
def _far(
    gains: Gains, limits: Limits, follower: Follower, leader: Leader, memory: Memory
) -> tuple[float, float, Memory]:
    """Returns the accelerations far from a lively leader, and the memory."""
    seen = Seen(*memory.seen)
    pursued = pursuit.velocity(gains.c, gains.field_speed, gains.smoothing, follower, leader, seen)
    w_x, w_y, w_x_rate, w_y_rate = pursued
    gear = pursuit.gear_after(memory.gear, follower, leader, seen, w_x, w_y)
    off = pursuit.off_course(follower, gear, w_x, w_y, memory.off if gear == memory.gear else 0.0)
    c, s, omega = cos(follower.theta), sin(follower.theta), follower.omega
    along, square = w_x * c + w_y * s, w_x * w_x + w_y * w_y
    turn = (w_x * w_y_rate - w_y * w_x_rate) / (square if square > 0.0 else 1.0)
    turn = planar.clip(turn, -gains.turn_rate, gains.turn_rate)
    back, slope = return_rate(gains.k_turn, limits.yaw_acceleration, off)
    along_rate = w_x_rate * c + w_y_rate * s + omega * (w_y * c - w_x * s)
    wanted = Velocities(along, turn - back, along_rate, -slope * (omega - turn))
    u_x, u_theta = inner_loop(follower, wanted, gains.k_inner)
    return u_x, u_theta, Memory(memory.mode, memory.side, gear, 0, off, memory.seen)


@compiled
def _universal(gains: Gains) -> universal.Gains:
    """Returns the gains of `universal`: k1 and k2 are those of an inner loop around k_turn."""
    return _Calm(
        gains.k_inner * gains.k_turn, gains.k_inner + gains.k_turn, gains.k_inner, gains.c, FIELD_TURNS,
        gains.field_speed, gains.turn_rate, gains.dock_radius, 0.0, gains.dead_zone_speed,
    )  # fmt: skip


@compiled
def _calm(
    gains: Gains, period: float, limits: Limits, follower: Follower, leader: Leader, memory: Memory
) -> tuple[float, float, Memory]:
    """Returns the accelerations far from a leader that hardly moves, and the memory."""
    rest, smooth, carried_rate = leader_motion.behind_smoothed(follower, leader, Seen(*memory.seen), gains.smoothing)
    free = Limits(inf, inf, inf, limits.yaw_acceleration)
    u_x, u_theta, kept = _calm_command(
        _universal(gains), period, free, rest, smooth, _CalmMemory(memory.side, memory.gear, False, memory.turns)
    )
    return u_x + carried_rate, u_theta, Memory(memory.mode, kept.side, kept.gear, kept.turns, 0.0, memory.seen)


def beyond(gains: Gains, period: float, leader: LeaderMotion) -> tuple[str, ...]:
    """Returns that periods are too long, or that the leader accelerates for too long or starts too suddenly."""
    slow, speed, rest, smoothing = gains.least_speed, gains.field_speed, RESTED * gains.window, gains.smoothing
    sudden = starts_from_rest(period, leader, slow, rest / 2, smoothing / 3, SUDDEN * speed)
    return (
        *sampled_too_seldom(period, gains.k_inner, gains.k_theta),
        *accelerates(period, leader, LONG * smoothing, speed / smoothing, "field_speed/smoothing"),
        *(sudden or starts_from_rest(period, leader, slow, rest, smoothing, SUDDEN * speed)),
    )


def warnings(gains: Gains, limits: Limits) -> tuple[str, ...]:
    """Returns what the gains break, with the formula, and what the limits leave no room for."""
    found = []
    if gains.k_theta > gains.k_inner:
        found.append(f"k_theta = {gains.k_theta:g} is above k_inner = {gains.k_inner:g}: velocities lag behind")
    if gains.k_turn < 2 * gains.c:
        found.append(f"k_turn = {gains.k_turn:g} is below 2 c = {2 * gains.c:g}: the heading lags behind the field")
    if gains.near_radius <= WIDENED * gains.dock_radius:
        found.append(
            f"near_radius = {gains.near_radius:g} is not above {WIDENED:g} dock_radius: a lively leader is lost at once"
        )
    return (*found, *field_warnings(gains.c, gains.field_speed, limits))
