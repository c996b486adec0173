"""A guiding vector field (Kapitanyuk, Proskurnikov and Cao 2017) along the leader's momentary path.

Kapitanyuk, Proskurnikov and Cao, "A guiding vector-field algorithm for path-following control of nonholonomic
mobile robots", IEEE Trans. Control Systems Technology 26, 2018 (arXiv 1610.04391). The path is where phi = 0 (eq. 2
there), n = grad phi, tau is n turned by a quarter, and the robot turns to the field (eq. 9 there)

    w = tau - k_n phi n,   omega_c = angle(w)' + k_theta (angle(w) - theta).

The source follows a path that is given for all time, at a constant speed and at no particular place of it. Adapted
here, for a leader of which only the present motion is known:

- the path is the line or circle of the leader's twist, in its frame `phi = y - kappa (x^2 + y^2)/2`, kappa =
  omega_r/v_r, (x, y) being the follower's place. While the twist is constant it slides along itself and rests in
  the world; otherwise angle(w)' and its derivative have the rates of kappa. tau = (1 - kappa y, kappa x) is then
  the paper's adjoint velocity over v_r. Below `least_speed` kappa = omega_r v_r/least_speed^2;
- speed is led by how far ahead of its leader the follower is, and keeps the sign sigma of v_r, as the source needs,

      v_c = sigma sqrt(v_r^2 + (k_x x)^2) - k_x x;

- with v_r < 0 the follower backs along the field: its heading is turned to `sigma w`, with -tau for tau.

Both velocities are lifted to accelerations by `inner_loop`; u_r' is not known and counts as zero, as it is while an
input is held. The field has no direction where n = 0, at the centre of the circle.

Assumes: velocities that the robot takes at once (here after the inner loop has settled). Needs: |v_r| above
least_speed, constant sign, kappa that changes slowly. Claims: of the source, convergence to a path at rest from
every start but for those that end where n = 0; of the place along it, and of paths that change, nothing. At rest
followers stop beside the leader.
Checked: tests/laws/test_further_baselines.py (`test_guiding_field_...`).
"""

from __future__ import annotations

from math import atan, atan2, pi, sqrt
from typing import Annotated, NamedTuple

import numpy as np

from nhtrack import planar
from nhtrack.compiled import compiled
from nhtrack.laws.contract import Follower, Gain, Leader, LeaderMotion, Limits
from nhtrack.laws.gains import DAMPING, Hysteresis, InnerGain, PlaceDeadZoneSpeed
from nhtrack.laws.inner_loop import Velocities, inner_loop
from nhtrack.laws.leader_bounds import errors_left, not_brought_down, reverses
from nhtrack.laws.relative_motion import direction_rates, view

OFTEN = 3.5  # reversals that come sooner [1/k_theta] leave followers behind
CENTRE = 1e-6  # |grad phi| below which the field has no direction


class Gains(NamedTuple):
    """Gains of the guiding field; the defaults suit leaders of about 1 m/s and starts 10 m away."""

    k_n: Annotated[float, Gain("1/L", "how steeply the field leads to the path", search=DAMPING, above=0.0)] = 0.5
    k_x: Annotated[float, Gain("1/T", "gain on the distance along the path", search=DAMPING, above=0.0)] = 0.5
    k_theta: Annotated[float, Gain("1/T", "gain on the heading's error", search=DAMPING, above=0.0)] = 2.0
    k_inner: InnerGain = 5.0
    least_speed: Annotated[
        float, Gain("L/T", "leader speed below which its path is taken as straighter than it is", above=0.0)
    ] = 0.1
    hysteresis: Hysteresis = 0.25
    dead_zone_speed: PlaceDeadZoneSpeed = 1e-3


class Memory(NamedTuple):
    """Memory of the law.

    Attributes:
        turns: winding number of the heading's error.
    """

    turns: int


class _Jet(NamedTuple):
    """A quantity with its first and second derivative."""

    value: float
    rate: float
    second: float


def init(gains: Gains, period: float, follower: Follower, leader: Leader) -> Memory:
    """Returns the winding number of the heading's error."""
    x, y = _place(follower, leader, 0.0)
    return Memory(int(planar.winding_number(_aim(gains, leader, x, y).value + leader.theta - follower.theta)))


def command(
    gains: Gains, period: float, limits: Limits, follower: Follower, leader: Leader, memory: Memory
) -> tuple[float, float, Memory]:
    """Returns u_x [m/s^2] and u_theta [rad/s^2], which lead to v_c and omega_c, and the memory."""
    x, _ = _place(follower, leader, 0.0)
    v, v_rate = _speed(gains.k_x, leader, x)
    u_x, _ = inner_loop(follower, Velocities(v, 0.0, v_rate, 0.0), gains.k_inner)
    x, y = _place(follower, leader, u_x)
    aim = _aim(gains, leader, x, y)
    error = aim.value + leader.theta - follower.theta
    turns = planar.winding_number_after(error, float(memory.turns), gains.hysteresis)
    error_rate = aim.rate + leader.omega - follower.omega
    commanded = Velocities(
        v,
        leader.omega + aim.rate + gains.k_theta * (error - 2 * pi * turns),
        v_rate,
        leader.u_theta + aim.second + gains.k_theta * error_rate,
    )
    u_x, u_theta = inner_loop(follower, commanded, gains.k_inner)
    return u_x, u_theta, Memory(int(turns))


