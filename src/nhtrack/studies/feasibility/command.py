"""The command `feasibility`."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated

import typer

from nhtrack.presentation.numbers import cell
from nhtrack.terminal.app import app
from nhtrack.terminal.options import Changes, load_scenario
from nhtrack.terminal.screen import (
    escape,
    make_table,
    print_how_laws_run,
    progress_bars,
    screen,
)

if TYPE_CHECKING:
    from rich.console import Console

    from nhtrack.studies.feasibility.run import Feasibility


@app.command()
def feasibility(
    scenario: Annotated[
        str, typer.Argument(help="A scenario file, a bundled name (`nhtrack list`), or a recording.nc.")
    ],
    changes: Changes = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON.")] = False,
) -> None:
    """Say from the ideal run alone what a scenario asks of wheels and motors, and the time scale that fits."""
    loaded = load_scenario(scenario, list(changes or []))
    from nhtrack.experiment.compile import compile_once
    print_how_laws_run([loaded.law])
    from nhtrack.studies.feasibility.run import feasibility as study

    with progress_bars() as stage:
        compile_once(stage)
        found = study(loaded, stage("ideal runs"))
    if as_json:
        typer.echo(json.dumps(found.table, indent=2, allow_nan=False))
    else:
        _print_feasibility(found, screen())


def _print_feasibility(found: Feasibility, console: Console) -> None:
    """Prints what each robot is asked for, and the verdict."""
    table = make_table(f"{found.scenario.name}: what the motion asks of the robots")
    for heading in ("robot", "quantity", "most", "limit", "used", "when", "wheel"):
        words = heading in ("robot", "quantity", "wheel")
        table.add_column(heading, justify="left" if words else "right", no_wrap=heading == "quantity")
    robot = ""
    for row in found.table:
        over = (row["share"] is None and row["limit"] is not None) or (row["share"] or 0.0) > 1
        table.add_row(
            row["robot"] if row["robot"] != robot else "",
            row["quantity"].replace("_", " "),
            cell(row["value"], row["unit"]),
            cell(row["limit"], row["unit"]),
            cell(row["share"], "%"),
            cell(row["time"], "s"),
            row["wheel"] or "",
            style="bold red" if over else None,
        )
        robot = row["robot"]
    console.print(table)
    console.print(escape(found.verdict), highlight=False, soft_wrap=True)
