"""The command `inspect`."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from nhtrack.terminal.app import app
from nhtrack.terminal.screen import rich_table, screen


@app.command("inspect")
def inspect_command(
    robot: Annotated[str, typer.Argument(help="A bundled robot (`nhtrack list`), or an MJCF file.")],
    friction: Annotated[float, typer.Option(min=0.0, help="Of the floor that limits of motion are for.")] = 1.0,
    utilisation: Annotated[float, typer.Option(min=0.01, max=1.0, help="Share of it that wheels may use.")] = 0.5,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON.")] = False,
) -> None:
    """Say what is read from a robot's file: geometry, masses, reduced model, limits of motors and of motion."""
    from nhtrack.studies.inspect.run import inspect

    found = inspect(robot, friction=friction, utilisation=utilisation)
    if as_json:
        typer.echo(json.dumps(found.rows, indent=2, allow_nan=False))
    else:
        screen().print(rich_table(found.table))
