"""A smooth line through waypoints, and how fast it can be driven within limits.

The line is a cubic spline over the lengths of the chords, of continuous curvature. At each of its places the speed is
the largest that speed, yaw rate and lateral acceleration allow, that can be reached from the beginning by speeding up,
and from which the rest can be met by braking: a pass forwards and one backwards find it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.integrate import cumulative_simpson
from scipy.interpolate import CubicSpline

from nhtrack.references.motion import Motion

_CELLS = 200  # between two waypoints
_SHARP = 0.2  # turned from one of these cells to the next: as good as on the spot [rad]


@dataclass(frozen=True)
class Bounds:
    """What a leader keeps to along a line; infinite where it need not.

    Attributes:
        speed: [length/time].
        acceleration: forward [length/time^2].
        lateral: v^2 kappa [length/time^2].
        yaw_rate: v kappa [rad/time].
    """

    speed: float
    acceleration: float
    lateral: float = math.inf
    yaw_rate: float = math.inf


@dataclass(frozen=True)
class Route:
    """A line by its length.

    Attributes:
        length: from its beginning, shape (n,).
        poses: x, y, theta unwrapped, at these lengths, shape (n, 3).
        curvature: there, infinite where it turns as good as on the spot, shape (n,).
    """

    length: np.ndarray
    poses: np.ndarray
    curvature: np.ndarray

    @classmethod
    def through(cls, points: np.ndarray, closed: bool) -> Route:
        """Returns the smooth line through points of shape (n, 2), each other than the one before it."""
        points = np.concatenate([points, points[:1]]) if closed else points
        knots = np.insert(np.cumsum(np.hypot(*np.diff(points, axis=0).T)), 0, 0.0)
        line = CubicSpline(knots, points, bc_type="periodic" if closed else "natural")
        cells = [np.linspace(*ends, _CELLS, endpoint=False) for ends in pairwise(knots)]
        at = np.append(np.concatenate(cells), knots[-1])
        first, second = line(at, 1), line(at, 2)
        rate = np.hypot(*first.T)
        theta = np.unwrap(np.arctan2(first[:, 1], first[:, 0]))
        sharp = np.append(abs(np.diff(theta)), 0.0) > _SHARP
        bend = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
        curvature = np.where(sharp, math.inf, bend / np.where(sharp, 1.0, rate) ** 3)
        length = cumulative_simpson(rate, x=at, initial=0)
        return cls(length, np.concatenate([line(at), theta[:, None]], axis=1), curvature)

    def sharpest(self) -> tuple[float, int]:
        """Returns the largest curvature, and which waypoint is nearest to it, counted from 0."""
        where = int(np.argmax(abs(self.curvature)))
        return float(abs(self.curvature[where])), round(where / _CELLS)

    def times(self, laps: int) -> Route:
        """Returns a closed line gone round so many times."""
        lap, turned = self.length[-1], self.poses[-1, 2] - self.poses[0, 2]
        numbers = np.repeat(np.arange(laps), len(self.length) - 1)
        length = np.tile(self.length[1:], laps) + numbers * lap
        poses = np.tile(self.poses[1:], (laps, 1)) + np.outer(numbers, [0.0, 0.0, turned])
        return Route(
            np.insert(length, 0, self.length[0]),
            np.concatenate([self.poses[:1], poses]),
            np.insert(np.tile(self.curvature[1:], laps), 0, self.curvature[0]),
        )

    def speeds(self, bounds: Bounds) -> np.ndarray:
        """Returns the largest speeds within bounds, from rest to rest, shape (n,)."""
        bend = np.maximum(abs(self.curvature), 1e-300)
        most = np.minimum(bounds.speed, np.minimum(bounds.yaw_rate / bend, np.sqrt(bounds.lateral / bend)))
        squares = (most**2).tolist()
        squares[0] = squares[-1] = 0.0
        gains = (2 * bounds.acceleration * np.diff(self.length)).tolist()
        for i, gain in enumerate(gains):
            squares[i + 1] = min(squares[i + 1], squares[i] + gain)
        for i in range(len(gains) - 1, -1, -1):
            squares[i] = min(squares[i], squares[i + 1] + gains[i])
        return np.asarray(np.sqrt(squares))

    def motion(self, bounds: Bounds) -> Motion:
        """Returns the motion along the line, as fast as bounds allow, from rest to rest."""
        v, step = self.speeds(bounds), np.diff(self.length)
        t = np.insert(np.cumsum(2 * step / (v[1:] + v[:-1])), 0, 0.0)
        gain = np.diff(v**2) / (2 * step)
        line = CubicSpline(self.length, np.concatenate([self.poses, self.curvature[:, None]], axis=1))
        end = float(t[-1])

        def along(times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            now = np.minimum(times, end)
            cell = np.clip(np.searchsorted(t, now, side="right") - 1, 0, len(step) - 1)
            since = now - t[cell]
            return self.length[cell] + since * (v[cell] + 0.5 * gain[cell] * since), v[cell] + gain[cell] * since

        def speeds(times: np.ndarray) -> np.ndarray:
            length, speed = along(times)
            return np.stack([speed, speed * line(length)[:, 3]], axis=-1)

        return Motion(lambda times: np.asarray(line(along(times)[0])[:, :3]), speeds, end)
