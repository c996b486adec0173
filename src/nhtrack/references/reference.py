"""The root's input u0(t): a pair of signals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nhtrack.references.contract import Signal
from nhtrack.references.table import Interpolation, Table


@dataclass(frozen=True)
class Reference:
    """The root's commanded accelerations over time.

    Attributes:
        u_x: forward acceleration [length/time^2].
        u_theta: angular acceleration [rad/time^2].
    """

    u_x: Signal
    u_theta: Signal

    def sample(self, t: np.ndarray) -> np.ndarray:
        """Returns (u_x, u_theta) at the times `t` of shape (T,), shape (T, 2).

        Raises:
            ReferenceInputError: no finite value at some time.
        """
        times = np.asarray(t, dtype=np.float64)
        return np.stack([self.u_x(times), self.u_theta(times)], axis=-1)

    @classmethod
    def from_table(
        cls,
        t: Sequence[float],
        u_x: Sequence[float],
        u_theta: Sequence[float],
        interpolation: Interpolation = "previous",
    ) -> Reference:
        """Returns the reference of sampled accelerations, all three of length n."""
        times = tuple(t)
        return cls(Table(times, tuple(u_x), interpolation), Table(times, tuple(u_theta), interpolation))
