"""The command about the paper as a whole."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

import typer

from nhtrack.terminal.app import app
from nhtrack.terminal.options import Address, Backend, Engine, Pdf, Workers
from nhtrack.terminal.progress import shown_progress


@app.command()
def paper(
    out: Annotated[
        Path | None, typer.Option(help="Results folder; by default a fresh runs/paper-<n>/.")
    ] = None,
    examples: Annotated[str, typer.Option(metavar="N,N...", help="Which examples.")] = "1,2,3,4,5",
    backend: Annotated[Backend, typer.Option(help="ideal leaves MuJoCo out.")] = Backend.mujoco,
    source: Annotated[
        Path | None,
        typer.Option(
            "--from",
            metavar="DIR",
            exists=True,
            file_okay=False,
            help="Redraw what is recorded there; run nothing.",
        ),
    ] = None,
    engine: Engine = "processes",
    address: Address = None,
    processes: Workers = None,
    pdf: Pdf = False,
    no_report: Annotated[bool, typer.Option("--no-report", help="Write no report.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Write into a results folder that exists.")] = False,
) -> None:
    """Run the paper's five examples and draw all of its figures on one page, as Markdown and as a report."""
    if not re.fullmatch(r"\d+(,\d+)*", examples):
        raise typer.BadParameter(f"expected numbers such as 1,4, got {examples!r}", param_hint="--examples")
    from nhtrack.execution import executor_of
    from nhtrack.studies.paper.examples import ExampleError, examples_of
    from nhtrack.studies.paper.run import reproduce

    try:
        wanted = examples_of([int(number) for number in examples.split(",")])
    except ExampleError as error:
        raise typer.BadParameter(str(error), param_hint="--examples") from None
    with shown_progress() as stage:
        written = reproduce(
            wanted,
            out,
            source=source,
            backend=backend.value,
            pdf=pdf,
            report=not no_report,
            overwrite=force,
            stage=stage,
            executor=executor_of(engine, processes, address),
        )
    for file in written:
        typer.echo(f"wrote {file}")
