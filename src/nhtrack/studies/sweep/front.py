"""Pareto fronts: runs that no other run beats in both of two metrics."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np
import pandas as pd

from nhtrack.arrays import Array


def pareto_rows(one: Array, other: Array) -> Array:
    """Returns the rows of the front of two metrics, the smaller the better, in ascending order of the first.

    A row is of the front if none is at least as good in both and better in one; of equal ones the first is. Rows with
    a value that is not known are of none.

    Args:
        one: the first metric, shape (n,).
        other: the second.
    """
    known = np.flatnonzero(np.isfinite(one) & np.isfinite(other))
    ordered = known[np.lexsort((other[known], one[known]))]
    return ordered[_falls(other[ordered])]


def all_fronts(table: pd.DataFrame, metrics: Sequence[str]) -> Iterator[tuple[tuple[str, str], Array]]:
    """Yields every pair of metrics and the rows of its front; each metric is put in order once, whatever the pairs."""
    values = {name: table[name].to_numpy(dtype=float) for name in metrics}
    orders = {name: np.argsort(values[name], kind="stable") for name in metrics}
    for one, other in combinations(metrics, 2):
        ordered = orders[one]
        few = ordered[_falls(np.where(np.isfinite(values[one]), values[other], np.nan)[ordered])]  # but for ties
        yield (one, other), few[pareto_rows(values[one][few], values[other][few])]


def _falls(values: Array) -> Array:
    """Returns which values are below all before them."""
    known = np.where(np.isfinite(values), values, np.inf)
    before = np.minimum.accumulate(np.concatenate([[np.inf], known[:-1]]))
    return np.asarray(known < before)
