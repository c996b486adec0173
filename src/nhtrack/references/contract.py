"""What a signal is, and what is wrong with one."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from nhtrack.errors import NhtrackError


class ReferenceInputError(NhtrackError):
    """An input that cannot be understood or has no finite value at some time.

    Attributes:
        t: the time it happened at, or None where the fault is in the text itself.
    """

    def __init__(self, message: str, t: float | None = None) -> None:
        self.t = t
        super().__init__(message)


class Signal(Protocol):
    """A scalar function of time, sampled on a grid."""

    def __call__(self, t: np.ndarray) -> np.ndarray:
        """Returns the values at the times `t`, both of shape (T,)."""
        ...
