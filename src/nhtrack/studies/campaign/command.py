"""The command that tries laws against references from many random starts."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from nhtrack.errors import noting
from nhtrack.terminal.app import app
from nhtrack.terminal.options import Address, Changes, Engine, Pdf, Workers
from nhtrack.terminal.screen import print_how_laws_run, print_warning, screen


@app.command("campaign")
def campaign_command(
    file: Annotated[str, typer.Argument(help="A campaign file, or a bundled name (`nhtrack list`).")],
    out: Annotated[
        Path | None, typer.Option(help="Results folder; by default runs/campaign-<name>/. One begun is gone on with.")
    ] = None,
    changes: Changes = None,
    tuned_by: Annotated[
        Path | None,
        typer.Option(metavar="DIR", exists=True, file_okay=False, help="Take the gains that this campaign has tuned."),
    ] = None,
    engine: Engine = "processes",
    address: Address = None,
    processes: Workers = None,
    no_figures: Annotated[bool, typer.Option("--no-figures", help="Draw no figures.")] = False,
    pdf: Pdf = False,
    no_report: Annotated[bool, typer.Option("--no-report", help="Write no report.")] = False,
) -> None:
    """Try laws against references from many random starts; stopped, the same command goes on."""
    from nhtrack.execution import executor_of
    from nhtrack.experiment.load import load_campaign
    from nhtrack.studies.campaign.run import campaign
    from nhtrack.studies.campaign.screen import print_results

    loaded = load_campaign(file, list(changes or []))
    print_how_laws_run(loaded.laws.values())
    folder = out or Path("runs") / f"campaign-{loaded.name}"
    with noting(f"the same command goes on with what is in {folder}"):
        results = campaign(
            loaded,
            out=folder,
            tuned_by=tuned_by,
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
