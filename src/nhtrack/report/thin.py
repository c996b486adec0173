"""Fewer numbers that look the same: rows that keep extremes, values to so many digits."""

from __future__ import annotations

from typing import Any

import numpy as np


def even_rows(count: int, most: int) -> np.ndarray:
    """Returns at most `most` rows of `count`, evenly spread, the first and the last among them."""
    if count <= most:
        return np.arange(count)
    return np.unique(np.linspace(0, count - 1, most).round().astype(np.intp))


def extreme_rows(values: np.ndarray, most: int) -> np.ndarray:
    """Returns the rows in which curves have the extremes of their stretch, so that no peak is lost.

    The rows are cut into stretches of equal length; of each, every curve's smallest and largest value stay, and so do
    the first row, the last row and the rows where values begin or cease to be known.

    Args:
        values: one column a curve, shape (t, k); NaN where a value is not known.
        most: rows to stay below, apart from where values begin or cease to be known.

    Returns:
        Rows in ascending order, all of them where there are no more than `most`.
    """
    count, curves = values.shape
    if count <= most:
        return np.arange(count)
    stretches = max(1, (most - 2) // (2 * curves))
    kept = [0, count - 1]
    for rows in np.array_split(np.arange(count), stretches):
        part = values[rows]
        kept += (rows[0] + np.where(np.isnan(part), np.inf, part).argmin(axis=0)).tolist()
        kept += (rows[0] + np.where(np.isnan(part), -np.inf, part).argmax(axis=0)).tolist()
    turns = np.flatnonzero(np.diff(np.isnan(values).any(axis=1)))
    return np.unique(np.concatenate([kept, turns, turns + 1])).astype(np.intp)


def numbers(values: np.ndarray, digits: int) -> Any:
    """Returns an array as nested lists of so many significant digits; None for what JSON has no number for."""
    if values.ndim > 1:
        return [numbers(row, digits) for row in values]
    return [float(f"{value:.{digits}g}") if np.isfinite(value) else None for value in values.tolist()]
