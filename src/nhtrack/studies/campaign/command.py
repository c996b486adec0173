"""The command that tries laws against references from many random starts."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nhtrack.presentation.numbers import cell
from nhtrack.terminal.app import EXIT_INTERRUPTED, app, fail
from nhtrack.terminal.options import Changes, Pdf
from nhtrack.terminal.screen import make_table, print_how_laws_run, progress_bars, screen

if TYPE_CHECKING:
    from rich.console import Console

    from nhtrack.studies.campaign.run import Results


@app.command()
def campaign(
    file: Annotated[str, typer.Argument(help="A campaign file, or a bundled name (`nhtrack list`).")],
    out: Annotated[
        Path | None, typer.Option(help="Results folder; by default runs/campaign-<name>/. One begun is gone on with.")
    ] = None,
    changes: Changes = None,
    tuned_by: Annotated[
        Path | None,
        typer.Option(metavar="DIR", exists=True, file_okay=False, help="Take the gains that this campaign has tuned."),
    ] = None,
    processes: Annotated[int | None, typer.Option(min=1, help="How many at once; by default one a core.")] = None,
    no_figures: Annotated[bool, typer.Option("--no-figures", help="Draw no figures.")] = False,
    pdf: Pdf = False,
    no_report: Annotated[bool, typer.Option("--no-report", help="Write no report.")] = False,
) -> None:
    """Try laws against references from many random starts; stopped, the same command goes on."""
    from nhtrack.experiment.load import load_campaign
    from nhtrack.studies.campaign.run import run_campaign, write_report

    loaded = load_campaign(file, list(changes or []))
    print_how_laws_run(loaded.laws.values())
    folder = out or Path("runs") / f"campaign-{loaded.name}"
    try:
        with progress_bars() as stage:
            results = run_campaign(loaded, folder, stage, processes, tuned_by)
    except KeyboardInterrupt:
        fail(f"interrupted; the same command goes on with what is in {folder}", EXIT_INTERRUPTED)
    _print(results, screen())
    written = list(results.files)
    if not no_figures:
        from nhtrack.studies.campaign.plots import save_campaign_figures

        written += save_campaign_figures(results.runs, results.cells, folder / "figures", pdf=pdf)
    if not no_report:
        written.append(write_report(results, folder))
    for path in written:
        typer.echo(f"wrote {path}")


def _print(results: Results, console: Console) -> None:
    """Prints a table for each law, and the command that repeats its worst run."""
    from nhtrack.presentation.shown import within
    from nhtrack.settling import SettlingLimits

    arrival = results.campaign.arrival
    near = within(SettlingLimits(arrival.position, arrival.heading))
    note = f"converged, settled: {near} of its place until the end, at least over the last {arrival.last:g} s"
    for label in results.campaign.laws:
        table = make_table(f"{label}: {results.campaign.starts.count} starts against each reference", note)
        for heading in ("reference", "converged", "late", "heading", "settled", "at last", "friction", "switches"):
            table.add_column(heading, justify="left" if heading == "reference" else "right")
        rows: list[dict[str, Any]] = results.cells[results.cells["law"] == label].to_dict("records")
        for row in rows:
            table.add_row(*_row(row), style=None if row["share"] == 1 else "yellow")
        console.print(table)
    console.print("The worst run of each law again:", highlight=False)
    for path in results.worst.values():
        console.print(f"  nhtrack run {path}", highlight=False, soft_wrap=True, markup=False)


def _row(row: dict[str, Any]) -> tuple[str, ...]:
    """Returns the cells of a row; of errors, the last time of arrival, utilisation and switches the largest."""
    return (
        row["family"],
        f"{row['converged']}",
        cell(row["late_position_max"], "m"),
        cell(row["late_heading_max"], "rad"),
        cell(row["settling_median"], "s"),
        cell(row["settling_max"], "s"),
        cell(row["utilisation_max"], "%"),
        f"{row['switches_max']:g}",
    )
