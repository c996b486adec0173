"""The loop in which a simulation and a law meet.

Every control period: the root takes its input; then, parents before children, each follower's law sees the follower and
what it tracks (pose, twist, and the acceleration commanded this period) and commands its own; the simulation holds all
commands for the period. Many periods are one call of compiled code, which knows the law by an address only.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from nhtrack.errors import SimulationDiverged
from nhtrack.experiment.failures import failure_of, require_begun
from nhtrack.experiment.followers import (
    Followers,
    Memories,
    Scratch,
    Tracking,
    make_followers,
    make_memories,
    make_scratch,
)
from nhtrack.experiment.kernels import Block, CompiledSimulation, command_fleet, finish_fleet, run_ideal, run_on_wheels
from nhtrack.experiment.link import Link
from nhtrack.experiment.recorder import FullRecorder, KeepingRecorder, Recorder, Shape
from nhtrack.laws.law import Law
from nhtrack.network import Network
from nhtrack.simulation.engine import roll_units
from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.state import State
from nhtrack.stopping import heard

Progress = Callable[[int, int], None]

_FIRST_BLOCK = 8  # control periods of the first call of compiled code
_PAUSE = 0.1  # [s] how long a call may last, so that progress is told and Ctrl-C is heard


@dataclass(frozen=True)
class Rollout:
    """What a loop leaves behind.

    Attributes:
        time: times [s], shape (t,): the start and the end of every period that was finished.
        variables: arrays of shape (t, ..., n, components) by the names of `nhtrack.recording.VARIABLES`, or what is
            read as such, a part at a time.
        qpos: MuJoCo's configuration, shape (t, ..., nq), or None.
        failure: why the run ended early, or None.
        interrupted: whether the user stopped it.
        every: every so many control periods there is a row, and one at the end.
    """

    time: np.ndarray
    variables: Mapping[str, Any]
    qpos: np.ndarray | None
    failure: SimulationDiverged | None = None
    interrupted: bool = False
    every: int = 1

    def require_whole(self) -> None:
        """Raises what ended the run early.

        Raises:
            KeyboardInterrupt: the user stopped it.
            SimulationDiverged: it diverged, or its law raised an exception.
        """
        if self.interrupted:
            raise KeyboardInterrupt
        if self.failure is not None:
            raise self.failure


def rollout(
    simulation: CompiledSimulation,
    law: Law,
    network: Network,
    inputs: np.ndarray,
    start: State,
    tracking: Tracking | None = None,
    progress: Progress | None = None,
    recorder: KeepingRecorder | None = None,
    every: int = 1,
    link: Link | None = None,
) -> Rollout:
    """Returns the run of a network under a law, every row of it.

    A run that diverges, or that the user interrupts after its first rows, ends early and keeps what it has.

    Args:
        simulation: what moves the robots.
        law: what every follower obeys.
        network: who tracks whom.
        inputs: accelerations (u_x, u_theta) of the root for each period, shape (periods, 2) or (periods, b, 2).
        start: the state to begin with, shapes (n, 3) or (b, n, 3).
        tracking: how what a follower tracks is made from its parents; as printed, without offsets, by default.
        progress: called with the periods done and their number.
        recorder: what keeps the rows; one that keeps them in memory by default.
        every: every so many control periods a row is kept, and the end of the run.
        link: what lies between robots and their laws; nothing by default.

    Raises:
        LawError: the law raised an exception before the run began.
    """
    recorder, interrupted, failure = recorder or FullRecorder(), False, None
    try:
        failure = run_loop(simulation, law, network, inputs, start, recorder, tracking, progress, every, link=link)
    except KeyboardInterrupt:
        if not recorder.count:
            raise
        heard()
        interrupted = True
    variables, qpos = recorder.kept(batch=start.g.ndim > 2)
    return Rollout(recorder.time, variables, qpos, failure, interrupted, every)


def run_loop(
    simulation: CompiledSimulation,
    law: Law,
    network: Network,
    inputs: np.ndarray,
    start: State,
    recorder: Recorder,
    tracking: Tracking | None = None,
    progress: Progress | None = None,
    every: int = 1,
    threads: int = 1,
    link: Link | None = None,
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
        every: every so many control periods a row is kept.
        threads: among which an ideal batch is divided; one on wheels has its own.
        link: see `rollout`.
    """
    simulation.reset(start)
    followers = make_followers(network, tracking or Tracking(), law, simulation.dt, link or Link())
    # a copy in one piece: numba would compile the loop anew for memory of another order, or that must not be written to
    u_root = np.array(inputs if inputs.ndim == 3 else inputs[:, None], dtype=float, order="C")
    count, n = simulation.motion.g.shape[:2]
    shape = Shape(
        periods=len(u_root),
        simulations=count,
        robots=n,
        telemetry=simulation.measured,
        memory=law.kind.memory_size,
        qpos=simulation.motion.qpos.shape[1:],
        dt=simulation.dt,
        start=start.t,
        every=every,
        touch=simulation.motion.touch.shape[1] > 0,
    )
    recorder.begin(shape)
    memories = make_memories(followers, law, count)
    threads = len(simulation.places) if isinstance(simulation, MujocoSimulation) else max(1, min(threads, count))
    scratch = [make_scratch(n) for _ in range(threads)]
    require_begun(law, followers, memories, simulation)
    with ThreadPoolExecutor(threads) as pool:
        return _Loop(simulation, law, followers, memories, u_root, recorder, shape, pool, scratch).run(progress)


