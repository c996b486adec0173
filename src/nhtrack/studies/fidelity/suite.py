"""All measurements of all robots, side by side in processes."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple, TypeAlias

from nhtrack import assets
from nhtrack.analysis.machines import ready
from nhtrack.errors import SimulationDiverged
from nhtrack.execution import Executor, Processes
from nhtrack.experiment.loop import Progress
from nhtrack.files.folder import save_json
from nhtrack.recording.versions import versions
from nhtrack.simulation.robot_models import full_name
from nhtrack.studies.fidelity import (
    casters,
    closed_loop,
    collision,
    conservation,
    friction,
    losses,
    model,
    open_loop,
    slip,
)
from nhtrack.studies.fidelity.bench import Bench, Finding

Check: TypeAlias = Callable[[Bench], Iterator[Finding]]

CHECKS: dict[str, Check] = {
    check.__name__: check
    for check in (
        model.reduced_model,
        model.accelerations,
        model.load_shares,
        open_loop.open_loop,
        open_loop.planar_base,
        casters.swivel_casters,
        slip.turning_slip,
        slip.creep,
        slip.ice,
        friction.friction_limits,
        friction.stopping_distance,
        losses.coasting_down,
        conservation.energy,
        conservation.coasting,
        conservation.rest,
        conservation.symmetry,
        conservation.determinism,
        collision.collisions,
        closed_loop.closed_loop,
    )
}
GROUPS = {
    model: "Reduced model against MuJoCo's dynamics",
    casters: "Casters that swivel: a drive without a law against a model of casters that roll",
    open_loop: "Open loop: a drive without a law against an independent integrator",
    slip: "Slip and creep of tyres",
    friction: "Limits of friction",
    losses: "Losses at the wheel joints",
    conservation: "Conservation, symmetry, repeatability",
    collision: "Robots that touch",
    closed_loop: "Closed loop: the paper's examples against their ideal twins",
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
        found = tuple(CHECKS[task.check](bench))
    except SimulationDiverged as error:
        found = (bench.find(task.check.replace("_", " "), float("inf"), "1", 0.0, f"diverged: {error}"),)
    return tuple(replace(finding, group=_group_of(task.check)) for finding in found)


def _group_of(check: str) -> str:
    """Returns what the findings of a check are told together with: that of the module it is in."""
    names = {module.__name__: group for module, group in GROUPS.items()}
    return names.get(CHECKS[check].__module__, "")


def run_suite(
    wanted: list[Task], progress: Progress | None = None, executor: Executor | None = None
) -> list[Finding]:
    """Returns the findings of tasks, in their order.

    Args:
        wanted: what to measure.
        progress: called with the tasks done and their number.
        executor: what measures; processes, one for each core, by default.

    Raises:
        EngineError, MachineError: the executor cannot be had, or its machines are not like this one.
    """
    order = sorted(wanted, key=lambda task: task.check not in _LONGEST_FIRST)
    there = [task._replace(robot=full_name(task.robot)) for task in order]  # a worker may be in another folder
    executor = ready(executor or Processes(), None, [task.robot for task in there])
    found: dict[Task, tuple[Finding, ...]] = {}
    for place, findings in executor(there, measure):
        found[order[place]] = tuple(replace(each, robot=order[place].robot) for each in findings)
        if progress is not None:
            progress(len(found), len(wanted))
    return [finding for task in wanted for finding in found[task]]


def save(findings: Sequence[Finding], wanted: Sequence[Task], folder: Path) -> list[Path]:
    """Writes the findings of tasks into a folder, as `findings.json` and as a report, and returns the files."""
    from nhtrack.studies.fidelity.report import write_fidelity_page

    rows = [finding.row for finding in findings]
    table = save_json(folder / "findings.json", rows)
    return [table, write_fidelity_page(rows, command(wanted), versions(), folder / "report.html")]


def command(wanted: Sequence[Task]) -> str:
    """Returns the command that measures tasks."""
    robots, checks = (list(dict.fromkeys(names)) for names in zip(*wanted, strict=True))
    words = [word for robot in robots for word in ("--robot", robot)]
    words += [] if checks == list(CHECKS) else [word for check in checks for word in ("--check", check)]
    return shlex.join(["nhtrack", "fidelity", *words])
