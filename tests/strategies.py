"""What hypothesis draws from: the angles that break trigonometric code, and poses."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import strategies as st

PI = math.pi


def _ulps(value: float, count: int) -> float:
    """Returns the double `count` steps away from zero (negative: towards it)."""
    toward = math.copysign(math.inf, value) if count > 0 else 0.0
    for _ in range(abs(count)):
        value = math.nextafter(value, toward)
    return value


def log_uniform(low: float, high: float) -> st.SearchStrategy[float]:
    """Magnitudes spread evenly over the decades between two positive numbers."""
    powers = st.floats(math.log10(low), math.log10(high))
    return powers.map(lambda power: min(max(10.0**power, low), high))


def either_sign(magnitudes: st.SearchStrategy[float]) -> st.SearchStrategy[float]:
    return st.tuples(magnitudes, st.sampled_from([1.0, -1.0])).map(math.prod)


_near_pi = st.one_of(
    st.integers(-8, 8).map(lambda count: _ulps(PI, count)),
    either_sign(log_uniform(1e-12, 1e-3)).map(lambda offset: PI + offset),
)

branch_angles = st.one_of(st.just(0.0), either_sign(st.one_of(log_uniform(1e-300, PI), st.just(PI))))
"""Angles in [-pi, pi] over all 300 decades, zero and both ends."""

log_angles = st.one_of(branch_angles, either_sign(_near_pi), either_sign(st.floats(PI, 2 * PI - 1e-3)))
"""Angles for which log is defined, |theta| < 2 pi: the branch, both sides of +-pi, and beyond it."""

any_angles = st.one_of(log_angles, st.floats(-100.0, 100.0))
"""Unwrapped headings, whole turns included."""

lengths = st.one_of(st.just(0.0), either_sign(log_uniform(1e-12, 1e3)))
"""Positions [m] and speeds [m/s] of any size a robot meets."""


def triples(angles: st.SearchStrategy[float]) -> st.SearchStrategy[np.ndarray]:
    """Arrays (3,) of two lengths and one angle."""
    return st.tuples(lengths, lengths, angles).map(np.array)


poses = triples(any_angles)
