"""All measurements of all robots, side by side in processes."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import NamedTuple, TypeAlias

from nhtrack import assets
from nhtrack.errors import SimulationDiverged
from nhtrack.rollout import Progress
from nhtrack.study.fidelity import closed_loop, conservation, friction, model, open_loop, slip
from nhtrack.study.fidelity.bench import Bench, Finding

Check: TypeAlias = Callable[[Bench], Iterator[Finding]]

CHECKS: dict[str, Check] = {
    check.__name__: check
    for check in (
        model.reduced_model,
        model.accelerations,
        model.load_shares,
        open_loop.open_loop,
        open_loop.planar_base,
        slip.turning_slip,
        slip.creep,
        slip.ice,
        friction.friction_limits,
        friction.stopping_distance,
        conservation.energy,
        conservation.coasting,
        conservation.rest,
        conservation.symmetry,
        conservation.determinism,
        closed_loop.closed_loop,
    )
}
QUICK = ("reduced_model", "accelerations", "load_shares", "turning_slip", "creep", "friction_limits")
_LONGEST_FIRST = ("closed_loop", "open_loop")  # so that no process ends long after the others


class Task(NamedTuple):
    """One check of one robot."""

    robot: str
    check: str


def tasks(robots: Iterable[str] | None = None, checks: Iterable[str] | None = None) -> list[Task]:
    """Returns every check of every robot, in the order of the table; all bundled robots and all checks by default."""
    chosen = tuple(CHECKS) if checks is None else tuple(checks)
    return [Task(robot, check) for robot in robots or assets.robots() for check in chosen]


def measure(task: Task) -> tuple[Finding, ...]:
    """Returns the findings of a task; a robot that diverges has a single one, which is not ok.

    Raises:
        RobotError: no such robot, or not one that can be driven.
    """
    bench = Bench(task.robot)
    try:
        return tuple(CHECKS[task.check](bench))
    except SimulationDiverged as error:
        return (bench.find(task.check.replace("_", " "), float("inf"), "1", 0.0, f"diverged: {error}"),)


def run(wanted: list[Task], progress: Progress | None = None, processes: int | None = None) -> list[Finding]:
    """Returns the findings of tasks, in their order, measured in as many processes as there are cores.

    Args:
        wanted: what to measure.
        progress: called with the tasks done and their number.
        processes: how many at once.
    """
    order = sorted(wanted, key=lambda task: task.check not in _LONGEST_FIRST)
    found: dict[Task, tuple[Finding, ...]] = {}
    workers = min(processes or os.cpu_count() or 1, len(wanted))
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        futures = {pool.submit(measure, task): task for task in order}
        for done, future in enumerate(as_completed(futures), start=1):
            found[futures[future]] = future.result()
            if progress is not None:
                progress(done, len(wanted))
    return [finding for task in wanted for finding in found[task]]
