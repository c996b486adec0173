"""The command `feasibility`."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from nhtrack.terminal.app import app
from nhtrack.terminal.options import Changes, Trust, load_scenario
from nhtrack.terminal.screen import print_how_laws_run, screen


@app.command("feasibility")
def feasibility_command(
    scenario: Annotated[
        str, typer.Argument(help="A scenario file, a bundled name (`nhtrack list`), or a recording.nc.")
    ],
    changes: Changes = None,
    trust: Trust = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON.")] = False,
) -> None:
    """Say from the ideal run alone what a scenario asks of wheels and motors, and the time scale that fits."""
    loaded = load_scenario(scenario, list(changes or []), trust=trust)
    print_how_laws_run([loaded.law])
    from nhtrack.studies.feasibility.run import feasibility
    from nhtrack.studies.feasibility.tables import print_feasibility

    found = feasibility(loaded, progress=True)
    if as_json:
        typer.echo(json.dumps(found.table, indent=2, allow_nan=False))
    else:
        print_feasibility(found, screen())
