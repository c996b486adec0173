"""Figures of many runs at once, taken while they run, so that no row has to be kept."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from nhtrack.compiled import compiled_inside, compiled_loop
from nhtrack.experiment.recorder import Shape, Streaming
from nhtrack.experiment.rows import BARE, COLUMNS, Rows
from nhtrack.settling import SettlingLimits, is_near_compiled
from nhtrack.simulation import columns

FOLLOWER = 1  # its place behind the leader
_ERROR, _INPUT = COLUMNS["error"].start, COLUMNS["input"].start
_SPEED, _SATURATION, _UTILISATION = (
    BARE + columns.COLUMNS[name].start for name in ("wheel_speed", "torque_saturation", "friction_utilisation")
)


class Statistics(NamedTuple):
    """Figures of b runs.

    Attributes:
        position: largest late distance [m], shape (b,).
        heading: largest late heading error [rad], shape (b,).
        settled: first row from which on errors are within the limits, see `settling_rows`, shape (b,).
        utilisation: largest friction utilisation, shape (b,).
        saturated: sum over periods of the share in which a motor was at its limit, shape (b,).
        effort: sum of squared accelerations, shape (b, 2).
        switches: control periods in which a mode of the law changed, one or several, shape (b,).
        modes: they in the last row, shape (b, modes).
    """

    position: np.ndarray
    heading: np.ndarray
    settled: np.ndarray
    utilisation: np.ndarray
    saturated: np.ndarray
    effort: np.ndarray
    switches: np.ndarray
    modes: np.ndarray


class RunStatistics(Streaming):
    """Takes the figures of b runs of a leader and a follower; a recorder that keeps no row.

    A run that is lost counts up to the row before it was: what is lost has no telemetry.

    Args:
        limits: within which a follower has settled.
        late: control period from which on errors are late errors.
        modes: places in the law's memory that count as its modes.
    """

    def __init__(self, limits: SettlingLimits, late: int, modes: tuple[int, ...]) -> None:
        self._limits, self.late, self._modes = limits, late, np.array(modes, dtype=np.int64)

    def begin(self, shape: Shape) -> None:
        """Sets all figures to those of no run."""
        super().begin(shape)
        b = shape.simulations
        whole = np.zeros(b, dtype=np.int64)
        self.figures = Statistics(
            np.zeros(b), np.zeros(b), whole, np.zeros(b), np.zeros(b), np.zeros((b, 2)), whole.copy(),
            np.zeros((b, len(self._modes))),
        )  # fmt: skip

    def take(self, first: int, count: int, rows: Rows) -> None:
        """Adds rows to the figures."""
        _take(self.figures, self._limits, self.late, self._modes, first, count, rows)


@compiled_loop
def _take(
    figures: Statistics, limits: SettlingLimits, late: int, modes: np.ndarray, first: int, count: int, rows: Rows
) -> None:
    """Adds rows from `first` on to the figures, row by row: the last digits do not depend on how many come at once."""
    for b in range(rows.table.shape[0]):
        for k in range(count):
            row = rows.table[b, k, FOLLOWER]
            _take_error(figures, limits, late, b, first + k, row)
            if math.isnan(row[_SPEED]):
                continue
            if first + k > 0:  # telemetry is of the period before, and before the first is none
                used = max(row[_UTILISATION], row[_UTILISATION + 1])
                if used > figures.utilisation[b]:
                    figures.utilisation[b] = used
                figures.saturated[b] += max(row[_SATURATION], row[_SATURATION + 1])
            for c in range(2):
                u = row[_INPUT + c]
                if not math.isnan(u):  # nothing is commanded at the end
                    figures.effort[b, c] += u * u
            switched = False
            for m in range(modes.shape[0]):
                mode = rows.memory[b, k, FOLLOWER, modes[m]]
                switched |= mode != figures.modes[b, m]
                figures.modes[b, m] = mode
            if first + k > 0 and switched:
                figures.switches[b] += 1


@compiled_inside
def _take_error(
    figures: Statistics, limits: SettlingLimits, late: int, b: int, period: int, row: np.ndarray
) -> None:
    """Adds a follower's error."""
    distance = math.hypot(row[_ERROR], row[_ERROR + 1])
    heading = abs(row[_ERROR + 2])
    if period >= late:
        if distance > figures.position[b]:
            figures.position[b] = distance
        if heading > figures.heading[b]:
            figures.heading[b] = heading
    if not is_near_compiled(limits, distance, heading):
        figures.settled[b] = period + 1
