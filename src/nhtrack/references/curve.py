"""A leader on a curve x(t), y(t) by formulas: heading and velocities follow from the derivatives.

With p = (x, y): v = +-|p'|, theta is the direction of p' or, backwards, its opposite, omega = p' x p'' / |p'|^2 (the
ideal robot is flat with output p; Fliess, Levine, Martin and Rouchon 1995). Where p' vanishes for an instant, as at a
cusp, p'' has the direction.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from nhtrack.references.contract import ReferenceInputError
from nhtrack.references.expression import Expression
from nhtrack.references.motion import Along, Motion

_ZERO = 1e-9  # of a derivative beside the next and the curve itself: below it, it is what rounding leaves of zero
_HALVINGS = 40  # of the time between two instants, where something jumps
_CORNER = math.radians(10)  # by which a heading may seem to turn at once
_LEAP = 0.02  # share of the greatest speed by which a velocity may seem to change at once


@dataclass(frozen=True)
class Curve:
    """A curve in time.

    Attributes:
        x: its first coordinate.
        y: its second.
    """

    x: Expression
    y: Expression

    def derivatives(self, t: np.ndarray) -> np.ndarray:
        """Returns p, p', p'', p''' at times, shape (T,) to (T, 2, 4)."""
        return _derivatives(self.x, self.y, np.ascontiguousarray(t, dtype=np.float64).tobytes())

    def motion(self) -> Motion:
        """Returns the motion along the curve, forwards at first."""
        return Motion(self.poses, self.speeds)

    def poses(self, t: np.ndarray) -> np.ndarray:
        """Returns x, y, theta at times that increase from 0 in steps in which it turns little, shape (T, 3).

        Raises:
            ReferenceInputError: it stands still at the first of them for longer than an instant.
        """
        p = self.derivatives(t)
        return np.concatenate([p[:, :, 0], self._headings(p, t)[:, None]], axis=1)

    def speeds(self, t: np.ndarray) -> np.ndarray:
        """Returns v, omega at such times, shape (T, 2); raises as `poses`."""
        p = self.derivatives(t)
        theta, zero = self._headings(p, t), _vanishing(p)
        v = p[:, 0, 1] * np.cos(theta) + p[:, 1, 1] * np.sin(theta)
        omega = np.zeros(len(t))
        # Where p' vanishes, p' = s p'' + s^2 p'''/2 around it: the direction turns by half of p'' x p''' / |p''|^2.
        for order, share in ((1, 1.0), (2, 0.5)):
            here = zero == order
            first, following = p[here, :, order], p[here, :, order + 1]
            with np.errstate(all="ignore"):  # told below
                cross = first[:, 0] * following[:, 1] - first[:, 1] * following[:, 0]
                omega[here] = share * cross / (first**2).sum(axis=-1)
        if (wild := np.flatnonzero(~np.isfinite(omega))).size:
            raise ReferenceInputError(f"the curve has no finite yaw rate at t = {t[wild[0]]:.6g}", t[wild[0]])
        return np.stack([v, omega], axis=-1)

    def _headings(self, p: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Returns headings from derivatives, continuous but for half turns, at which it drives the other way round."""
        zero = _vanishing(p)
        moving = np.flatnonzero(zero)
        if len(t) and (not len(moving) or moving[0] > 0):
            raise ReferenceInputError(
                f"the curve stands still at t = {t[0]:.6g}, so that its heading is not known there", t[0]
            )
        tangent = p[moving, :, zero[moving]]
        found = np.unwrap(np.arctan2(tangent[:, 1], tangent[:, 0]), period=math.pi)
        return np.asarray(found[np.maximum.accumulate(np.where(zero > 0, np.cumsum(zero > 0) - 1, 0))])

    def faults(self, t: np.ndarray) -> Iterator[str]:
        """Yields why no unicycle follows the curve at times, increasing from 0, shape (T,): jumps and corners.

        Raises:
            ReferenceInputError: no finite value at some time, or as `poses`.
        """
        poses, velocity = self.poses(t), self.derivatives(t)[:, :, 1]
        speed = np.hypot(*velocity.T)
        top = float(speed.max())
        step = np.hypot(*np.diff(poses[:, :2], axis=0).T)
        way = np.maximum(speed[1:], speed[:-1]) * np.diff(t)
        turn, change = abs(np.diff(poses[:, 2])), np.hypot(*np.diff(velocity, axis=0).T)
        checks = (
            (step > 2 * way + _ZERO * (1 + step), 0.5 * step, self._position, "it jumps by {:.3g}"),
            (change > 0.1 * top, np.full(step.shape, _LEAP * top), self._velocity, "its velocity jumps by {:.3g}"),
            (turn > _CORNER, np.full(step.shape, _CORNER), self._tangent, "its tangent turns by {:.3g} rad at rest"),
        )
        for suspicious, most, quantity, said in checks:
            for i in np.flatnonzero(suspicious).tolist():
                where, size = _jump(quantity, float(t[i]), float(t[i + 1]))
                if size > most[i]:
                    yield f"no robot follows the curve at t = {where:.6g}: {said.format(size)}"
                    return

    def _position(self, t: np.ndarray) -> np.ndarray:
        return np.asarray(self.derivatives(t)[:, :, 0])

    def _velocity(self, t: np.ndarray) -> np.ndarray:
        return np.asarray(self.derivatives(t)[:, :, 1])

    def _tangent(self, t: np.ndarray) -> np.ndarray:
        return self._headings(self.derivatives(t), t)[:, None]


@lru_cache(maxsize=4)  # poses, speeds and faults are asked at the same times
def _derivatives(x: Expression, y: Expression, times: bytes) -> np.ndarray:
    t = np.frombuffer(times)
    return np.stack([x.derivatives(t), y.derivatives(t)], axis=1)


def _vanishing(p: np.ndarray) -> np.ndarray:
    """Returns the order of the first derivative that is not zero, 0 where neither p' nor p'' is such, shape (T,)."""
    size = np.hypot(p[:, 0], p[:, 1])
    moves = size[:, 1] > _ZERO * (size[:, 0] + size[:, 2])
    bends = size[:, 2] > _ZERO * (size[:, 0] + size[:, 3])
    return np.where(moves, 1, np.where(bends, 2, 0))


def _jump(quantity: Along, low: float, high: float) -> tuple[float, float]:
    """Returns where between two times most of the change of a quantity is, and how much is left of it there."""
    size = 0.0
    for _ in range(_HALVINGS):
        ends = quantity(np.array([low, 0.5 * (low + high), high]))
        first, second = (float(np.hypot.reduce(change)) for change in np.diff(ends, axis=0))
        low, high = (low, 0.5 * (low + high)) if first > second else (0.5 * (low + high), high)
        size = max(first, second)
    return high, size
