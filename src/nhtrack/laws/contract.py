"""What a tracking law is: one file with `Gains`, `Memory`, `init` and `command`, scalar and of one follower.

    class Gains(NamedTuple):
        k_x: Annotated[float, Gain("1/T", "gain on the distance ahead", search=(6, 1000))] = 1.0

    class Memory(NamedTuple):
        turns: int
        last: tuple[float, float]

    def init(gains, period, follower, leader) -> Memory
    def command(gains, period, limits, follower, leader, memory) -> tuple[float, float, Memory]
    def warnings(gains, limits) -> tuple[str, ...]
    def beyond(gains, period, leader) -> tuple[str, ...]

`command` returns the accelerations (u_x [m/s^2], u_theta [rad/s^2]) that the follower takes for the coming control
period, and the memory for the next one. A law without memory leaves `Memory` and `init` out and is handed (), which it
returns. Both are pure; the loop compiles them and calls them for every follower. The other two may be left out. Before
a run `warnings` is asked what the gains break, and `beyond` what of the leader's motion the law is not known to follow;
its `leader` is a `LeaderMotion`.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import NamedTuple

import numpy as np


class Follower(NamedTuple):
    """The follower as its law sees it.

    Attributes:
        x: position in the world frame [m].
        y: position in the world frame [m].
        theta: heading, unwrapped [rad].
        v_x: forward velocity, body frame [m/s].
        v_y: lateral velocity, zero but for slip [m/s].
        omega: yaw rate [rad/s].
    """

    x: float
    y: float
    theta: float
    v_x: float
    v_y: float
    omega: float


class Leader(NamedTuple):
    """What a follower tracks during one control period.

    Attributes:
        x: position in the world frame [m].
        y: position in the world frame [m].
        theta: heading, unwrapped [rad].
        v_x: forward velocity, body frame [m/s].
        v_y: lateral velocity, zero but for slip and `exact` virtual leaders [m/s].
        omega: yaw rate [rad/s].
        u_x: forward acceleration commanded this period, before any saturation; of the root its input u0 [m/s^2].
        u_y: lateral acceleration, zero but for `exact` virtual leaders [m/s^2].
        u_theta: yaw acceleration commanded this period [rad/s^2].
    """

    x: float
    y: float
    theta: float
    v_x: float
    v_y: float
    omega: float
    u_x: float
    u_y: float
    u_theta: float


class LeaderMotion(NamedTuple):
    """How a leader is to move: what `Leader` has, at the beginning of each control period of a run, shape (k,) each."""

    x: np.ndarray
    y: np.ndarray
    theta: np.ndarray
    v_x: np.ndarray
    v_y: np.ndarray
    omega: np.ndarray
    u_x: np.ndarray
    u_y: np.ndarray
    u_theta: np.ndarray


class Limits(NamedTuple):
    """The robot's box of velocities and accelerations, infinite where a scenario sets none.

    Attributes:
        speed: largest |v| [m/s].
        yaw_rate: largest |omega| [rad/s].
        acceleration: largest |u_x| [m/s^2].
        yaw_acceleration: largest |u_theta| [rad/s^2].
    """

    speed: float = inf
    yaw_rate: float = inf
    acceleration: float = inf
    yaw_acceleration: float = inf


@dataclass(frozen=True)
class Gain:
    """What there is to know of a gain beside its default; stands in the `Annotated` of its field.

    Attributes:
        unit: its dimension in lengths L and times T, such as "1", "1/T", "1/T^2", "L", "L/T", "1/L^2", "1/(L*T)"; a
            scenario's similarity scales it by this. "m", "m/s" and "rad" are robot units, which do not scale.
        doc: what it is, one phrase.
        search: where `nhtrack tune` looks for it, low and high, in units of the run's duration (T) and of the
            experiment's size (L); None leaves it as it is.
        above: it must be larger.
        least: it must be at least this.
        below: it must be smaller.
        choices: names of its values 0, 1, ... for a gain that is a choice.
        section: name of the mapping in a scenario's law that the gain stands in, or "" for the law itself; its key
            there is the field's name without that prefix.
    """

    unit: str
    doc: str
    search: tuple[float, float] | None = None
    above: float | None = None
    least: float | None = None
    below: float | None = None
    choices: tuple[str, ...] = ()
    section: str = ""


def dimension(unit: str) -> tuple[int, int]:
    """Returns the powers of length and time of a unit such as "L/T^2", "1/(L*T)" or "m/s"."""
    above, _, below = unit.partition("/")
    found = {"L": 0, "T": 0}
    for texts, sign in ((above, 1), (below.strip("()"), -1)):
        for text in texts.split("*"):
            base, _, power = text.partition("^")
            letter = {"m": "L", "s": "T"}.get(base, base)
            if letter in found:
                found[letter] += sign * int(power or 1)
    return found["L"], found["T"]
