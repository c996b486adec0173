"""The single-follower tracking law of the paper (Theorem 1).

    u_theta1 = -ke (theta01 - theta~01) - kp (theta01 + k beta) - kd omega01 + u_theta0
    u_x1     = -kp q_x - kd v_x01 + (u_x0 - u_theta0 r_y) cos theta01 + u_theta0 r_x sin theta01

(paper eq. 26) with (r_x, r_y, theta01) the follower seen from the leader, q its exponential coordinates,
beta = -arctan(q_y/q_x) and theta~01 the adjoint attitude (eq. 17). `variant: full` adds to u_x1 the x component of the
bracket [xi_1, xi_01], `-omega_1 v_y01`, which the paper's own general form has (eq. 25) and its printed law drops.

Assumes: states measured without error; leader without lateral velocity (another leader's is taken in by the adjoint
attitude and the relative velocity). Claims, as printed: global asymptotic tracking of any reference. What holds: with
the leader at rest, alignment from almost every start where k > 2 (1 + ke/kp) and kd >= 2 sqrt(kp); with a moving leader
a limit cycle around it remains (tests/laws/test_claims.py; docs/theory.md).
"""

from __future__ import annotations

from math import sqrt
from typing import Annotated, NamedTuple

from nhtrack import planar
from nhtrack.laws.contract import Follower, Gain, Leader, LeaderMotion, Limits
from nhtrack.laws.gains import DAMPING, STEERING, STIFFNESS, DeadZoneLength, DeadZoneSpeed, Hysteresis
from nhtrack.laws.leader_bounds import late_speed
from nhtrack.laws.relative_motion import adjoint_attitude, relative_motion, relative_turns, side_angle

FULL = 1  # the variant with the bracket
CYCLE = 0.5  # radius of the cycle behind a leader on a line, about [v_0/sqrt(kp)]; it depends on ratios of gains


class Gains(NamedTuple):
    """Gains of Theorem 1."""

    kp: Annotated[float, Gain("1/T^2", "position gain", search=STIFFNESS, above=0.0)]
    kd: Annotated[float, Gain("1/T", "damping gain; advised kd >= 2 sqrt(kp)", search=DAMPING, least=0.0)]
    ke: Annotated[float, Gain("1/T^2", "gain on the adjoint attitude", search=(0.25, 4e4), least=0.0)]
    k: Annotated[float, Gain("1", "steering gain on beta; advised k > 2 (1 + ke/kp)", search=STEERING)]
    variant: Annotated[
        int,
        Gain(
            "1",
            "`published`: u_x as printed; `full`: with the bracket term the printed form drops",
            choices=("published", "full"),
        ),
    ] = 0
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
    """Returns u_x1 [m/s^2] and u_theta1 [rad/s^2], paper eq. 26, and the winding number."""
    kp, kd, ke, k = gains.kp, gains.kd, gains.ke, gains.k
    relative = relative_motion(follower, leader, memory.turns, gains.hysteresis)
    theta, omega = relative.theta, relative.omega
    beta = side_angle(relative, gains.dead_zone_length)
    attitude = adjoint_attitude(relative, gains.dead_zone_speed)
    u_theta = -ke * (theta - attitude) - kp * (theta + k * beta) - kd * omega + leader.u_theta

    carried_x, carried_y = leader.u_x - leader.u_theta * relative.y, leader.u_y + leader.u_theta * relative.x
    feedforward = relative.cos * carried_x + relative.sin * carried_y
    u_x = -kp * relative.q_x - kd * relative.v_x + feedforward
    if gains.variant == FULL:
        u_x += planar.ad((follower.v_x, follower.v_y, follower.omega), (relative.v_x, relative.v_y, omega))[0]
    return u_x, u_theta, Memory(relative.turns)


def beyond(gains: Gains, period: float, leader: LeaderMotion) -> tuple[str, ...]:
    """Returns that the leader still drives at the end, and so the size of the cycle about it that is left."""
    speed = late_speed(leader)
    radius = CYCLE * speed / sqrt(gains.kp)
    if radius <= gains.dead_zone_length:
        return ()
    size = f"some {CYCLE:g} |v_0|/sqrt(kp) = {radius:.2g} m wide and half a radian askew"
    return (f"|v_0| is still {speed:.3g} m/s late in the run: followers end on a cycle about it, {size}",)


def warnings(gains: Gains, limits: Limits) -> tuple[str, ...]:
    """Returns what the gains break, with the formula; empty where a resting leader's heading is reached."""
    return gain_warnings(gains.kp, gains.kd, gains.ke, gains.k)


def gain_warnings(kp: float, kd: float, ke: float, k: float) -> tuple[str, ...]:
    """Returns a sentence for each condition that the gains break.

    For a resting leader the heading follows m = 2 k_eff/(2 + k_eff) times the polar angle of the position, with
    k_eff = k kp/(kp + ke); the angle shrinks only if m > 1, that is k > 2 (1 + ke/kp). kd >= 2 sqrt(kp) keeps q_x from
    changing sign, where beta jumps by pi.
    """
    found = []
    bound = 2 * (1 + ke / kp)
    if k <= bound:
        found.append(
            f"k = {k:g} is not above 2 (1 + ke/kp) = {bound:g}: with the leader at rest the heading will not align"
        )
    critical = 2 * sqrt(kp)
    if kd < critical:
        found.append(f"kd = {kd:g} is below 2 sqrt(kp) = {critical:g}: q_x overshoots and beta jumps by pi each time")
    return tuple(found)
