"""Whether timed poses can be those of a unicycle: told of each row that no unicycle drives to from the one before."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from nhtrack.references.samples import RowFault

_SIDEWAYS = math.radians(30)  # between the way of a step and the headings at its ends
_TURN = math.radians(100)  # of a step; between rows farther apart than this the way in between is a guess
_JUMP = 8.0  # times the speed of the steps around and of most others
_SHORT = 0.02  # share of the root mean square step; below it, and below so many times the noise, a step is no way
_NOISES = 8.0


def pose_faults(t: np.ndarray, poses: np.ndarray) -> Iterator[RowFault]:
    """Yields row, column and message of steps that no unicycle drives.

    On a step of constant velocities a unicycle moves along the mean of its headings, forwards or backwards.

    Args:
        t: increasing times, shape (T,).
        poses: x, y, theta, shape (T, 3); theta may be wrapped.
    """
    way = np.diff(poses[:, :2], axis=0)
    length, period = np.hypot(*way.T), np.diff(t)
    turn = np.remainder(np.diff(poses[:, 2]) + np.pi, 2 * np.pi) - np.pi
    heading = poses[:-1, 2] + 0.5 * turn
    ahead = way[:, 0] * np.cos(heading) + way[:, 1] * np.sin(heading)
    aside = way[:, 1] * np.cos(heading) - way[:, 0] * np.sin(heading)
    jumps = _jumps(length / period)
    moving = length > max(_SHORT * float(np.sqrt(np.mean(length**2))), _NOISES * _noise(poses))
    slip = np.arctan2(np.abs(aside), np.abs(ahead))
    for i in range(len(length)):
        row = i + 1
        if jumps[i]:
            yield row, "x", f"a jump of {length[i]:.3g} in {period[i]:.3g}, far more than in the steps around it"
        elif abs(turn[i]) > _TURN:
            degrees = math.degrees(abs(turn[i]))
            yield row, "theta", f"turns by {degrees:.0f} degrees from the row before: a jump, or too few rows"
        elif moving[i] and slip[i] > _SIDEWAYS:
            degrees = math.degrees(slip[i])
            yield (
                row,
                "theta",
                f"drives at {degrees:.0f} degrees to its heading from the row before, {length[i]:.3g} far, as no robot "
                "with wheels of this kind does",
            )


def _noise(poses: np.ndarray) -> float:
    """Returns the standard deviation of what is random in each of x and y, from differences in which motion cancels."""
    third = np.diff(poses[:, :2], n=3, axis=0)  # of white noise, sqrt(20) times its deviation
    return float(np.median(abs(third))) / (0.6745 * math.sqrt(20)) if len(third) else 0.0


def _jumps(speed: np.ndarray) -> np.ndarray:
    """Returns which steps are far faster than those beside them and than most others, shape (T,)."""
    if len(speed) < 3 or not speed.any():
        return np.zeros(speed.shape, dtype=bool)
    usual = float(np.median(speed[speed > 0]))
    beside = np.maximum(np.append(speed[1:], speed[-2]), np.insert(speed[:-1], 0, speed[1]))
    return np.asarray(speed > _JUMP * np.maximum(beside, usual))
