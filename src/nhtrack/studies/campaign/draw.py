"""Random starts and random references of a campaign; the first k of many are the same as the k of few."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import ceil, exp, pi, sqrt
from typing import NamedTuple

import numpy as np

from nhtrack.arrays import Array
from nhtrack.config.campaign import Starts
from nhtrack.config.families import RANDOM, RANDOM_WALK

_KINDS = 5  # of special starts
_RAMP, _HOLD = (1.0, 6.0), (0.0, 8.0)  # how long pieces take to reach their twist, and keep it [scenario time]
_SPEED, _TURNING = 1.5, 1.0  # largest twist of a piece [scenario length/time], [rad/scenario time]
_STOPS, _STRAIGHTS = 0.25, 0.3  # shares of pieces that end at rest, and without turning
_STEP, _MEMORY = 0.5, 4.0  # of random walks: pieces, and how long a velocity is remembered [scenario time]
_WALK = np.array([0.6, 0.5])  # root mean squares of their velocities [scenario length/time], [rad/scenario time]
_PACE = np.array([1.0, 1.0])  # their largest accelerations [scenario length/time^2], [rad/scenario time^2]
_STREAMS = {"starts": 0, "pieces": 1, "walks": 2}


class Draw(NamedTuple):
    """Starts of followers in scenario units.

    Attributes:
        pose: (x, y, theta), shape (b, 3).
        twist: (v, omega), shape (b, 2).
    """

    pose: Array
    twist: Array


def draw_starts(starts: Starts) -> Draw:
    """Returns the starts of a campaign: uniform in the disc, in heading and in both velocities.

    Every so many a start is special, in turn: on the leader; headed opposite to it (pi and -pi are different starts);
    on its axis; on the leader, turned round; on its axis and turned round. Every other special start is at rest.
    """
    uniform = _generator(starts.seed, "starts").uniform(size=(starts.count, 5))
    radius, bearing = starts.radius * np.sqrt(uniform[:, 0]), _spread(uniform[:, 1], pi)
    pose = np.stack([radius * np.cos(bearing), radius * np.sin(bearing), _spread(uniform[:, 2], pi)], axis=-1)
    twist = np.stack([_spread(uniform[:, 3], starts.speed), _spread(uniform[:, 4], starts.turning)], axis=-1)
    if starts.special:
        _make_special(pose, twist, max(_KINDS, round(_KINDS / starts.special)))
    return Draw(pose, twist)


def _make_special(pose: Array, twist: Array, spacing: int) -> None:
    """Makes the first five of every `spacing` starts special, in place."""
    index = np.arange(len(pose))
    kind, turn = index % spacing, index // spacing
    pose[np.isin(kind, (0, 3)), :2] = 0.0
    pose[np.isin(kind, (2, 4)), 1] = 0.0
    opposite = np.isin(kind, (1, 3, 4))
    pose[opposite, 2] = np.where(turn % 2, -pi, pi)[opposite]
    twist[(kind < _KINDS) & (turn % 4 >= 2)] = 0.0


@dataclass(frozen=True)
class Pieces:
    """References of constant accelerations, piece after piece, another for each start.

    Attributes:
        ends: of the pieces, in control periods, increasing, shape (b, k).
        values: (u_x, u_theta) of each, in scenario units, shape (b, k, 2).
    """

    ends: Array
    values: Array

    def sample(self, periods: int, rows: slice) -> Array:
        """Returns the accelerations of the chosen references in each period, shape (periods, b, 2)."""
        ends, values = self.ends[rows], self.values[rows]
        passed = np.zeros((periods, len(ends)), dtype=np.intp)
        row, piece = np.nonzero(ends < periods)
        np.add.at(passed, (ends[row, piece], row), 1)
        return np.asarray(values[np.arange(len(ends)), passed.cumsum(axis=0)])


def draw_pieces(starts: Starts, duration: float, period: float) -> Pieces:
    """Returns random references that outlast a run.

    Over 1 to 6 s each goes to a random twist, |v| <= 1.5 and |omega| <= 1, a quarter of them to v = 0 and three tenths
    to omega = 0, and keeps it for up to 8 s. Pieces end with control periods, so that a leader that brakes stands.

    Args:
        starts: how many, and their seed.
        duration: of a run [scenario time].
        period: control period [scenario time].
    """
    count = ceil(duration / _RAMP[0]) + 1
    uniform = _generator(starts.seed, "pieces").uniform(size=(starts.count, count, 6))
    v, omega = _spread(uniform[..., 0], _SPEED), _spread(uniform[..., 1], _TURNING)
    v, omega = np.where(uniform[..., 2] < _STOPS, 0, v), np.where(uniform[..., 3] < _STRAIGHTS, 0, omega)
    ramp, hold = (_periods(uniform[..., 4 + i], bounds, period) for i, bounds in enumerate((_RAMP, _HOLD)))
    gained = np.diff(np.stack([v, omega], axis=-1), axis=1, prepend=0.0)
    values = np.zeros((starts.count, 2 * count, 2))
    values[:, ::2] = gained / (ramp * period)[..., None]
    lengths = np.stack([ramp, hold], axis=-1).reshape(starts.count, -1)
    return Pieces(lengths.cumsum(axis=1), values)


def draw_walks(starts: Starts, duration: float, period: float) -> Pieces:
    """Returns random walks of both velocities that outlast a run; arguments as `draw_pieces`.

    Every half second each velocity heads for what an Ornstein-Uhlenbeck process from rest makes of it, of root mean
    square 0.6 and 0.5 and a memory of 4 s, but with no more than unit acceleration.
    """
    step = max(1, round(_STEP / period))
    count, kept = ceil(duration / (step * period)) + 1, exp(-step * period / _MEMORY)
    kicks = _generator(starts.seed, "walks").normal(size=(starts.count, count, 2)) * _WALK * sqrt(1 - kept**2)
    most, twist = _PACE * step * period, np.zeros((starts.count, 2))
    gained = np.empty_like(kicks)
    for k in range(count):
        gained[:, k] = np.clip(kicks[:, k] - (1 - kept) * twist, -most, most)
        twist += gained[:, k]
    ends = np.broadcast_to(step * np.arange(1, count + 1), (starts.count, count))
    return Pieces(ends, gained / (step * period))


REFERENCES: Mapping[str, Callable[[Starts, float, float], Pieces]] = {RANDOM: draw_pieces, RANDOM_WALK: draw_walks}


def _periods(uniform: Array, bounds: tuple[float, float], period: float) -> Array:
    """Returns random lengths within bounds as whole numbers of control periods, at least one."""
    low, high = bounds
    return np.maximum(1, np.rint((low + (high - low) * uniform) / period)).astype(np.intp)


def _spread(uniform: Array, largest: float) -> Array:
    """Returns numbers of [0, 1) spread over [-largest, largest)."""
    return largest * (2 * uniform - 1)


def _generator(seed: int, stream: str) -> np.random.Generator:
    return np.random.default_rng([seed, _STREAMS[stream]])
