"""Why a simulation cannot go on: the code that compiled code leaves, and what is said of it."""

from __future__ import annotations

from typing import Any

import numpy as np

from nhtrack.errors import SimulationDiverged

FINE, COMMAND, STATE, WARNED, TIPPED_OVER, LAW = range(6)

_REASONS = {
    COMMAND: "command is not finite",
    STATE: "state is not finite",
    TIPPED_OVER: "tipped over",
    LAW: "law raised an exception",
}


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
    return SimulationDiverged(_REASONS[code], names[robot], time, b)
