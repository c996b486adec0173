"""What of a leader's motion a law is not known to follow: what laws ask about it before a run."""

from __future__ import annotations

from math import ceil, inf, log2, pi, sqrt
from typing import NamedTuple

import numpy as np

from nhtrack.arrays import Array
from nhtrack.laws.contract import LeaderMotion, Limits
from nhtrack.settling import LATE

LEFT = 1e-3  # share of an error that is too much at the end: 10 m become 10 mm
_ORDER = 4  # of the series of exponentials
_ROUNDING = 1e-9  # of a bound


class OverLimit(NamedTuple):
    """A number of the leader's that is above a limit.

    Attributes:
        says: which number, when, above which limit, and how long.
        slower: how many times as long the motion would have to last to keep the limit.
    """

    says: str
    slower: float


def over_limits(limits: Limits, period: float, leader: LeaderMotion) -> tuple[OverLimit, ...]:
    """Returns what of a leader's motion is above the limits that its followers keep.

    Stretched in time by T, velocities fall by T and accelerations by T^2.
    """
    rows = (
        *_rates(limits, leader),
        ("|u_x0|", np.abs(leader.u_x), limits.acceleration, "acceleration", "m/s^2", 2),
        ("|u_theta0|", np.abs(leader.u_theta), limits.yaw_acceleration, "yaw acceleration", "rad/s^2", 2),
    )
    found = []
    for symbol, values, limit, name, unit, power in rows:
        above = values > (1 + _ROUNDING) * limit
        if above.any():
            at = int(values.argmax())
            found.append(
                OverLimit(
                    f"{symbol} = {values[at]:.3g} {unit} at {at * period:.3g} s is above the {name} limit "
                    f"{limit:.3g} {unit} of law.limits, as {100 * above.mean():.3g} % of the run are",
                    float(values[at] / limit) ** (1 / power),
                )
            )
    return tuple(found)


def close_to_limits(limits: Limits, leader: LeaderMotion, reserve: float) -> tuple[OverLimit, ...]:
    """Returns which rates of a leader leave less than a reserve below the limits, most of the time but not above them.

    What a follower is behind, up to a turn of its heading, it makes up with the difference alone.

    Args:
        limits: that its followers keep.
        leader: its motion.
        reserve: how many times a rate a limit is to be.
    """
    found = []
    for symbol, values, limit, name, unit, _ in _rates(limits, leader):
        most, usual = float(values.max(initial=0.0)), float(np.median(values)) if len(values) else 0.0
        if usual * reserve > (1 + _ROUNDING) * limit >= most:
            left = limit - usual
            found.append(
                OverLimit(
                    f"{symbol} is mostly {usual:.3g} {unit}, {100 * usual / limit:.3g} % of the {name} limit of "
                    f"law.limits: followers have {left:.2g} {unit} to catch up with",
                    most / limit,
                )
            )
    return tuple(found)


def _rates(limits: Limits, leader: LeaderMotion) -> tuple[tuple[str, Array, float, str, str, int], ...]:
    """Returns speed and yaw rate of a leader: symbol, values, limit, its name, unit, and power of the time scale."""
    return (
        ("|v_0|", np.hypot(leader.v_x, leader.v_y), limits.speed, "speed", "m/s", 1),
        ("|omega_0|", np.abs(leader.omega), limits.yaw_rate, "yaw rate", "rad/s", 1),
    )


def sampled_too_seldom(period: float, inner: float, outer: float) -> tuple[str, ...]:
    """Returns that a loop of two gains [1/s] is unstable if its commands are held for a period.

    On a double integrator u = -(inner + outer) rate - inner outer error has a pole below -1 if (inner + outer) period
    is above 2.
    """
    if (inner + outer) * period <= 2:
        return ()
    return (
        f"the control period {period:.3g} s is above 2/(k_inner + k_theta) = {2 / (inner + outer):.3g} s: headings do "
        "not settle",
    )


def turns_too_far(period: float, leader: LeaderMotion) -> tuple[str, ...]:
    """Returns that a leader turns by half a turn or more in a control period: which way, samples do not tell."""
    turned = period * np.abs(leader.omega)
    at = int(turned.argmax())
    if turned[at] < pi:
        return ()
    return (
        f"omega_0 = {leader.omega[at]:.3g} rad/s at {at * period:.3g} s is half a turn or more in a control period of "
        f"{period:.3g} s",
    )


