"""The command that measures how close wheels come to the ideal robot."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nhtrack.presentation.result_table import Look, ResultTable, TableRow
from nhtrack.terminal.app import EXIT_ERROR, app
from nhtrack.terminal.options import Address, Engine, Workers
from nhtrack.terminal.progress import shown_progress
from nhtrack.terminal.screen import rich_table, screen

if TYPE_CHECKING:
    from rich.console import Console

    from nhtrack.studies.fidelity.bench import Finding


@app.command()
def fidelity(
    robots: Annotated[
        list[str] | None,
        typer.Option(
            "--robot", metavar="ROBOT", help="A bundled robot or an MJCF file; repeatable. All bundled ones by default."
        ),
    ] = None,
    checks: Annotated[
        list[str] | None, typer.Option("--check", metavar="NAME", help="One check by name; repeatable.")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Only what takes a few seconds.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the findings as JSON.")] = False,
    out: Annotated[Path | None, typer.Option(help="Results folder; by default a fresh runs/fidelity-<n>/.")] = None,
    no_report: Annotated[bool, typer.Option("--no-report", help="Write nothing: neither report nor table.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Write into a results folder that exists.")] = False,
    engine: Engine = "processes",
    address: Address = None,
    processes: Workers = None,
) -> None:
    """Measure robots against mechanics and the ideal model; exit 1 where a budget is broken and nothing explains it."""
    from nhtrack.errors import did_you_mean
    from nhtrack.execution import executor_of
    from nhtrack.experiment.compile import compile_once
    from nhtrack.files.folder import claimed_folder
    from nhtrack.simulation.robot_models import load_robot
    from nhtrack.studies.fidelity.suite import CHECKS, QUICK, run_suite, save, tasks

    for name in checks or ():
        if name not in CHECKS:
            raise typer.BadParameter(f"no check {name!r}; {did_you_mean(name, CHECKS)}", param_hint="--check")
    for robot in robots or ():
        load_robot(robot)  # a misspelt one is told before anything is measured
    wanted = tasks(robots, checks or (QUICK if quick else None))
    executor = executor_of(engine, processes, address)
    claimed = contextlib.nullcontext() if no_report else claimed_folder("fidelity", out, force)
    with claimed as folder:
        with shown_progress() as stage:
            compile_once(stage)
            findings = run_suite(wanted, stage("fidelity"), executor)
        if as_json:
            typer.echo(json.dumps([finding.row for finding in findings], indent=2, allow_nan=False))
        else:
            _print(findings, screen())
        for file in save(findings, wanted, folder) if folder is not None else ():
            typer.echo(f"wrote {file}", err=as_json)  # JSON is told alone
    if not all(finding.ok or finding.explained for finding in findings):
        raise typer.Exit(EXIT_ERROR)


def _print(findings: list[Finding], console: Console) -> None:
    """Prints a table for each robot, and what broken budgets are made of."""
    for robot in dict.fromkeys(finding.robot for finding in findings):
        console.print(rich_table(_table(robot, [each for each in findings if each.robot == robot])))
    broken = [finding for finding in findings if not finding.ok]
    for finding in broken:
        console.print(f"{finding.robot}, {finding.check}: {finding.cause}", markup=False, soft_wrap=True)
    if any(finding.explained for finding in broken):
        console.print("explained: see docs/fidelity.md", highlight=False)
    console.print(f"{len(findings) - len(broken)} of {len(findings)} budgets kept", highlight=False)


def _table(robot: str, findings: list[Finding]) -> ResultTable:
    """Returns the findings of a robot against their budgets."""
    rows = []
    for finding in findings:
        bound = f"{'<=' if finding.sense == 'at most' else '>='} {finding.budget:g}"
        unit = finding.unit if finding.unit != "1" else ""
        verdict, look = _verdict(finding)
        rows.append(TableRow((finding.check, f"{finding.value:.2g}", bound, unit, verdict), look))
    headings = ("check", "measured", "budget", "unit", "")
    return ResultTable(robot, headings, tuple(rows), frozenset({"check", "unit", ""}))


def _verdict(finding: Finding) -> tuple[str, Look]:
    """Returns a word for a finding and the look of its row."""
    if finding.ok:
        return "ok", ""
    return ("explained", "caution") if finding.explained else ("broken", "fault")