@dataclass(frozen=True)
class _Loop:
    """A run that has begun; see `run_loop`."""

    simulation: CompiledSimulation
    law: Law
    followers: Followers
    memories: Memories
    u_root: np.ndarray
    recorder: Recorder
    shape: Shape
    pool: ThreadPoolExecutor
    scratch: list[Scratch]

    def run(self, progress: Progress | None) -> SimulationDiverged | None:
        """Runs block by block of control periods; returns why it ended early, or None."""
        periods, shape = self.shape.periods, self.shape
        done, size = 0, _FIRST_BLOCK
        while done <= periods:
            count = min(size, self.recorder.room, periods + 1 - done)
            first, last = shape.row_of(done), shape.row_after(done + count)
            written = np.zeros(shape.simulations, dtype=np.int64)
            block = Block(done, count, shape.every, self.recorder.space(first, last - first), written, self.u_root)
            began = time.perf_counter()
            self._advance(block)
            kept = int(written.min())
            rows = shape.row_after(done + kept) - first
            self.recorder.add(first, rows)
            failure = failure_of(self.simulation, self.law, self.followers, self.memories, done + written)
            if failure is not None:
                return failure
            done += kept
            if progress is not None:
                progress(min(done, periods), periods)
            size = max(1, round(kept * min(8.0, _PAUSE / max(time.perf_counter() - began, 1e-6))))
        return None

    def _advance(self, block: Block) -> None:
        """Runs a block; compiled code lets other threads run beside it."""
        simulation = self.simulation
        if isinstance(simulation, MujocoSimulation) and simulation.is_fleet:
            self._advance_fleet(simulation, block)
            return
        shares = self._shares(self.shape.simulations)
        if len(shares) == 1:
            self._advance_share(block, 0, *shares[0])
        else:
            list(self.pool.map(lambda share: self._advance_share(block, share[0], *share[1]), enumerate(shares)))

    def _shares(self, count: int) -> list[tuple[int, int]]:
        """Returns [first, last) of what each thread does."""
        ends = np.linspace(0, count, len(self.scratch) + 1).astype(int)
        return [(int(first), int(last)) for first, last in pairwise(ends)]

    def _advance_share(self, block: Block, share: int, first: int, last: int) -> None:
        """Runs the simulations [first, last) through a block."""
        simulation = self.simulation
        shared = (self.followers, self.memories, block, first, last, self.scratch[share])
        if isinstance(simulation, MujocoSimulation):
            wheels, place = simulation.wheels, simulation.places[share]
            run_on_wheels(*shared, simulation.motion, wheels, place, simulation.keep_going)
        else:
            run_ideal(*shared, simulation.motion, simulation.integrator)

    def _advance_fleet(self, simulation: MujocoSimulation, block: Block) -> None:
        """Runs one simulation of many small models through a block: commands at once, models over threads."""
        wheels, motion, places = simulation.wheels, simulation.motion, simulation.places
        shares = self._shares(simulation.units)
        for k in range(block.periods):
            if not command_fleet(self.followers, self.memories, block, k, self.scratch[0], motion):
                return
            futures = [
                self.pool.submit(roll_units, wheels, place, motion, 0, *share)
                for place, share in zip(places[1:], shares[1:], strict=True)
            ]
            roll_units(wheels, places[0], motion, 0, *shares[0])
            for future in futures:
                future.result()
            if not finish_fleet(wheels, motion):
                return
