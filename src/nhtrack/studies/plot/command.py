"""The command `plot`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from nhtrack.terminal.app import app
from nhtrack.terminal.options import Pdf


@app.command("plot")
def plot_command(
    recording: Annotated[Path, typer.Argument(help="A recording.nc that a run left.")],
    out: Annotated[
        Path | None, typer.Option(help="Folder of the figures; by default figures/ beside the recording.")
    ] = None,
    only: Annotated[list[str] | None, typer.Option(metavar="NAME", help="One figure by name; repeatable.")] = None,
    pdf: Pdf = False,
) -> None:
    """Draw the figures of a recording anew; nothing is simulated again."""
    from nhtrack.studies.plot.run import plot

    drawn = plot(recording, only or None)
    for path in drawn.save(out or recording.parent / "figures", pdf=pdf):
        typer.echo(f"wrote {path}")
