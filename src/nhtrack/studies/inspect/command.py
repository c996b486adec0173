"""The command `inspect`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from nhtrack.terminal.app import EXIT_SCENARIO, app, fail
from nhtrack.terminal.options import Pdf
from nhtrack.terminal.screen import print_line, rich_table, screen


@app.command("inspect")
def inspect_command(
    robot: Annotated[
        str, typer.Argument(help="A bundled robot (`nhtrack list`), an MJCF or URDF file, or a folder with one.")
    ],
    wheels: Annotated[
        str, typer.Option(metavar="LEFT,RIGHT", help="Joints of the driven wheels, for a file without actuators.")
    ] = "",
    casters: Annotated[
        str, typer.Option(metavar="JOINT,...", help="Joints of wheels that are not driven and slide as casters.")
    ] = "",
    forward: Annotated[
        str, typer.Option(metavar="AXIS", help="Axis of the base that points ahead: x, -x, y or -y (--forward=-x).")
    ] = "",
    pose: Annotated[str, typer.Option(metavar="KEY", help="The file's key in whose pose arms are held.")] = "",
    friction: Annotated[float, typer.Option(min=0.0, help="Of the floor that limits of motion are for.")] = 1.0,
    utilisation: Annotated[float, typer.Option(min=0.01, max=1.0, help="Share of it that wheels may use.")] = 0.5,
    figure: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the robot from above and from the side: .png or .pdf.")
    ] = None,
    pdf: Pdf = False,
    write: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write a commented scenario to start from with this robot.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print all of it as JSON.")] = False,
) -> None:
    """Say what is read from a robot's file, from which elements, what is left out, and what its limits are."""
    from nhtrack.studies.inspect.run import inspect

    found = inspect(
        robot, wheels=_names(wheels), casters=_names(casters), forward=forward, pose=pose, friction=friction,
        utilisation=utilisation,
    )  # fmt: skip
    if as_json:
        typer.echo(json.dumps(found.summary, indent=2, allow_nan=False))
    else:
        for table in found.tables:
            screen().print(rich_table(table))
        for note in found.notes:
            print_line(screen(), f"note: {note}")
    for path in found.save_figure(figure, pdf=pdf) if figure else ():
        typer.echo(f"wrote {path}", err=as_json)
    if write:
        typer.echo(f"wrote {found.write_scenario(write)}; run it with: nhtrack run {write}", err=as_json)
    if found.faults:
        fail("error: " + "\n".join(found.faults), EXIT_SCENARIO)


def _names(listed: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in listed.split(",") if name.strip())
