"""When a simulation is lost, so that it cannot go on: the code that compiled code leaves, and what is said of it.

A run in which this happens has diverged; of many runs side by side the one stands still, and counts as lost. It happens
where a command or a state is no number, where a robot tips over, and where one runs away: where it is `RUNAWAY` times
as far from the leader as the farthest robot was at the start, or as the scenario is large if that is more.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from nhtrack.arrays import Array
from nhtrack.compiled import compiled_inside
from nhtrack.errors import SimulationDiverged

FINE, COMMAND, STATE, WARNED, TIPPED_OVER, LAW, RAN_AWAY = range(7)

REASONS = {
    COMMAND: "command is not finite",
    STATE: "state is not finite",
    TIPPED_OVER: "tipped over",
    LAW: "law raised an exception",
    RAN_AWAY: "ran away",
}
LOST = "ran away, tipped over, or was commanded no number"  # what became of a robot that is lost, in a phrase

RUNAWAY = 1e3  # times the distance at the start
_FASTEST = 1e12  # [m/s], [rad/s], [rad] and [m] of which sums and squares are still finite


def reach_of(g: Array, size: float) -> Array:
    """Returns how far from the leader robots may be before they have run away [m], shape (b,).

    Args:
        g: poses at the start, the leader's first, shape (b, n, 3).
        size: of the scenario [m].
    """
    apart = np.hypot(*np.moveaxis(g[..., :2] - g[:, :1, :2], -1, 0)).max(axis=-1)
    return np.asarray(RUNAWAY * np.maximum(apart, size))


@compiled_inside
def is_lost(g: np.ndarray, xi: np.ndarray, reach: float, fault: np.ndarray) -> bool:
    """Returns whether a robot's state is no number or it has run away, and notes the first one.

    Args:
        g: poses, shape (n, 3).
        xi: twists, shape (n, 3).
        reach: see `reach_of` [m].
        fault: code, robot and detail; changed if there was none.
    """
    for i in range(g.shape[0]):
        x, y = g[i, 0] - g[0, 0], g[i, 1] - g[0, 1]
        finite, near = True, x * x + y * y <= reach * reach
        for c in range(3):
            finite = finite and math.isfinite(g[i, c]) and math.isfinite(xi[i, c])
            near = near and abs(g[i, c]) < _FASTEST and abs(xi[i, c]) < _FASTEST
        if not (finite and near):
            if fault[0] == FINE:
                fault[0], fault[1] = RAN_AWAY if finite else STATE, i
            return True
    return False


def failure_in(
    motion: Any, names: tuple[str, ...], start: float, dt: float, periods: int, simulation: int | None = None
) -> SimulationDiverged | None:
    """Returns why simulations cannot go on, or None; one that may be lost is no failure.

    Args:
        motion: what compiled code has left of them: `fault` and `lost`.
        names: of the robots.
        start: time at the start [s].
        dt: control period [s].
        periods: control periods since then.
        simulation: which one is meant; the first that cannot go on by default.
    """
    faulty = np.flatnonzero((motion.fault[:, 0] != FINE) & ~motion.lost)
    if not len(faulty):
        return None
    b = int(faulty[0]) if simulation is None else simulation
    code, robot, detail = (int(value) for value in motion.fault[b])
    time = start + (periods - (code == COMMAND)) * dt
    if code == WARNED:
        import mujoco  # only here: ideal robots do without it

        what = mujoco.mjtWarning(detail).name.removeprefix("mjWARN_").lower()
        return SimulationDiverged(f"MuJoCo warned of {what}", names[0], time, b)
    return SimulationDiverged(REASONS[code], names[robot], time, b)
