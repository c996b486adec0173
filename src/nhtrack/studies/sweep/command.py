"""The command that runs one scenario many times."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from nhtrack.errors import noting
from nhtrack.terminal.app import app
from nhtrack.terminal.options import Address, Changes, Engine, Pdf, Workers
from nhtrack.terminal.screen import print_warning, screen


@app.command("sweep")
def sweep_command(
    file: Annotated[str, typer.Argument(help="A sweep file, or a bundled name (`nhtrack list`).")],
    out: Annotated[
        Path | None, typer.Option(help="Results folder; by default runs/sweep-<name>/. One begun is gone on with.")
    ] = None,
    changes: Changes = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Tell runs, time, memory and disk; run nothing.")
    ] = False,
    engine: Engine = "processes",
    address: Address = None,
    processes: Workers = None,
    no_figures: Annotated[bool, typer.Option("--no-figures", help="Draw no figures.")] = False,
    pdf: Pdf = False,
    no_report: Annotated[bool, typer.Option("--no-report", help="Write no report.")] = False,
) -> None:
    """Run a scenario with many values of some of its keys; stopped, the same command goes on."""
    from nhtrack.execution import executor_of
    from nhtrack.experiment.load import load_sweep
    from nhtrack.studies.sweep.run import sweep
    from nhtrack.studies.sweep.screen import print_extent, print_results

    loaded = load_sweep(file, list(changes or []))
    if dry_run:
        print_extent(loaded, processes)
        return
    folder = out or Path("runs") / f"sweep-{loaded.name}"
    with noting(f"the same command goes on with what is in {folder}"):
        results = sweep(
            loaded,
            out=folder,
            executor=executor_of(engine, processes, address),
            figures=not no_figures,
            pdf=pdf,
            report=not no_report,
            progress=True,
            tell=print_warning,
        )
    print_results(results, screen())
    for path in results.files:
        typer.echo(f"wrote {path}")
