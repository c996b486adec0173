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

_POSE, _ERROR, _INPUT = COLUMNS["pose"].start, COLUMNS["error"].start, COLUMNS["input"].start
_SPEED, _SATURATION, _UTILISATION, _SLIP = (
    BARE + columns.COLUMNS[name].start
    for name in ("wheel_speed", "torque_saturation", "friction_utilisation", "lateral_slip")
)


class Statistics(NamedTuple):
    """Figures of b runs of n robots. Errors of the root, which tracks nobody, are not known: zero, or NaN.

    Attributes:
        first: distance and heading error at the start [m], [rad], shape (b, n, 2).
        last: the same in the last row, shape (b, n, 2).
        late: the same, largest late ones, shape (b, n, 2).
        settled: first row from which on errors are within the limits, see `settling_rows`, shape (b, n).
        utilisation: largest friction utilisation, shape (b, n).
        saturated: sum over periods of the share in which a motor was at its limit, shape (b, n).
        slip: largest lateral slip [m/s], shape (b, n).
        effort: sum of squared accelerations, shape (b, n, 2).
        path: length of the way [m], shape (b, n).
        pose: in the last row, shape (b, n, 3).
        gap: largest distance and angle from the ideal twin [m], [rad], shape (b, n, 2); zero where there is none.
        gap_2: sum over rows of the squares of these, shape (b, n, 2).
        switches: control periods in which a mode of the law changed, one or several, shape (b, n).
        modes: they in the last row, shape (b, n, modes).
    """

    first: np.ndarray
    last: np.ndarray
    late: np.ndarray
    settled: np.ndarray
    utilisation: np.ndarray
    saturated: np.ndarray
    slip: np.ndarray
    effort: np.ndarray
    path: np.ndarray
    pose: np.ndarray
    gap: np.ndarray
    gap_2: np.ndarray
    switches: np.ndarray
    modes: np.ndarray


class RunStatistics(Streaming):
    """Takes the figures of b runs; a recorder that keeps no row.

    A run that is lost counts up to the row before it was: what is lost has no telemetry.

    Args:
        limits: within which a follower has settled.
        late: row from which on errors are late errors.
        modes: places in the law's memory that count as its modes.
        twins: poses of the ideal twins, shape (b, rows, n, 3), that gaps are taken to; none by default.
    """

    def __init__(
        self, limits: SettlingLimits, late: int, modes: tuple[int, ...], twins: np.ndarray | None = None
    ) -> None:
        self._limits, self.late, self._modes = limits, late, np.array(modes, dtype=np.int64)
        self._twins = np.zeros((0, 0, 0, 3)) if twins is None else np.ascontiguousarray(twins)

    def begin(self, shape: Shape) -> None:
        """Sets all figures to those of no run."""
        super().begin(shape)
        b, n = shape.simulations, shape.robots
        one, two, whole = (b, n), (b, n, 2), np.zeros((b, n), dtype=np.int64)
        self.figures = Statistics(
            first=np.zeros(two),
            last=np.zeros(two),
            late=np.zeros(two),
            settled=whole,
            utilisation=np.zeros(one),
            saturated=np.zeros(one),
            slip=np.zeros(one),
            effort=np.zeros(two),
            path=np.zeros(one),
            pose=np.zeros((b, n, 3)),
            gap=np.zeros(two),
            gap_2=np.zeros(two),
            switches=whole.copy(),
            modes=np.zeros((b, n, len(self._modes))),
        )

    def take(self, first: int, count: int, rows: Rows) -> None:
        """Adds rows to the figures."""
        _take(self.figures, self._limits, self.late, self._modes, self._twins, first, count, rows)


@compiled_loop
def _take(
    figures: Statistics,
    limits: SettlingLimits,
    late: int,
    modes: np.ndarray,
    twins: np.ndarray,
    first: int,
    count: int,
    rows: Rows,
) -> None:
    """Adds rows from `first` on to the figures, row by row: the last digits do not depend on how many come at once."""
    for b in range(rows.table.shape[0]):
        for k in range(count):
            for i in range(rows.table.shape[2]):
                row, at = rows.table[b, k, i], first + k
                _take_error(figures, limits, late, b, i, at, row)
                _take_way(figures, twins, b, i, at, row)
                if math.isnan(row[_SPEED]):
                    continue
                if at > 0:  # telemetry is of the period before, and before the first is none
                    used = max(row[_UTILISATION], row[_UTILISATION + 1])
                    if used > figures.utilisation[b, i]:
                        figures.utilisation[b, i] = used
                    figures.saturated[b, i] += max(row[_SATURATION], row[_SATURATION + 1])
                    if abs(row[_SLIP]) > figures.slip[b, i]:
                        figures.slip[b, i] = abs(row[_SLIP])
                for c in range(2):
                    u = row[_INPUT + c]
                    if not math.isnan(u):  # nothing is commanded at the end
                        figures.effort[b, i, c] += u * u
                switched = False
                for m in range(modes.shape[0]):
                    mode = rows.memory[b, k, i, modes[m]]
                    switched |= mode != figures.modes[b, i, m]
                    figures.modes[b, i, m] = mode
                if at > 0 and switched:
                    figures.switches[b, i] += 1


@compiled_inside
def _take_error(
    figures: Statistics, limits: SettlingLimits, late: int, b: int, i: int, at: int, row: np.ndarray
) -> None:
    """Adds a robot's error."""
    distance = math.hypot(row[_ERROR], row[_ERROR + 1])
    heading = abs(row[_ERROR + 2])
    figures.last[b, i, 0] = distance
    figures.last[b, i, 1] = heading
    if at == 0:
        figures.first[b, i, 0] = distance
        figures.first[b, i, 1] = heading
    if at >= late:
        if distance > figures.late[b, i, 0]:
            figures.late[b, i, 0] = distance
        if heading > figures.late[b, i, 1]:
            figures.late[b, i, 1] = heading
    if not is_near_compiled(limits, distance, heading):
        figures.settled[b, i] = at + 1


@compiled_inside
def _take_way(figures: Statistics, twins: np.ndarray, b: int, i: int, at: int, row: np.ndarray) -> None:
    """Adds what a robot drove since the row before, and how far it is from its twin."""
    pose = figures.pose[b, i]
    if at > 0:
        figures.path[b, i] += math.hypot(row[_POSE] - pose[0], row[_POSE + 1] - pose[1])
    for c in range(3):
        pose[c] = row[_POSE + c]
    if twins.shape[1] > 0:
        twin = twins[b, at, i]
        distance = math.hypot(pose[0] - twin[0], pose[1] - twin[1])
        turned = abs(pose[2] - twin[2])
        figures.gap_2[b, i, 0] += distance * distance
        figures.gap_2[b, i, 1] += turned * turned
        if distance > figures.gap[b, i, 0]:
            figures.gap[b, i, 0] = distance
        if turned > figures.gap[b, i, 1]:
            figures.gap[b, i, 1] = turned
