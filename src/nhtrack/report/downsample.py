"""Fewer digits that look the same."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

_POWERS = np.array([float(10**power) for power in range(23)])  # of ten, exact


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
