"""The loop in which a simulation and a law meet.

Every control period: the root takes its input; then, parents before children, each follower's law sees the follower and
what it tracks (pose, twist, and the acceleration commanded this period) and commands its own; the simulation holds all
commands for the period. Many periods are one call of compiled code, which knows the law by an address only.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from nhtrack.compiled import compiled
from nhtrack.errors import SimulationDiverged
from nhtrack.experiment.failures import failure_of, require_begun
from nhtrack.experiment.followers import (
    Followers,
    Memories,
    Tracking,
    begin_followers,
    command_followers,
    make_followers,
    make_memories,
    make_scratch,
)
from nhtrack.experiment.recorder import FullRecorder, Recorder, Shape
from nhtrack.experiment.rows import Rows, write_qpos, write_row
from nhtrack.laws.law import Law
from nhtrack.network import Network
from nhtrack.simulation.engine import LAW as LAW_RAISED
from nhtrack.simulation.engine import Motion, Place, Wheels, begin, finish, lose, roll_units, step_simulation
from nhtrack.simulation.flow import Flow, Integrator, step_flow
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.state import State

Progress = Callable[[int, int], None]
Simulation: TypeAlias = IdealSimulation | MujocoSimulation

_FIRST_BLOCK = 8  # control periods of the first call of compiled code
_PAUSE = 0.1  # [s] how long a call may last, so that progress is told and Ctrl-C is heard


@dataclass(frozen=True)
class Rollout:
    """What a loop leaves behind.

    Attributes:
        time: times [s], shape (t,): the start and the end of every period that was finished.
        variables: arrays of shape (t, ..., n, components) by the names of `nhtrack.recording.VARIABLES`.
        qpos: MuJoCo's configuration, shape (t, ..., nq), or None.
        failure: why the run ended early, or None.
        interrupted: whether the user stopped it.
    """

    time: np.ndarray
    variables: dict[str, np.ndarray]
    qpos: np.ndarray | None
    failure: SimulationDiverged | None = None
    interrupted: bool = False


def rollout(
    simulation: Simulation,
    law: Law,
    network: Network,
    inputs: np.ndarray,
    start: State,
    tracking: Tracking | None = None,
    progress: Progress | None = None,
) -> Rollout:
    """Returns the run of a network under a law, every row of it.

    A run that diverges, or that the user interrupts, ends early and keeps what it has.

    Args:
        simulation: what moves the robots.
        law: what every follower obeys.
        network: who tracks whom.
        inputs: accelerations (u_x, u_theta) of the root for each period, shape (periods, 2) or (periods, b, 2).
        start: the state to begin with, shapes (n, 3) or (b, n, 3).
        tracking: how what a follower tracks is made from its parents; as printed, without offsets, by default.
        progress: called with the periods done and their number.

    Raises:
        LawError: the law raised an exception before the run began.
    """
    recorder, interrupted, failure = FullRecorder(), False, None
    try:
        failure = run(simulation, law, network, inputs, start, recorder, tracking, progress)
    except KeyboardInterrupt:
        interrupted = True
    batch = start.g.ndim > 2
    one = slice(None) if batch else 0
    variables = {name: values[:, one] for name, values in recorder.variables.items()}
    qpos = recorder.qpos
    return Rollout(recorder.time, variables, None if qpos is None else qpos[:, one], failure, interrupted)


def run(
    simulation: Simulation,
    law: Law,
    network: Network,
    inputs: np.ndarray,
    start: State,
    recorder: Recorder,
    tracking: Tracking | None = None,
    progress: Progress | None = None,
    threads: int = 1,
) -> SimulationDiverged | None:
    """Runs a network under a law and returns why it ended early, or None; see `rollout`.

    Args:
        simulation: what moves the robots.
        law: what every follower obeys.
        network: who tracks whom.
        inputs: accelerations of the root, shape (periods, 2) or (periods, b, 2).
        start: the state to begin with.
        recorder: what keeps the run.
        tracking: see `rollout`.
        progress: called with the periods done and their number.
        threads: among which an ideal batch is divided; one on wheels has its own.
    """
    simulation.reset(start)
    followers = make_followers(network, tracking or Tracking(), law, simulation.dt)
    count, n = simulation.motion.g.shape[:2]
    memories = make_memories(followers, law, count)
    u_root = np.ascontiguousarray(inputs if inputs.ndim == 3 else inputs[:, None], dtype=float)
    recorder.begin(
        Shape(
            periods=len(u_root),
            simulations=count,
            robots=n,
            telemetry=simulation.measured,
            memory=law.kind.memory_size,
            qpos=simulation.motion.qpos.shape[1:] if isinstance(simulation, MujocoSimulation) else (0, 0),
            dt=simulation.dt,
            start=start.t,
        )
    )
    require_begun(law, followers, memories, simulation, begin_followers)
    threads = len(simulation.places) if isinstance(simulation, MujocoSimulation) else threads
    shares = np.linspace(0, count, max(1, min(count, threads)) + 1).astype(int)
    with ThreadPoolExecutor(len(shares) - 1) as pool:
        return _blocks(simulation, law, followers, memories, u_root, recorder, progress, shares, pool)


def _blocks(
    simulation: Simulation,
    law: Law,
    followers: Followers,
    memories: Memories,
    u_root: np.ndarray,
    recorder: Recorder,
    progress: Progress | None,
    shares: np.ndarray,
    pool: ThreadPoolExecutor,
) -> SimulationDiverged | None:
    """Runs block by block of control periods."""
    periods, count = len(u_root), len(simulation.motion.g)
    done, size = 0, _FIRST_BLOCK
    while done <= periods:
        rows = recorder.space(done, min(size, periods + 1 - done))
        written = np.zeros(count, dtype=np.int64)
        began = time.perf_counter()
        tasks = [
            (followers, memories, rows, u_root, done, int(first), int(last), written, simulation)
            for first, last in pairwise(shares)
        ]
        if isinstance(simulation, MujocoSimulation) and simulation.is_fleet:
            _run_fleet(followers, memories, rows, u_root, done, written, simulation, pool)
        elif len(tasks) == 1:
            _run_share(*tasks[0], share=0)
        else:
            list(pool.map(lambda task: _run_share(*task[1], share=task[0]), enumerate(tasks)))
        kept = int(written.min())
        recorder.add(done, Rows(*(values[:kept] for values in rows)), simulation.motion.lost)
        failure = failure_of(simulation, law, followers, memories, done + written)
        if failure is not None:
            return failure
        done += kept
        if progress is not None:
            progress(min(done, periods), periods)
        size = max(1, round(kept * min(8.0, _PAUSE / max(time.perf_counter() - began, 1e-6))))
    return None


def _run_fleet(
    followers: Followers,
    memories: Memories,
    rows: Rows,
    u_root: np.ndarray,
    done: int,
    written: np.ndarray,
    simulation: MujocoSimulation,
    pool: ThreadPoolExecutor,
) -> None:
    """Runs one simulation of many small models through a block of periods: commands at once, models over threads."""
    wheels, motion, places = simulation.wheels, simulation.motion, simulation.places
    shares = np.linspace(0, simulation.units, len(places) + 1).astype(int)
    u = np.zeros(motion.u.shape[1:])
    for k in range(len(rows.table)):
        if not command_fleet(followers, memories, rows, u_root, done, k, written, motion, u):
            return
        futures = [
            pool.submit(roll_units, wheels, place, motion, 0, int(first), int(last))
            for place, (first, last) in zip(places[1:], list(pairwise(shares))[1:], strict=True)
        ]
        roll_units(wheels, places[0], motion, 0, 0, int(shares[1]))
        for future in futures:
            future.result()
        if not finish_fleet(wheels, motion):
            return


def _run_share(
    followers: Followers,
    memories: Memories,
    rows: Rows,
    u_root: np.ndarray,
    done: int,
    first: int,
    last: int,
    written: np.ndarray,
    simulation: Simulation,
    *,
    share: int,
) -> None:
    """Runs a share of the simulations through a block of periods; compiled code lets other threads run beside it."""
    if isinstance(simulation, MujocoSimulation):
        run_on_wheels(
            followers, memories, rows, u_root, done, first, last, written,
            simulation.wheels, simulation.places[share], simulation.motion, simulation.keep_going,
        )  # fmt: skip
    else:
        run_ideal(
            followers, memories, rows, u_root, done, first, last, written, simulation.integrator, simulation.motion
        )


@compiled
def run_on_wheels(
    followers: Followers, memories: Memories, rows: Rows, u_root: np.ndarray, done: int, first: int, last: int,
    written: np.ndarray, wheels: Wheels, place: Place, motion: Motion, keep_going: bool,
) -> None:  # fmt: skip
    """Runs the simulations [first, last) through a block of periods on wheels, and counts the rows they wrote.

    Args:
        followers: who tracks whom.
        memories: of all simulations; changed.
        rows: where to write; as many periods as it has rows, and the row at the end of the run.
        u_root: accelerations of the root, shape (periods, 1 or b, 2).
        done: periods that are behind.
        first: first simulation.
        last: one behind the last.
        written: rows written, shape (b,); changed.
        wheels: see `nhtrack.simulation.engine`.
        place: of the thread.
        motion: of all simulations; changed.
        keep_going: whether a simulation that diverges may be lost.
    """
    scratch = make_scratch()
    u = np.zeros((motion.g.shape[1], 2))
    for b in range(first, last):
        for k in range(rows.table.shape[0]):
            at_end = done + k == u_root.shape[0]
            _take_root(u, u_root, done + k - at_end, b)
            robot = command_followers(followers, memories, b, motion.g[b], motion.xi[b], u, scratch)
            if robot >= 0:
                motion.fault[b, 0], motion.fault[b, 1] = LAW_RAISED, robot
                break
            write_row(
                rows, k, b, motion.g[b], motion.xi[b], u, not at_end, memories.tracked[b], motion.telemetry[b],
                memories.law[b],
            )  # fmt: skip
            write_qpos(rows, k, b, motion.qpos[b])
            written[b] = k + 1
            if at_end or motion.lost[b]:
                continue
            if not step_simulation(wheels, place, motion, b, u):
                if not keep_going:
                    break
                lose(motion, b)


@compiled
def command_fleet(
    followers: Followers, memories: Memories, rows: Rows, u_root: np.ndarray, done: int, k: int, written: np.ndarray,
    motion: Motion, u: np.ndarray,
) -> bool:  # fmt: skip
    """Commands the robots of one simulation and writes its row; returns whether a period begins."""
    at_end = done + k == u_root.shape[0]
    _take_root(u, u_root, done + k - at_end, 0)
    robot = command_followers(followers, memories, 0, motion.g[0], motion.xi[0], u, make_scratch())
    if robot >= 0:
        motion.fault[0, 0], motion.fault[0, 1] = LAW_RAISED, robot
        return False
    write_row(
        rows, k, 0, motion.g[0], motion.xi[0], u, not at_end, memories.tracked[0], motion.telemetry[0],
        memories.law[0],
    )  # fmt: skip
    write_qpos(rows, k, 0, motion.qpos[0])
    written[0] = k + 1
    return not at_end and begin(motion, 0, u)


@compiled
def finish_fleet(wheels: Wheels, motion: Motion) -> bool:
    """Reads the state of one simulation at the end of a period; returns whether all went well."""
    return finish(wheels, motion, 0)


@compiled
def run_ideal(
    followers: Followers, memories: Memories, rows: Rows, u_root: np.ndarray, done: int, first: int, last: int,
    written: np.ndarray, integrator: Integrator, flow: Flow,
) -> None:  # fmt: skip
    """Runs the simulations [first, last) through a block of periods on the ideal model; see `run_on_wheels`."""
    scratch = make_scratch()
    u = np.zeros((flow.g.shape[1], 2))
    for b in range(first, last):
        for k in range(rows.table.shape[0]):
            at_end = done + k == u_root.shape[0]
            _take_root(u, u_root, done + k - at_end, b)
            robot = command_followers(followers, memories, b, flow.g[b], flow.xi[b], u, scratch)
            if robot >= 0:
                flow.fault[b, 0], flow.fault[b, 1] = LAW_RAISED, robot
                break
            write_row(
                rows, k, b, flow.g[b], flow.xi[b], u, not at_end, memories.tracked[b], flow.telemetry[b],
                memories.law[b],
            )  # fmt: skip
            written[b] = k + 1
            if not at_end and not step_flow(integrator, flow, b, u):
                break


@compiled
def _take_root(u: np.ndarray, u_root: np.ndarray, k: int, b: int) -> None:
    """Sets the root's accelerations of a period; the others are not known yet."""
    own = b if u_root.shape[1] > 1 else 0
    for i in range(u.shape[0]):
        u[i, 0] = np.nan
        u[i, 1] = np.nan
    u[0, 0] = u_root[k, own, 0]
    u[0, 1] = u_root[k, own, 1]