def moves(period: float, leader: LeaderMotion) -> tuple[str, ...]:
    """Returns that a leader does not rest."""
    moving = (leader.v_x != 0) | (leader.v_y != 0) | (leader.omega != 0)
    if not moving.any():
        return ()
    return (f"the leader moves at {period * int(moving.argmax()):.3g} s: the law is for one at rest",)


def is_slow(period: float, leader: LeaderMotion, least: float, bound: str) -> tuple[str, ...]:
    """Returns that |v_0| is not above a bound [m/s], other than before the leader drives off."""
    slow = np.abs(leader.v_x) <= least
    off = 0 if slow.all() else int(slow.argmin())
    if not slow[off:].any():
        return ()
    when = period * (off + int(slow[off:].argmax()))
    return (f"|v_0| at {when:.3g} s is not above {least:.3g} m/s = {bound}",)


def reverses(period: float, leader: LeaderMotion, slow: float, sooner: float, bound: str) -> tuple[str, ...]:
    """Returns that v_0 changes its sign three times or more, each time sooner than some seconds after the last.

    Args:
        period: control period [s].
        leader: its motion.
        slow: speed up to which it counts as resting [m/s].
        sooner: how soon is too soon [s].
        bound: how that comes about, and what it means.
    """
    moving = np.flatnonzero(np.abs(leader.v_x) > slow)
    signs = np.sign(leader.v_x[moving])
    times = period * moving[1:][signs[1:] != signs[:-1]]
    between = np.diff(times)
    start, count = _longest(between < sooner)
    if count < 2:
        return ()
    mean = between[start : start + count].mean()
    often = f"v_0 changes its sign every {mean:.3g} s from {times[start]:.3g} s on"
    return (f"{often}, sooner than {sooner:.3g} s = {bound}",)


def turns(period: float, leader: LeaderMotion, for_so_long: float, most: float, bound: str) -> tuple[str, ...]:
    """Returns that |omega_0| stays above a bound [rad/s] for longer than some seconds."""
    rate = np.abs(leader.omega)
    start, count = _longest(rate > (1 + _ROUNDING) * most)
    if count * period <= for_so_long:
        return ()
    largest = rate[start : start + count].max()
    when = f"from {start * period:.3g} s to {(start + count) * period:.4g} s"
    return (f"|omega_0|, {largest:.3g} rad/s at most, is {when} above {most:.3g} rad/s = {bound}",)


def late_speed(leader: LeaderMotion) -> float:
    """Returns the largest speed of a leader in the late part of a run [m/s]."""
    speed = np.hypot(leader.v_x, leader.v_y)
    return float(speed[ceil((1 - LATE) * len(speed)) :].max(initial=0.0))


def accelerates(period: float, leader: LeaderMotion, over: float, most: float, bound: str) -> tuple[str, ...]:
    """Returns that the mean acceleration over some seconds, in the world, reaches a bound [m/s^2]."""
    steps = ceil(over / period)
    if len(leader.theta) <= steps:
        return ()
    velocity = (leader.v_x + 1j * leader.v_y) * np.exp(1j * leader.theta)
    gained = np.abs(velocity[steps:] - velocity[:-steps]) / (steps * period)
    at = int(gained.argmax())
    if gained[at] < most:
        return ()
    mean = f"its mean acceleration from {at * period:.3g} s to {(at + steps) * period:.3g} s, {gained[at]:.3g} m/s^2"
    return (f"{mean}, is not below {most:.3g} m/s^2 = {bound}: it need not be reached from afar",)


