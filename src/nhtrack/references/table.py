"""Samples as a signal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from nhtrack.references.contract import ReferenceInputError

Interpolation: TypeAlias = Literal["previous", "linear"]


@dataclass(frozen=True)
class Table:
    """Samples of a signal, held or joined by lines; constant before the first and after the last.

    Attributes:
        times: strictly increasing times, shape (n,).
        values: values at them, shape (n,).
        interpolation: `previous` holds each sample until the next, `linear` joins them.

    Raises:
        ReferenceInputError: no rows, times that do not increase, or a number that is not finite.
    """

    times: tuple[float, ...]
    values: tuple[float, ...]
    interpolation: Interpolation = "previous"

    def __post_init__(self) -> None:
        times, values = np.asarray(self.times), np.asarray(self.values)
        if times.size == 0 or times.shape != values.shape:
            raise ReferenceInputError(
                f"a table needs as many times as values, got {times.size} and {values.size}"
            )
        if not (np.isfinite(times).all() and np.isfinite(values).all()):
            raise ReferenceInputError("a table may hold finite numbers only")
        if times.size > 1 and (late := np.flatnonzero(np.diff(times) <= 0)).size:
            row = int(late[0])
            raise ReferenceInputError(
                f"the times of a table must increase, got {times[row]:g} before {times[row + 1]:g}"
            )

    def __call__(self, t: np.ndarray) -> np.ndarray:
        """Returns the values at the times `t`, both of shape (T,)."""
        times, values = np.asarray(self.times), np.asarray(self.values)
        if self.interpolation == "linear":
            return np.asarray(np.interp(t, times, values), dtype=np.float64)
        starts = times - 1e-12 * np.abs(
            times
        )  # as in `Segments`: an instant a rounding early counts as on time
        index = np.searchsorted(starts, t, side="right") - 1
        return np.asarray(values[np.clip(index, 0, None)], dtype=np.float64)
