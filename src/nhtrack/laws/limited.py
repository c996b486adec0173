"""Motion limits of a robot in a law: how fast an error may be taken back, and accelerations that keep the limits."""

from __future__ import annotations

from math import copysign, isinf, sqrt

from nhtrack import planar
from nhtrack.compiled import compiled
from nhtrack.laws.contract import Limits

BRAKING = 0.5  # share of an acceleration limit that braking towards a place or a heading counts on
ROOM = 0.75  # share of the yaw rate limit that distance may ask for; the rest is left for the leader's own turning


@compiled
def return_rate(gain: float, acceleration: float, error: float) -> tuple[float, float]:
    """Returns the rate at which an error is taken back, one that the limit can brake from, and its slope.

        f(e) = gain e                                   where |e| <= e_0 = alpha/gain^2
        f(e) = sign(e) sqrt(2 alpha (|e| - e_0/2))      beyond

    Args:
        gain: 1/s.
        acceleration: twice alpha; infinite where there is no limit.
        error: e.
    """
    if isinf(acceleration):
        return gain * error, gain
    brake = BRAKING * acceleration
    size, linear = abs(error), brake / gain**2
    if size <= linear:
        return gain * error, gain
    rate = sqrt(2 * brake * (size - linear / 2))
    return copysign(rate, error), brake / rate


@compiled
def bounded(largest: float, rate: float, slope: float) -> tuple[float, float]:
    """Returns rate/sqrt(1 + (rate/largest)^2), which stays below `largest`, and its slope, from a rate and its own."""
    q_2 = 1 + (rate / largest) ** 2
    q = sqrt(q_2)
    return rate / q, slope / (q * q_2)


@compiled
def turn_rate_within(turn_rate: float, limits: Limits) -> float:
    """Returns the largest rate of turning to ask for [rad/s]: it leaves room, and braking takes half a radian at most.

        min(turn_rate, 0.75 yaw_rate, sqrt(0.5 yaw_acceleration))

    A rate that follows a leader to and fro and is asked for beyond that lags so far behind that it steers wrongly.
    """
    return min(turn_rate, ROOM * limits.yaw_rate, sqrt(BRAKING * limits.yaw_acceleration))


@compiled
def within(u: float, rate: float, gain: float, largest: float, acceleration: float) -> float:
    """Returns an acceleration that keeps |rate| <= largest and is itself at most `acceleration`.

    rate' <= gain (largest - rate), and alike below: the bound is approached exponentially and never crossed.
    """
    if not isinf(largest):
        u = planar.clip(u, -gain * (rate + largest), gain * (largest - rate))
    return planar.clip(u, -acceleration, acceleration)


def field_warnings(c: float, field_speed: float, limits: Limits) -> tuple[str, ...]:
    """Returns what limits leave no room for, of a field that adds so much speed and brakes at the rate c."""
    braking, why = c * field_speed, []
    if field_speed >= limits.speed:
        why.append(f"is not below the speed limit {limits.speed:.3g} m/s: nothing is left for the leader's own")
    if braking > limits.acceleration:
        why.append(
            f"brakes by c field_speed = {braking:.3g} m/s^2, above the acceleration limit {limits.acceleration:.3g} "
            "m/s^2: the follower cannot brake as the field asks"
        )
    room = min(limits.speed / 2 / field_speed, 0.99 * limits.acceleration / braking)
    return (f"field_speed = {field_speed:.3g} m/s {', and '.join(why)}; {room:.2g} times it would do",) if why else ()
