"""Prints what engines cost, how many runs of a sweep they do on one worker and on two, and what a million would take.

    python benchmarks/sweeps.py [--parts 8] [--seconds 4] [--duration 80] [--engines serial processes ray]

A run is one follower on wheels behind a leader that is a marker, physics step 2 ms, eight of them a part. Ray is one
that is started here. Wall time, from the end of a worker's first part to that of its last: the start of workers is told by
itself. What else runs on the machine takes part of it, so the processor time of a run is told as well: where it is the
same on one worker and on two, the engine lets them work side by side, and the rest is the machine's.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from nhtrack.execution import Executor, Processes, cores, serial
from nhtrack.execution.ray import Ray
from nhtrack.experiment.load import load_sweep
from nhtrack.studies.sweep.parts import part_rows
from nhtrack.studies.sweep.plan import Plan
from nhtrack.studies.sweep.run import plan_of

PART = 8  # runs
EMPTY = 500  # tasks that do nothing
SWEEP = """\
name: bench
base: paper/example1
set: {{duration: {duration}, leader.virtual: true, physics.timestep: 0.002, backend: {backend}}}
axes: {{law.k: {{from: 4, to: 8, count: {runs}}}}}
"""


class Done(NamedTuple):
    """A part: who did it, when it was done [s], and the processor time it took [s]."""

    worker: int
    at: float
    spent: float


def main() -> None:
    verbatim = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=verbatim)
    parser.add_argument("--parts", type=int, default=8, help="of a worker, beside its first")
    parser.add_argument("--seconds", type=float, default=4.0, help="robot seconds of a run")
    parser.add_argument("--duration", type=float, default=80.0, help="robot seconds of the million runs")
    parser.add_argument("--engines", nargs="+", default=["serial", "processes", "ray"])
    given = parser.parse_args()
    engines: dict[str, dict[int, Executor]] = {
        "serial": {1: serial},
        "processes": {workers: Processes(workers, begin=_begin) for workers in (1, 2)},
        "ray": {workers: Ray(None, workers) for workers in (2, 1)},  # of two processors, which one then leaves idle
    }
    print(f"{cores()} cores, load {os.getloadavg()[0]:.1f}")
    _empty({name: engines[name] for name in given.engines})
    costs = {}
    for backend in ("mujoco", "ideal"):
        costs[backend] = _throughput({name: engines[name] for name in given.engines}, given, backend)
    hours = 1e6 * given.duration * costs["mujoco"] / 3600
    print(f"a million runs of {given.duration:g} s on wheels: {hours:.0f} processor hours", end="")
    print("".join(f", {hours / 16 / k:.1f} h on {k} machines of 16" for k in (1, 4, 16, 64)))


def _empty(engines: dict[str, dict[int, Executor]]) -> None:
    print("engine     workers  start [s]  empty task [ms]")
    for name, by_workers in engines.items():
        for workers, executor in by_workers.items():
            began, ends = time.monotonic(), []
            for _ in executor(range(EMPTY), _nothing):
                ends.append(time.monotonic())
            task = (ends[-1] - ends[EMPTY // 5]) / (EMPTY - EMPTY // 5)
            print(f"{name:10} {workers:7} {ends[0] - began:10.1f} {1e3 * task:16.3f}")


def _throughput(engines: dict[str, dict[int, Executor]], given: argparse.Namespace, backend: str) -> float:
    """Prints what engines do of a sweep, and returns the least processor time of a robot-second [s]."""
    duration = given.seconds * (1 if backend == "mujoco" else 10)
    print(f"{backend}, runs of {duration:g} s")
    print("engine     workers  runs/s  over one  processor share  [ms/run]  over one  [us/robot-second]")
    least = np.inf
    for name, by_workers in engines.items():
        rates, costs = {}, {}
        for workers, executor in sorted(by_workers.items()):
            plan = _plan(duration, backend, PART * (given.parts + 1) * workers)
            done = [each for _, each in executor(list(plan.parts(PART)), partial(_part, plan))]
            kept = list(_after_the_first(done))
            rates[workers] = sum(PART * len(each) / (each[-1].at - first) for first, each in kept)
            spent = sum(part.spent for _, each in kept for part in each)
            wall = sum(each[-1].at - first for first, each in kept)
            costs[workers] = spent / (PART * sum(len(each) for _, each in kept))
            least = min(least, costs[workers] / duration)
            print(
                f"{name:10} {workers:7} {rates[workers]:7.2f} {rates[workers] / rates[1]:9.2f} {spent / wall:16.2f} "
                f"{1e3 * costs[workers]:9.2f} {costs[workers] / costs[1]:9.2f} {1e6 * costs[workers] / duration:18.0f}"
            )
    return float(least)


def _plan(duration: float, backend: str, runs: int) -> Plan:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "bench.yaml"
        file.write_text(SWEEP.format(duration=duration, backend=backend, runs=runs))
        return plan_of(load_sweep(file))


def _part(plan: Plan, runs: np.ndarray) -> Done:
    before = time.process_time()
    part_rows(plan, runs)
    return Done(os.getpid(), time.monotonic(), time.process_time() - before)


def _after_the_first(done: list[Done]) -> Iterator[tuple[float, list[Done]]]:
    """Yields for each worker when its first part was done, and the others."""
    for worker in sorted({part.worker for part in done}):
        first, *others = sorted((part for part in done if part.worker == worker), key=lambda part: part.at)
        if others:
            yield first.at, others


def _nothing(task: int) -> None:
    pass


def _begin() -> None:
    """Does nothing: what is begun so has a process of its own, also if it is one."""


if __name__ == "__main__":
    main()
    sys.stdout.flush()
