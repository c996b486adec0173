"""Axes on which a short peak does not flatten the rest: linear near zero, logarithmic beyond.

What is drawn over time often has a peak a hundred times as high as everything after it, as the first command of a law
that begins far from its leader. Figures and pages bend the axes of such panels, in one way: b(v) = v/c up to a knee c,
and sign(v) (1 + log10 |v/c|) beyond, so that a decade is as long as the way from zero to the knee.
"""

from __future__ import annotations

import math

import numpy as np

from nhtrack.arrays import Array

_DWARFED = 8.0  # peak over what is seldom exceeded, from which an axis is bent
_SELDOM = 0.95  # share of the time in which that is not exceeded
_DECADES = 3  # of the logarithmic part, at most: what is smaller is next to nothing beside the peak
_ROUND = (1.0, 2.0, 5.0, 10.0)


def knee_of(values: Array) -> float | None:
    """Returns where an axis bends, a round number of the values' unit; None where a straight one shows them well.

    Args:
        values: of all curves, shape (t, n), evenly spread in time; what is not finite is not known.
    """
    sizes = np.where(np.isfinite(values), np.abs(values), 0.0).max(axis=1, initial=0.0)
    peak = float(sizes.max(initial=0.0))
    usual = float(np.quantile(sizes, _SELDOM)) if sizes.size else 0.0
    if peak <= _DWARFED * usual or peak == 0.0:
        return None
    least = max(usual, peak / 10**_DECADES)
    power = 10.0 ** math.floor(math.log10(least))
    return next(step * power for step in _ROUND if step * power >= least * (1 - 1e-9))


def bent(values: Array, knee: float) -> Array:
    """Returns where values stand on an axis with a knee, see above; shape as given."""
    sizes = np.abs(np.asarray(values, dtype=float)) / knee
    beyond = 1.0 + np.log10(np.maximum(sizes, 1.0))
    return np.asarray(np.sign(values) * np.where(sizes <= 1.0, sizes, beyond))


def straightened(places: Array, knee: float) -> Array:
    """Returns the values that stand at places of an axis with a knee: the inverse of `bent`."""
    sizes = np.abs(np.asarray(places, dtype=float))
    values = np.where(sizes <= 1.0, sizes, 10.0 ** np.minimum(sizes - 1.0, 300.0))
    return np.asarray(np.sign(places) * knee * values)


def bent_ticks(low: float, high: float, knee: float) -> list[float]:
    """Returns the numbers to write at an axis with a knee, within its ends: zero, the knee, powers of ten beyond.

    Where no power of ten lies beyond, it is a round number, so that nobody takes the axis for a straight one.
    """
    size = max(abs(low), abs(high))
    first = math.floor(math.log10(2.0 * knee)) + 1
    powers = [10.0**power for power in range(first, math.floor(math.log10(max(size, knee)) + 1e-9) + 1)]
    last = 10.0 ** math.floor(math.log10(max(size, knee)))
    sizes = [knee, *(powers or [max(step * last for step in _ROUND if step * last <= max(size, last))])]
    return [value for value in (*(-s for s in reversed(sizes)), 0.0, *sizes) if low <= value <= high]
