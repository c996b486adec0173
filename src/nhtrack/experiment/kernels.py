"""What the loop does period by period, compiled: command, write, step. The law is known by an address only."""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

import numpy as np

from nhtrack.compiled import compiled_inside, compiled_loop
from nhtrack.experiment.followers import Followers, Memories, Scratch, command_followers
from nhtrack.experiment.rows import Rows, write_row
from nhtrack.simulation.engine import begin, finish, lose, step_simulation
from nhtrack.simulation.faults import LAW
from nhtrack.simulation.flow import Flow, Integrator, step_flow
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.motion import Motion, Place, Wheels
from nhtrack.simulation.mujoco import MujocoSimulation

# What has a period that compiled code can run.
CompiledSimulation: TypeAlias = IdealSimulation | MujocoSimulation

_FAILED, _ENDED, _COMMANDED = range(3)


class Block(NamedTuple):
    """Some control periods of a run.

    Attributes:
        done: periods that are behind.
        periods: to come; the end of the run counts as one, in which nothing is commanded.
        every: every so many of them a row is written.
        rows: where to.
        written: periods begun, by simulation, shape (b,).
        u_root: accelerations of the root in all periods, shape (periods of the run, 1 or b, 2).
    """

    done: int
    periods: int
    every: int
    rows: Rows
    written: np.ndarray
    u_root: np.ndarray


@compiled_loop
def run_on_wheels(
    followers: Followers, memories: Memories, block: Block, first: int, last: int, scratch: Scratch, motion: Motion,
    wheels: Wheels, place: Place, keep_going: bool,
) -> None:  # fmt: skip
    """Runs the simulations [first, last) through a block of periods on wheels, and counts the periods they began.

    Args:
        followers: who tracks whom.
        memories: of all simulations; changed.
        block: the periods, and where to write.
        first: first simulation.
        last: one behind the last.
        scratch: of the thread.
        motion: of all simulations; changed.
        wheels: see `nhtrack.simulation.motion`.
        place: of the thread.
        keep_going: whether a simulation that diverges may be lost.
    """
    for b in range(first, last):
        for k in range(block.periods):
            went = _command(followers, memories, block, b, k, scratch, motion)
            if went == _FAILED:
                break
            if went == _COMMANDED and not motion.lost[b] and not step_simulation(wheels, place, motion, b, scratch.u):
                if not keep_going:
                    break
                lose(motion, b)


@compiled_loop
def run_ideal(
    followers: Followers, memories: Memories, block: Block, first: int, last: int, scratch: Scratch, flow: Flow,
    integrator: Integrator,
) -> None:  # fmt: skip
    """Runs the simulations [first, last) through a block of periods on the ideal model; see `run_on_wheels`."""
    for b in range(first, last):
        for k in range(block.periods):
            went = _command(followers, memories, block, b, k, scratch, flow)
            if went == _FAILED or (went == _COMMANDED and not step_flow(integrator, flow, b, scratch.u)):
                break


@compiled_loop
def command_fleet(
    followers: Followers, memories: Memories, block: Block, k: int, scratch: Scratch, motion: Motion
) -> bool:
    """Commands the robots of one simulation and writes its row; returns whether a period begins."""
    went = _command(followers, memories, block, 0, k, scratch, motion)
    return went == _COMMANDED and begin(motion, 0, scratch.u)


@compiled_loop
def finish_fleet(wheels: Wheels, motion: Motion) -> bool:
    """Reads the state of one simulation at the end of a period; returns whether all went well."""
    return finish(wheels, motion, 0)


@compiled_inside
def _command(
    followers: Followers, memories: Memories, block: Block, b: int, k: int, scratch: Scratch, motion: Any
) -> int:
    """Commands the robots of a simulation in a period, writes its row, and returns how that went."""
    at_end = block.done + k == block.u_root.shape[0]
    _take_root(scratch.u, block, k - at_end, b)
    robot = command_followers(followers, memories, b, block.done + k, motion.g[b], motion.xi[b], scratch)
    if robot >= 0:
        motion.fault[b, 0], motion.fault[b, 1] = LAW, robot
        return _FAILED
    row = _row(block, k, at_end)
    if row >= 0:
        write_row(block.rows, row, b, motion, scratch.u, not at_end, memories.tracked[b], memories.law[b])
    block.written[b] = k + 1
    return _ENDED if at_end else _COMMANDED


@compiled_inside
def _row(block: Block, k: int, at_end: bool) -> int:
    """Returns which row of a block a period's is, or -1 where it is left out."""
    period, every = block.done + k, block.every
    if not at_end and period % every != 0:
        return -1
    return int((period + every - 1) // every - (block.done + every - 1) // every)


@compiled_inside
def _take_root(u: np.ndarray, block: Block, k: int, b: int) -> None:
    """Sets the root's accelerations of a period; the others are not known yet."""
    own = b if block.u_root.shape[1] > 1 else 0
    for i in range(1, u.shape[0]):
        u[i, 0] = np.nan
        u[i, 1] = np.nan
    u[0, 0] = block.u_root[block.done + k, own, 0]
    u[0, 1] = block.u_root[block.done + k, own, 1]
