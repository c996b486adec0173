"""Why a run ended early, told by who is to blame: a robot, MuJoCo, or the law."""

from __future__ import annotations

import traceback
from typing import Any

import numpy as np

from nhtrack.errors import SimulationDiverged
from nhtrack.experiment.followers import Followers, Memories, begin_followers, make_scratch
from nhtrack.experiment.kernels import CompiledSimulation
from nhtrack.laws.address import call_law, require_uninterrupted
from nhtrack.laws.law import Law
from nhtrack.laws.own_file import LawError
from nhtrack.simulation.faults import COMMAND, FINE
from nhtrack.simulation.faults import LAW as LAW_RAISED


def require_begun(law: Law, followers: Followers, memories: Memories, simulation: CompiledSimulation) -> None:
    """Gives followers their first memory.

    Raises:
        LawError: the law raised an exception, with its file and line and the robot.
        KeyboardInterrupt: the user stopped a law that runs as Python.
    """
    g, xi = simulation.motion.g, simulation.motion.xi
    robot = begin_followers(followers, memories, g, xi, make_scratch(g.shape[1]))
    if robot >= 0:
        said = _what_it_raised(law, followers, memories, 0, robot, "init")
        raise LawError(f"law {law.kind.name!r} fails for {simulation.names[robot]} at the start: {said}")


def failure_of(
    simulation: CompiledSimulation, law: Law, followers: Followers, memories: Memories, rows: np.ndarray
) -> SimulationDiverged | None:
    """Returns why a run cannot go on, or None.

    Args:
        simulation: what moved the robots.
        law: what they obeyed.
        followers: who tracks whom.
        memories: of the law.
        rows: written by each simulation since the start, shape (b,); the first to stop is told.

    Raises:
        KeyboardInterrupt: the user stopped a law that runs as Python.
    """
    motion = simulation.motion
    faulty = np.flatnonzero((motion.fault[:, 0] != FINE) & ~motion.lost)
    if not len(faulty):
        return None
    b = int(faulty[np.argmin(rows[faulty])])
    code, robot = int(motion.fault[b, 0]), int(motion.fault[b, 1])
    if code == LAW_RAISED:
        said = _what_it_raised(law, followers, memories, b, robot, "command")
        time = simulation.start_time + int(rows[b]) * simulation.dt
        return SimulationDiverged(f"law {law.kind.name!r} raised {said}", simulation.names[robot], time, b)
    failure = simulation.failure(int(rows[b]), b)
    if code == COMMAND and not law.kind.built_in and failure is not None:
        reason = f"{failure.reason} (`command` of {_place(law)})"
        return SimulationDiverged(reason, failure.robot, failure.time, b)
    return failure


def _place(law: Law) -> str:
    function: Any = getattr(law.kind.command, "py_func", law.kind.command)
    return f"{law.kind.file}:{function.__code__.co_firstlineno}"


def _what_it_raised(
    law: Law, followers: Followers, memories: Memories, b: int, robot: int, function: str
) -> str:
    """Returns what the law raises when it is called as Python with what it was called with, and where."""
    require_uninterrupted()
    gains = followers.gains[b if len(followers.gains) > 1 else 0]
    try:
        call_law(
            law.kind, function, gains, followers.context, memories.asked[b, :6], memories.asked[b, 6:],
            memories.law[b, robot, : law.kind.memory_size],
        )  # fmt: skip
    except Exception as error:
        inside = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename == law.kind.file]
        where = f" ({law.kind.file}:{inside[-1].lineno})" if inside else ""
        return f"{type(error).__name__}: {error}{where}"
    return f"an exception as compiled code, but none as Python ({_place(law)})"