@compiled
def _speed(k_x: float, leader: Leader, x: _Jet) -> tuple[float, float]:
    """Returns v_c and its derivative."""
    v_r, ahead, sign = leader.v_x, k_x * x.value, _sign(leader)
    root = sqrt(v_r * v_r + ahead * ahead)
    if root == 0.0:
        return 0.0, -k_x * x.rate
    root_rate = (v_r * leader.u_x + ahead * k_x * x.rate) / root
    return sign * root - ahead, sign * root_rate - k_x * x.rate


@compiled
def _sign(leader: Leader) -> float:
    return -1.0 if leader.v_x < 0.0 else 1.0


@compiled
def _place(follower: Follower, leader: Leader, u_x: float) -> tuple[_Jet, _Jet]:
    """Returns x and y, the follower's place in the leader's frame; only second derivatives have its acceleration."""
    e, v, omega, alpha = view(follower, leader), follower.v_x, leader.omega, leader.u_theta
    x, y = -(e.cos * e.x + e.sin * e.y), e.sin * e.x - e.cos * e.y
    x_1 = v * e.cos - (leader.v_x - omega * y)
    y_1 = -v * e.sin - (leader.v_y + omega * x)
    x_2 = u_x * e.cos - v * e.sin * e.theta_rate - (leader.u_x - alpha * y - omega * y_1)
    y_2 = -u_x * e.sin - v * e.cos * e.theta_rate - (leader.u_y + alpha * x + omega * x_1)
    return _Jet(x, x_1, x_2), _Jet(y, y_1, y_2)


@compiled
def _curvature(least_speed: float, leader: Leader) -> _Jet:
    """Returns kappa of the leader's path."""
    v, omega, u, alpha = leader.v_x, leader.omega, leader.u_x, leader.u_theta
    if abs(v) < least_speed:
        square = least_speed * least_speed
        return _Jet(omega * v / square, (alpha * v + omega * u) / square, 2 * alpha * u / square)
    rate = (alpha - omega / v * u) / v
    return _Jet(omega / v, rate, -2 * rate * u / v)


@compiled
def _aim(gains: Gains, leader: Leader, x: _Jet, y: _Jet) -> _Jet:
    """Returns the direction of sigma w in the leader's frame: that of tau less arctan(sigma k_n phi)."""
    k = _curvature(gains.least_speed, leader)
    square = (x.value * x.value + y.value * y.value) / 2
    square_1 = x.value * x.rate + y.value * y.rate
    square_2 = x.rate * x.rate + y.rate * y.rate + x.value * x.second + y.value * y.second
    phi = y.value - k.value * square
    phi_1 = y.rate - k.rate * square - k.value * square_1
    phi_2 = y.second - k.second * square - 2 * k.rate * square_1 - k.value * square_2

    tau = (1 - k.value * y.value, k.value * x.value)
    tau_1 = (-k.rate * y.value - k.value * y.rate, k.rate * x.value + k.value * x.rate)
    tau_2 = (
        -k.second * y.value - 2 * k.rate * y.rate - k.value * y.second,
        k.second * x.value + 2 * k.rate * x.rate + k.value * x.second,
    )
    turn, turn_rate = direction_rates(tau, tau_1, tau_2, CENTRE)
    steep = _sign(leader) * gains.k_n
    root = 1 + (steep * phi) ** 2
    off, off_1 = atan(steep * phi), steep * phi_1 / root
    off_2 = (steep * phi_2 - 2 * steep * steep * phi * phi_1 * off_1) / root
    return _Jet(atan2(tau[1], tau[0]) - off, turn - off_1, turn_rate - off_2)


def beyond(gains: Gains, period: float, leader: LeaderMotion) -> tuple[str, ...]:
    """Returns that the leader reverses too often, or that small errors are not brought down, with the factor.

    With each reversal the heading that leads back turns about; how often is too often is measured. Near its leader a
    follower that heads along the field has x' = -k_x x + omega_r y, y' = (v_r kappa - omega_r) x - k_n |v_r| y in the
    leader's frame, with v_r kappa = omega_r unless it is slow.
    """
    speed = np.abs(leader.v_x)
    aside = leader.omega * np.minimum(1.0, speed / gains.least_speed) ** 2
    every = np.ones_like(speed)
    left = errors_left(period, leader, gains.k_x * every, 0 * every, gains.k_theta * every, gains.k_n * speed, aside)
    about = f"{OFTEN:g}/k_theta: the heading that leads back turns about with each reversal"
    return (
        *reverses(period, leader, gains.least_speed, OFTEN / gains.k_theta, about),
        *not_brought_down(left, period, leader, "its pull across the leader's path is k_n |v_0|"),
    )


def warnings(gains: Gains, limits: Limits) -> tuple[str, ...]:
    """Returns nothing: the source asks for positive gains only."""
    return ()
