"""Commands that study a scenario before it is run: feasibility, tune."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.markup import escape

from nhtrack.cli.app import app
from nhtrack.cli.results import load_scenario
from nhtrack.cli.screen import make_table, progress_bars, show_quantity, show_share

if TYPE_CHECKING:
    from nhtrack.study.feasibility import Feasibility

Changes = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Override any key: law.kp=3. Repeatable.")
]


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
    from nhtrack.study.feasibility import feasibility as study

    with progress_bars() as stage:
        found = study(loaded, stage("ideal runs"))
    if as_json:
        typer.echo(json.dumps(found.table, indent=2, allow_nan=False))
    else:
        _print_feasibility(found, Console())


def _print_feasibility(found: Feasibility, console: Console) -> None:
    """Prints what each robot is asked for, and the verdict."""
    table = make_table(f"{found.scenario.name}: what the motion asks of the robots")
    for heading in ("robot", "quantity", "most", "limit", "used", "when", "wheel"):
        words = heading in ("robot", "quantity", "wheel")
        table.add_column(heading, justify="left" if words else "right", no_wrap=heading == "quantity")
    robot = ""
    for row in found.table:
        unit = "" if row["unit"] == "1" else row["unit"]
        over = (row["share"] is None and row["limit"] is not None) or (row["share"] or 0.0) > 1
        table.add_row(
            row["robot"] if row["robot"] != robot else "",
            row["quantity"].replace("_", " "),
            show_quantity(row["value"], unit),
            show_quantity(row["limit"], unit),
            show_share(row["share"]),
            show_quantity(row["time"], "s"),
            row["wheel"] or "",
            style="bold red" if over else None,
        )
        robot = row["robot"]
    console.print(table)
    console.print(escape(found.verdict), highlight=False, soft_wrap=True)
