"""Dynamic feedback linearisation (Oriolo, De Luca, Vendittelli 2002): linear where speed is not near zero.

The law of Oriolo, De Luca and Vendittelli, IEEE Trans. Control Systems Technology 10, 2002:

    w = p_r'' + kd (p_r' - p') + kp (p_r - p)
    xi' = w_x,   omega_c = w_y/xi,   w in the follower's frame

The source integrates xi and commands it as speed. Here speed is an integrator already, so xi is the follower's own
speed v, u_x = w_x, and there is no memory; omega_c is lifted by `inner_loop`. Its derivative takes the leader's
jerk, of which u_r' is not known and counts as zero, as it is while an input is held. So `e'' + kd e' + kp e = 0`
for e = p_r - p once the inner loop has settled.

At xi = 0 the law is singular. |xi| is therefore never taken smaller than `v_min`, with the sign of the leader's
speed, or of v where the leader is slower than `v_min` itself. As if the source's integrator were reset, a follower
whose speed is not on that side of v_min is led there by the inner loop while the leader moves, and a w_x that would
slow it down further is left out. With the leader at rest it is not, so that it can stop. A small v_min asks for
turning rates w_y/v_min that a control period cannot follow; too small a one and the follower runs away.

Assumes: p_r'' as commanded. Needs: |v_r| above v_min. Claims: exponential tracking of p_r while |v| > v_min; the
heading follows from the direction of p', so at a leader at rest it is left over.
Checked: tests/laws/test_baselines.py (`test_feedback_linearisation_...`).
"""

from __future__ import annotations

from math import sqrt
from typing import Annotated, NamedTuple

from nhtrack.compiled import compiled
from nhtrack.laws.contract import Follower, Gain, Leader, LeaderMotion, Limits
from nhtrack.laws.gains import DAMPING, STIFFNESS, InnerGain, PlaceDeadZoneSpeed
from nhtrack.laws.inner_loop import Velocities, inner_loop
from nhtrack.laws.leader_bounds import is_slow
from nhtrack.laws.relative_motion import leader_derivatives, turned, view


class Gains(NamedTuple):
    """Gains of feedback linearisation; the defaults suit leaders of about 1 m/s and starts 10 m away."""

    kp: Annotated[float, Gain("1/T^2", "position gain", search=STIFFNESS, above=0.0)] = 1.0
    kd: Annotated[float, Gain("1/T", "damping gain; advised kd >= 2 sqrt(kp)", search=DAMPING, above=0.0)] = 2.5
    k_inner: InnerGain = 5.0
    v_min: Annotated[
        float, Gain("L/T", "smallest speed that turning rates are divided by", search=(0.01, 0.5), above=0.0)
    ] = 0.1
    dead_zone_speed: PlaceDeadZoneSpeed = 1e-3


def command(
    gains: Gains, period: float, limits: Limits, follower: Follower, leader: Leader, memory: tuple[()]
) -> tuple[float, float, tuple[()]]:
    """Returns u_x [m/s^2] and u_theta [rad/s^2]; vectors are in the follower's frame."""
    kp, kd, v, omega = gains.kp, gains.kd, follower.v_x, follower.omega
    e = view(follower, leader)
    forward, aside = turned(e, leader.v_x, leader.v_y)  # p_r'
    closing_x, closing_y = forward - v, aside
    (acceleration_x, acceleration_y), (_, jerk_y) = leader_derivatives(e, leader)
    w_x = acceleration_x + kd * closing_x + kp * e.x
    w_y = acceleration_y + kd * closing_y + kp * e.y
    w_y_rate = jerk_y + kd * (acceleration_y - v * omega) + kp * closing_y - omega * w_x
    u_x, u_theta = inner_loop(follower, _velocities(gains.v_min, v, leader.v_x, w_x, w_y, w_y_rate), gains.k_inner)
    return u_x, u_theta, memory


@compiled
def _velocities(v_min: float, v: float, v_r: float, w_x: float, w_y: float, w_y_rate: float) -> Velocities:
    """Returns xi, omega_c and their derivatives, with |xi| at least v_min."""
    moving = abs(v_r) > v_min
    sign = -1.0 if (v_r if moving else v) < 0.0 else 1.0
    if sign * v >= v_min:
        omega_c = w_y / v
        return Velocities(v, omega_c, w_x, (w_y_rate - omega_c * w_x) / v)
    xi = sign * v_min
    if moving:
        return Velocities(xi, w_y / xi, w_x if sign * w_x > 0.0 else 0.0, w_y_rate / xi)
    return Velocities(v, w_y / xi, w_x, w_y_rate / xi)


def beyond(gains: Gains, period: float, leader: LeaderMotion) -> tuple[str, ...]:
    """Returns that a leader is slow where the law is singular; one that only drives off may be."""
    return is_slow(period, leader, gains.v_min, "v_min: there the heading is not steered")


def warnings(gains: Gains, limits: Limits) -> tuple[str, ...]:
    """Returns what the gains break of the source's conditions."""
    critical = 2 * sqrt(gains.kp)
    if gains.kd >= critical:
        return ()
    return (
        f"kd = {gains.kd:g} is below 2 sqrt(kp) = {critical:g}: errors overshoot, and v passes the singularity",
    )
