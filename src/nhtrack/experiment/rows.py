"""The rows that the loop writes, one for every control period, simulation and robot."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from nhtrack import planar
from nhtrack.compiled import compiled_inside
from nhtrack.simulation import columns
from nhtrack.simulation.motion import copy
from nhtrack.simulation.touch import forget_touches

# Columns of a row, by the names of `nhtrack.recording.VARIABLES`; telemetry follows them.
COLUMNS: Mapping[str, slice] = {
    "pose": slice(0, 3),
    "twist": slice(3, 6),
    "input": slice(6, 8),
    "leader_pose": slice(8, 11),
    "leader_twist": slice(11, 14),
    "error": slice(14, 17),
}
BARE = 17  # columns of a row without telemetry


class Rows(NamedTuple):
    """Where rows are written, for b simulations of n robots; the rows of a simulation lie behind each other.

    Attributes:
        table: shape (b, k, n, BARE) or, with telemetry, (b, k, n, BARE + columns.WIDTH).
        memory: of the law after its command, shape (b, k, n, values), or k = 0.
        qpos: MuJoCo's configuration, shape (b, k, p, coordinates of a robot), or k = 0.
        touch: what robots have touched since the row before, see `nhtrack.simulation.touch`, shape
            (b, k, n, SLOTS, FIELDS), or k = 0.
        first: which of the rows is the next.
    """

    table: np.ndarray
    memory: np.ndarray
    qpos: np.ndarray
    touch: np.ndarray
    first: int


def variables_of(table: np.ndarray) -> dict[str, np.ndarray]:
    """Returns views of a table by the names of variables, shape (..., columns) -> (..., components)."""
    found = {name: table[..., columns_] for name, columns_ in COLUMNS.items()}
    if table.shape[-1] > BARE:
        found |= columns.telemetry_of(table[..., BARE:])
    return found


@compiled_inside
def write_row(
    rows: Rows, k: int, b: int, motion: Any, u: np.ndarray, commanded: bool, tracked: np.ndarray, memory: np.ndarray
) -> None:
    """Writes the row k of a simulation; the last row of a run has no input, since nothing is commanded any more."""
    for i in range(u.shape[0]):
        row, g, xi, seen = rows.table[b, rows.first + k, i], motion.g[b, i], motion.xi[b, i], tracked[i]
        for c in range(3):
            row[c] = g[c]
            row[3 + c] = xi[c]
            row[8 + c] = seen[c]
            row[11 + c] = seen[3 + c]
        row[6] = u[i, 0] if commanded else math.nan
        row[7] = u[i, 1] if commanded else math.nan
        if math.isnan(seen[0]):  # the root, which tracks nobody
            row[14] = row[15] = row[16] = math.nan
        else:
            x, y, heading = planar.between((seen[0], seen[1], seen[2]), (g[0], g[1], g[2]))
            row[14] = x
            row[15] = y
            row[16] = planar.wrap(heading)
        for c in range(row.shape[0] - BARE):
            row[BARE + c] = motion.telemetry[b, i, c]
        if rows.memory.shape[1] > 0:
            for c in range(memory.shape[1]):
                rows.memory[b, rows.first + k, i, c] = memory[i, c]
    if rows.qpos.shape[1] > 0:
        for robot in range(motion.qpos.shape[1]):
            for c in range(motion.qpos.shape[2]):
                rows.qpos[b, rows.first + k, robot, c] = motion.qpos[b, robot, c]
    if rows.touch.shape[1] > 0:
        for i in range(motion.touch.shape[1]):
            for slot in range(motion.touch.shape[2]):
                copy(rows.touch[b, rows.first + k, i, slot], motion.touch[b, i, slot])
        forget_touches(motion.touch[b])
