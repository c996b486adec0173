"""Normally distributed numbers for compiled code: functions of what they are drawn for, without a state.

Whoever draws the numbers of a simulation, of a robot, of a control period, in whatever order, draws the same.
"""

from __future__ import annotations

import math

import numpy as np

from nhtrack.compiled import compiled_inside

# SplitMix64 (Steele, Lea, Flood 2014): a counter's steps of the golden ratio, and Stafford's thirteenth mixer.
_STEP = np.uint64(0x9E3779B97F4A7C15)
_FIRST, _SECOND = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_30, _27, _31, _11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)


@compiled_inside
def stream(seed: np.uint64, robot: int, period: int) -> np.uint64:
    """Returns the stream of numbers of a robot in a control period of the simulation that has a seed."""
    return _next(_next(_next(seed, 0), robot), period)


@compiled_inside
def normal_pair(numbers: np.uint64, pair: int) -> tuple[float, float]:
    """Returns two independent standard normal numbers of a stream, by Box and Muller (1958)."""
    radius = math.sqrt(-2.0 * math.log(_share(_next(numbers, 2 * pair))))
    angle = 2.0 * math.pi * _share(_next(numbers, 2 * pair + 1))
    return radius * math.cos(angle), radius * math.sin(angle)


@compiled_inside
def _next(state: np.uint64, count: int) -> np.uint64:
    """Returns the whole number that SplitMix64 gives so many steps after the next."""
    z = state + _STEP * np.uint64(count + 1)
    z = (z ^ (z >> _30)) * _FIRST
    z = (z ^ (z >> _27)) * _SECOND
    return z ^ (z >> _31)


@compiled_inside
def _share(z: np.uint64) -> float:
    """Returns a number of (0, 1), one of 2^53 that are evenly spread."""
    return (float(z >> _11) + 0.5) / 9007199254740992.0
