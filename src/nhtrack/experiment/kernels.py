"""What the loop does period by period, compiled: command, write, step. The law is known by an address only."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nhtrack.compiled import compiled, compiled_inside
from nhtrack.experiment.followers import Followers, Memories, command_followers, make_scratch
from nhtrack.experiment.rows import Rows, write_qpos, write_row
from nhtrack.simulation.engine import LAW as LAW_RAISED
from nhtrack.simulation.engine import Motion, Place, Wheels, begin, finish, lose, step_simulation
from nhtrack.simulation.flow import Flow, Integrator, step_flow


class Block(NamedTuple):
    """Some control periods of a run.

    Attributes:
        done: periods that are behind.
        periods: to come; the end of the run counts as one, in which nothing is commanded.
        every: every so many of them a row is written.
        rows: where to.
        written: periods begun, by simulation, shape (b,).
    """

    done: int
    periods: int
    every: int
    rows: Rows
    written: np.ndarray


@compiled
def run_on_wheels(
    followers: Followers, memories: Memories, block: Block, u_root: np.ndarray, first: int, last: int,
    wheels: Wheels, place: Place, motion: Motion, keep_going: bool,
) -> None:  # fmt: skip
    """Runs the simulations [first, last) through a block of periods on wheels, and counts the periods they began.

    Args:
        followers: who tracks whom.
        memories: of all simulations; changed.
        block: the periods, and where to write.
        u_root: accelerations of the root, shape (periods, 1 or b, 2).
        first: first simulation.
        last: one behind the last.
        wheels: see `nhtrack.simulation.engine`.
        place: of the thread.
        motion: of all simulations; changed.
        keep_going: whether a simulation that diverges may be lost.
    """
    scratch = make_scratch()
    u = np.zeros((motion.g.shape[1], 2))
    for b in range(first, last):
        for k in range(block.periods):
            at_end = block.done + k == u_root.shape[0]
            _take_root(u, u_root, block.done + k - at_end, b)
            robot = command_followers(followers, memories, b, motion.g[b], motion.xi[b], u, scratch)
            if robot >= 0:
                motion.fault[b, 0], motion.fault[b, 1] = LAW_RAISED, robot
                break
            row = _row(block, k, at_end)
            if row >= 0:
                write_row(
                    block.rows, row, b, motion.g[b], motion.xi[b], u, not at_end, memories.tracked[b],
                    motion.telemetry[b], memories.law[b],
                )  # fmt: skip
                write_qpos(block.rows, row, b, motion.qpos[b])
            block.written[b] = k + 1
            if at_end or motion.lost[b]:
                continue
            if not step_simulation(wheels, place, motion, b, u):
                if not keep_going:
                    break
                lose(motion, b)


@compiled
def command_fleet(
    followers: Followers, memories: Memories, block: Block, u_root: np.ndarray, k: int, motion: Motion, u: np.ndarray,
) -> bool:  # fmt: skip
    """Commands the robots of one simulation and writes its row; returns whether a period begins."""
    at_end = block.done + k == u_root.shape[0]
    _take_root(u, u_root, block.done + k - at_end, 0)
    robot = command_followers(followers, memories, 0, motion.g[0], motion.xi[0], u, make_scratch())
    if robot >= 0:
        motion.fault[0, 0], motion.fault[0, 1] = LAW_RAISED, robot
        return False
    row = _row(block, k, at_end)
    if row >= 0:
        write_row(
            block.rows, row, 0, motion.g[0], motion.xi[0], u, not at_end, memories.tracked[0], motion.telemetry[0],
            memories.law[0],
        )  # fmt: skip
        write_qpos(block.rows, row, 0, motion.qpos[0])
    block.written[0] = k + 1
    return not at_end and begin(motion, 0, u)


@compiled
def finish_fleet(wheels: Wheels, motion: Motion) -> bool:
    """Reads the state of one simulation at the end of a period; returns whether all went well."""
    return finish(wheels, motion, 0)


@compiled
def run_ideal(
    followers: Followers, memories: Memories, block: Block, u_root: np.ndarray, first: int, last: int,
    integrator: Integrator, flow: Flow,
) -> None:  # fmt: skip
    """Runs the simulations [first, last) through a block of periods on the ideal model; see `run_on_wheels`."""
    scratch = make_scratch()
    u = np.zeros((flow.g.shape[1], 2))
    for b in range(first, last):
        for k in range(block.periods):
            at_end = block.done + k == u_root.shape[0]
            _take_root(u, u_root, block.done + k - at_end, b)
            robot = command_followers(followers, memories, b, flow.g[b], flow.xi[b], u, scratch)
            if robot >= 0:
                flow.fault[b, 0], flow.fault[b, 1] = LAW_RAISED, robot
                break
            row = _row(block, k, at_end)
            if row >= 0:
                write_row(
                    block.rows, row, b, flow.g[b], flow.xi[b], u, not at_end, memories.tracked[b], flow.telemetry[b],
                    memories.law[b],
                )  # fmt: skip
            block.written[b] = k + 1
            if not at_end and not step_flow(integrator, flow, b, u):
                break


@compiled_inside
def _row(block: Block, k: int, at_end: bool) -> int:
    """Returns which row of a block a period's is, or -1 where it is left out."""
    period, every = block.done + k, block.every
    if not at_end and period % every != 0:
        return -1
    return int((period + every - 1) // every - (block.done + every - 1) // every)


@compiled_inside
def _take_root(u: np.ndarray, u_root: np.ndarray, k: int, b: int) -> None:
    """Sets the root's accelerations of a period; the others are not known yet."""
    own = b if u_root.shape[1] > 1 else 0
    for i in range(u.shape[0]):
        u[i, 0] = np.nan
        u[i, 1] = np.nan
    u[0, 0] = u_root[k, own, 0]
    u[0, 1] = u_root[k, own, 1]
