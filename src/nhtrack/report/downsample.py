"""Fewer numbers that look the same: rows that keep extremes, values to so many digits."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

_POWERS = np.array([float(10**power) for power in range(23)])  # of ten, exact


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
    return _plain(_rounded(np.asarray(values, dtype=float), digits))


def _plain(values: np.ndarray) -> Any:
    if np.isfinite(values).all():
        return values.tolist()
    if values.ndim > 1:
        return [_plain(row) for row in values]
    return [value if math.isfinite(value) else None for value in values.tolist()]


def _rounded(values: np.ndarray, digits: int) -> np.ndarray:
    """Returns the numbers nearest to decimals of so many digits, which JSON writes with no more of them.

    A whole number over a power of ten is such a number as long as both are exact; the few beyond are written and read.
    """
    known = np.isfinite(values) & (values != 0)
    exponents = digits - 1 - np.floor(np.log10(np.abs(values), out=np.zeros(values.shape), where=known)).astype(int)
    most = len(_POWERS) - 1
    up, down = _POWERS[np.clip(exponents, 0, most)], _POWERS[np.clip(-exponents, 0, most)]
    rounded = np.rint(values * up / down) / up * down  # one of the powers is 1
    for place in zip(*np.nonzero(known & (np.abs(exponents) > most)), strict=True):
        rounded[place] = float(f"{values[place]:.{digits}g}")
    return np.asarray(rounded)