def starts_from_rest(
    period: float, leader: LeaderMotion, slow: float, rest: float, within: float, gained: float
) -> tuple[str, ...]:
    """Returns that a leader starts suddenly out of a rest, more than once.

    Args:
        period: control period [s].
        leader: its motion.
        slow: speed below which it counts as resting [m/s].
        rest: how long it rests at least [s].
        within: how soon after the rest it is fast [s].
        gained: how fast [m/s].
    """
    speed = np.hypot(leader.v_x, leader.v_y)
    edges = np.flatnonzero(np.diff((speed < slow).astype(np.int8), prepend=0))
    soon = ceil(within / period)
    starts = [
        end * period
        for begin, end in zip(edges[::2], edges[1::2], strict=False)
        if (end - begin) * period >= rest and speed[end : end + soon].max() >= gained
    ]
    if len(starts) < 2:
        return ()
    sudden = f"from rest to {gained:.3g} m/s within {within:.3g} s"
    when = f"{len(starts)} times, at {starts[0]:.3g} s first"
    return (f"it starts {sudden}, {when}: it need not be followed closely then",)


def _longest(held: np.ndarray) -> tuple[int, int]:
    """Returns where the longest stretch of truths begins, and how many there are in it."""
    edges = np.flatnonzero(np.diff(held.astype(np.int8), prepend=0, append=0))
    if len(edges) == 0:
        return 0, 0
    starts, lengths = edges[::2], np.diff(edges)[::2]
    at = int(lengths.argmax())
    return int(starts[at]), int(lengths[at])


def errors_left(
    period: float,
    leader: LeaderMotion,
    ahead: np.ndarray,
    steering: np.ndarray,
    turning: np.ndarray,
    across: np.ndarray | float = 0.0,
    aside: np.ndarray | float = 0.0,
) -> float:
    """Returns by what a run multiplies a small error of place, or of heading, whichever is left more of.

    To first order, and with the velocities that are commanded, a follower's errors p (of place, in the world) and
    theta behind a leader with the axes e (along) and n (across) obey

        p' = -ahead e <e, p> + (aside <e, p> - across <n, p> + v_0 theta) n,
        theta' = -turning theta - steering <n, p>.

    Args:
        period: control period [s].
        leader: its motion.
        ahead: gain on errors along the leader's heading [1/s], shape (k,), and so the others.
        steering: on errors across it [rad/(m s)].
        turning: on the heading [1/s].
        across: on errors across the leader's heading, where theta is that from a heading which leads back [1/s].
        aside: how fast an error along it becomes one across [1/s].
    """
    blocks = ceil(sqrt(len(ahead)))
    rows = ceil(len(ahead) / blocks)
    rates = np.zeros((blocks * rows, 3, 3))
    c, s, v = np.cos(leader.theta), np.sin(leader.theta), leader.v_x
    columns = (
        (-ahead * c * c - across * s * s - aside * s * c, (across - ahead) * c * s - aside * s * s, -s * v),
        ((across - ahead) * c * s + aside * c * c, -ahead * s * s - across * c * c + aside * c * s, c * v),
        (steering * s, -steering * c, -turning),
    )
    for i, line in enumerate(columns):
        for j, column in enumerate(line):
            rates[: len(ahead), i, j] = period * column
    halvings = max(0, ceil(log2(1e-9 + 2 * np.abs(rates).max())))
    in_blocks = rates.reshape(blocks, rows, 3, 3) / 2**halvings
    whole = np.eye(3)
    with np.errstate(over="ignore", invalid="ignore"):  # errors that grow without bound
        passed = np.broadcast_to(np.eye(3), (blocks, 3, 3))
        for row in range(rows):
            passed = _exponential(in_blocks[:, row], halvings) @ passed
        for block in passed:
            whole = block @ whole
    if not np.isfinite(whole).all():
        return inf
    return max(float(np.linalg.norm(whole[:2, :2], 2)), abs(float(whole[2, 2])))


def _exponential(rates: np.ndarray, halvings: int) -> np.ndarray:
    """Returns the exponentials of matrices that have been halved so many times, shape (..., 3, 3)."""
    term = whole = np.broadcast_to(np.eye(3), rates.shape)
    for order in range(1, _ORDER + 1):
        term = rates @ term / order
        whole = whole + term
    for _ in range(halvings):
        whole = whole @ whole
    return whole


def not_brought_down(left: float, period: float, leader: LeaderMotion, reason: str) -> tuple[str, ...]:
    """Returns that too much is left of errors at the end of a run, in a sentence, or nothing."""
    if left <= LEFT:
        return ()
    run = period * len(leader.theta)
    return (f"the {run:.4g} s of the run multiply small errors by {left:.2g}, to first order: {reason}",)


