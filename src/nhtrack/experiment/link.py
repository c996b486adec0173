"""Between a robot and its law, compiled: commands that arrive late, noise, and a law that is asked ahead.

What a law commands in a period acts `delay` periods later; before that a follower keeps its velocities. A law that is
asked `ahead` periods ahead sees its follower as the commands under way will have moved it by then, on the ideal model,
and what it tracks as accelerations would that go on changing as they did since the last period. Where `ahead` is
`delay`, and the leader's accelerations are linear in time, that is where they will be. Where these jump by D, they are
taken to be `ahead` D too large for one period, which makes good in velocity what the delay has lost. Held accelerations
would be late by the delay instead, which is most of the error behind a leader that reverses every second.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from nhtrack.arrays import Array
from nhtrack.compiled import compiled_inside
from nhtrack.experiment.noise import normal_pair, stream
from nhtrack.simulation.integrator import advance, displacement
from nhtrack.simulation.motion import copy


@dataclass(frozen=True)
class Link:
    """What lies between robots and their laws.

    Attributes:
        delay: control periods by which commands arrive late.
        deviations: standard deviations of the noise on what a law sees of its own robot: x and y, each [m], heading
            [rad], forward velocity [m/s], yaw rate [rad/s].
        seeds: of the noise, one for all simulations or one for each, shape (1,) or (b,).
    """

    delay: int = 0
    deviations: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    seeds: Array = field(default_factory=lambda: np.zeros(1, dtype=np.uint64))


class Channel(NamedTuple):
    """The same for compiled code.

    Attributes:
        delay: see `Link`.
        ahead: control periods by which the law is asked ahead.
        noisy: whether there is any noise.
        deviations: see `Link`, shape (4,).
        seeds: see `Link`.
        dt: control period [s].
    """

    delay: int
    ahead: int
    noisy: bool
    deviations: np.ndarray
    seeds: np.ndarray
    dt: float


def make_channel(link: Link, ahead: int, dt: float) -> Channel:
    """Returns a link for compiled code, and for a law that is asked so many periods ahead."""
    deviations, seeds = np.array(link.deviations, dtype=float), np.ascontiguousarray(link.seeds, dtype=np.uint64)
    return Channel(link.delay, ahead, bool(deviations.any()), deviations, seeds, float(dt))


def make_commands(channel: Channel, simulations: int, robots: int) -> np.ndarray:
    """Returns the memory of commands, as if none had been given, shape (b, n, periods, 2)."""
    return np.zeros((simulations, robots, max(channel.delay, channel.ahead), 2))


@compiled_inside
def see_own(
    channel: Channel, commands: np.ndarray, b: int, robot: int, period: int, g: np.ndarray, xi: np.ndarray,
    before: np.ndarray, follower: np.ndarray, leader: np.ndarray,
) -> None:  # fmt: skip
    """Writes the follower as its law sees it, and moves both it and what it tracks ahead.

    Args:
        channel: between them.
        commands: of the robot, shape (periods, 2).
        b: which simulation.
        robot: which of its robots.
        period: since the start.
        g: pose of the robot, shape (3,).
        xi: its twist, shape (3,).
        before: what it tracked in the period before, as `nhtrack.laws.contract.Leader`.
        follower: written, as `nhtrack.laws.contract.Follower`.
        leader: as `nhtrack.laws.contract.Leader`; changed.
    """
    for c in range(3):
        follower[c] = g[c]
        follower[3 + c] = xi[c]
    if channel.noisy:
        _disturb(channel, b, robot, period, follower)
    if channel.ahead > 0:
        x, y, theta = 0.0, 0.0, 0.0
        if period > 0:
            x, y, theta = leader[6] - before[6], leader[7] - before[7], leader[8] - before[8]
        for k in range(period - channel.ahead, period):
            advance(follower[:3], follower[3:], commands[k % commands.shape[0]], channel.dt)
            drive_on(leader, channel.dt)
            leader[6] += x
            leader[7] += y
            leader[8] += theta


@compiled_inside
def pass_on(channel: Channel, commands: np.ndarray, period: int, asked: np.ndarray, u: np.ndarray) -> None:
    """Keeps what a law asks for in a period, (u_x, u_theta, ...), and writes what arrives in it, shape (2,)."""
    u[0], u[1] = asked[0], asked[1]
    if commands.shape[0] > 0:
        if channel.delay > 0:
            copy(u, commands[(period - channel.delay) % commands.shape[0]])
        kept = commands[period % commands.shape[0]]
        kept[0], kept[1] = asked[0], asked[1]


@compiled_inside
def _disturb(channel: Channel, b: int, robot: int, period: int, follower: np.ndarray) -> None:
    """Adds noise to what is seen of a follower."""
    numbers = stream(channel.seeds[b if channel.seeds.shape[0] > 1 else 0], robot, period)
    position, heading, speed, turning = channel.deviations
    x, y = normal_pair(numbers, 0)
    theta, v = normal_pair(numbers, 1)
    omega, _ = normal_pair(numbers, 2)
    follower[0] += position * x
    follower[1] += position * y
    follower[2] += heading * theta
    follower[3] += speed * v
    follower[5] += turning * omega


@compiled_inside
def drive_on(leader: np.ndarray, dt: float) -> None:
    """Moves what is tracked through a period at its accelerations; what is folded of several moves sideways, too.

    Args:
        leader: as `nhtrack.laws.contract.Leader`, shape (9,); its pose and velocities change.
        dt: control period [s].
    """
    heading, v_y, omega, u_y = leader[2], leader[4], leader[5], leader[7]
    advance(leader[:3], leader[3:6], leader[6::2], dt)
    if v_y != 0.0 or u_y != 0.0:
        aside, back = displacement(v_y, omega, u_y, leader[8], dt)
        leader[0] -= math.sin(heading) * aside + math.cos(heading) * back
        leader[1] += math.cos(heading) * aside - math.sin(heading) * back
        leader[4] = v_y + u_y * dt
