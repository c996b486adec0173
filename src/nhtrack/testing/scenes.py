"""Followers and leaders over some control periods, for which laws are tried, and the same seen otherwise."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import product
from math import pi

import numpy as np

_PERIODS = 4


@dataclass(frozen=True)
class Walk:
    """Pairs of a follower and its leader, over some periods.

    Attributes:
        follower: as `nhtrack.laws.Follower`, shape (periods, k, 6).
        leader: as `nhtrack.laws.Leader`, shape (periods, k, 9).
    """

    follower: np.ndarray
    leader: np.ndarray

    def moved(self, x: float, y: float) -> Walk:
        """Returns it in another place of the world [m]."""
        return Walk(_added(self.follower, x, y), _added(self.leader, x, y))

    def rotated(self, angle: float) -> Walk:
        """Returns it turned about the world's origin [rad]."""
        return Walk(_turned(self.follower, angle), _turned(self.leader, angle))

    def wound(self, follower: int, leader: int) -> Walk:
        """Returns it with so many whole turns more behind the headings."""
        return Walk(_added(self.follower, 0, 0, 2 * pi * follower), _added(self.leader, 0, 0, 2 * pi * leader))

    def mirrored(self) -> Walk:
        """Returns it with left and right exchanged."""
        signs = np.array([1.0, -1.0, -1.0])
        return Walk(self.follower * np.tile(signs, 2), self.leader * np.tile(signs, 3))

    def scaled(self, length: float, time: float) -> Walk:
        """Returns it in units of which a metre has `length` and a second has `time`."""
        units = np.array([length, length, 1.0])
        pose, twist, u = units, units / time, units / time**2
        return Walk(self.follower * np.concatenate([pose, twist]), self.leader * np.concatenate([pose, twist, u]))


def _added(rows: np.ndarray, x: float, y: float, theta: float = 0.0) -> np.ndarray:
    found = rows.copy()
    found[..., :3] += [x, y, theta]
    return found


def _turned(rows: np.ndarray, angle: float) -> np.ndarray:
    found, c, s = rows.copy(), np.cos(angle), np.sin(angle)
    found[..., 0], found[..., 1] = c * rows[..., 0] - s * rows[..., 1], s * rows[..., 0] + c * rows[..., 1]
    found[..., 2] += angle
    return found


@cache
def plain_walk(pairs: int = 200) -> Walk:
    """Returns pairs anywhere, moving anyhow, one leader in five at rest; none is where a law changes its branch."""
    random = np.random.default_rng(20240229)
    follower = random.uniform(-1.0, 1.0, (pairs, 6)) * [5.0, 5.0, 3.0, 1.0, 0.0, 1.0]
    leader = random.uniform(-1.0, 1.0, (pairs, 9)) * [5.0, 5.0, 3.0, 1.0, 0.0, 1.0, 0.5, 0.0, 0.5]
    leader[::5, 3:] = 0.0
    return _walked(follower, leader)


@cache
def hard_walk() -> Walk:
    """Returns pairs that are hard: on each other, nearly so, at the antipode and whole turns from it, at rest."""
    places = ((0.0, 0.0), (1e-12, 0.0), (0.0, -1e-12), (0.3, 0.0), (0.0, 0.3), (-2.0, 1.0))
    angles = (0.0, 1e-300, 1e-12, -1e-12, pi / 2, pi, -pi, pi + 1e-9, -pi - 1e-9, pi + 0.3, 3 * pi, -40.0)
    twists = ((0.0, 0.0), (0.5, 0.0), (-0.5, 0.2), (0.0, 1.0))
    pairs = [
        ([x, y, theta, *own], [0.0, 0.0, 0.0, *others, *(0.5 * value for value in others)])
        for (x, y), theta, (v, omega) in product(places, angles, twists)
        for own, others in (
            ([v, 0.0, omega], [v, 0.0, omega]),
            ([0.0, 0.0, 0.0], [v, 0.0, omega]),
            ([v, 0.0, omega], [0.0, 0.0, 0.0]),
        )
    ]
    follower, leader = (np.array(rows) for rows in zip(*pairs, strict=True))
    return _walked(follower, leader)


def _walked(follower: np.ndarray, leader: np.ndarray, period: float = 0.01) -> Walk:
    """Returns pairs that go on with the velocities they have, roughly."""
    followers, leaders = [follower], [leader]
    for _ in range(_PERIODS - 1):
        followers.append(_after(followers[-1], period))
        leaders.append(_after(leaders[-1], period))
    return Walk(np.array(followers), np.array(leaders))


def _after(rows: np.ndarray, period: float) -> np.ndarray:
    found, c, s = rows.copy(), np.cos(rows[:, 2]), np.sin(rows[:, 2])
    found[:, 0] += period * (c * rows[:, 3] - s * rows[:, 4])
    found[:, 1] += period * (s * rows[:, 3] + c * rows[:, 4])
    found[:, 2] += period * rows[:, 5]
    return found
