"""While a condition holds: its unbroken spells among the rows of a recording, and means over the time before each row.

A row stands for the control period, or the time since the row before, that ends at its time.
"""

from __future__ import annotations

import numpy as np

__all__ = ["GAP", "averaged", "begins", "joined_spells", "lasting", "spells"]

# [s] Spells closer together than this are one event: no figure shows such a break, and no robot recovers within it.
GAP = 0.1

_ROUNDING = 1e-9  # [s] of times that are sums of periods


def lasting(holds: np.ndarray, time: np.ndarray, shortest: float, sure: np.ndarray | None = None) -> np.ndarray:
    """Returns `holds` without its spells shorter than `shortest` [s], all of shape (t,); one that is sure stays."""
    first, last = spells(holds)
    short = time[last] - begins(time)[first] < shortest - _ROUNDING
    kept = holds.copy()
    for start, end in zip(first[short], last[short], strict=True):
        kept[start : end + 1] = sure is not None and sure[start : end + 1].any()
    return kept


def joined_spells(holds: np.ndarray, time: np.ndarray) -> list[slice]:
    """Returns the rows of each event: of the spells of `holds`, those less than `GAP` apart joined."""
    first, last = spells(holds)
    if not len(first):
        return []
    apart = begins(time)[first[1:]] - time[last[:-1]] >= GAP - _ROUNDING
    starts, ends = first[np.append(True, apart)], last[np.append(apart, True)]
    return [slice(int(start), int(end) + 1) for start, end in zip(starts, ends, strict=True)]


def spells(holds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns the first and the last row of every unbroken spell in which a condition holds, shape (t,)."""
    edges = np.flatnonzero(np.diff(holds, prepend=False, append=False))
    return edges[::2], edges[1::2] - 1


def begins(time: np.ndarray) -> np.ndarray:
    """Returns when the period of each row begins [s]: the first row stands for an instant."""
    return np.append(time[:1], time[:-1])


def averaged(values: np.ndarray, time: np.ndarray, span: float) -> np.ndarray:
    """Returns the means of values over the time `span` [s] that ends at each row, shape (t, ...); NaN do not count.

    Rows less than `span` after the first one have the mean over the first `span`.
    """
    known = np.isfinite(values)
    sums, counts = (np.cumsum(np.concatenate([np.zeros_like(x[:1]), x]), axis=0) for x in _parts(values, known))
    whole = min(int(np.searchsorted(time, time[0] + span - _ROUNDING)), len(time) - 1)
    last = np.maximum(np.arange(len(time)), whole)
    first = np.minimum(np.searchsorted(time, time[last] - span + _ROUNDING), last)  # rows far apart are their own means
    with np.errstate(invalid="ignore"):
        return np.asarray((sums[last + 1] - sums[first]) / (counts[last + 1] - counts[first]))


def _parts(values: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns values with zero for what is not known, and one for each that is."""
    return np.where(known, values, 0.0), known.astype(float)
