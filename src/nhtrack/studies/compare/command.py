"""The command that runs one scenario under several laws."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nhtrack.execution import cores
from nhtrack.terminal.app import EXIT_DIVERGED, EXIT_INTERRUPTED, app, fail
from nhtrack.terminal.options import Backend, Changes, Pdf, Trust, load_scenario
from nhtrack.terminal.progress import shown_progress
from nhtrack.terminal.screen import screen

if TYPE_CHECKING:
    from nhtrack.studies.compare.result import Search


@app.command("compare")
def compare_command(
    scenario: Annotated[
        str, typer.Argument(help="A scenario file, a bundled name (`nhtrack list`), or a recording.nc.")
    ],
    laws: Annotated[
        list[str],
        typer.Argument(
            metavar="LAW",
            help="A law's name, '{name: kanayama, k_x: 2}', or a scenario whose law it is (a file, or a recording.nc).",
        ),
    ],
    budget: Annotated[
        int | None, typer.Option("--tune", min=8, metavar="N", help="First search each law's gains, N sets of them.")
    ] = None,
    objective: Annotated[
        str | None, typer.Option(help="What --tune wants, as in `nhtrack tune`; late by default.")
    ] = None,
    backend: Annotated[Backend | None, typer.Option(help="Override the scenario's backend.")] = None,
    changes: Changes = None,
    trust: Trust = False,
    out: Annotated[
        Path | None, typer.Option(help="Results folder; by default a fresh runs/compare-<name>-<n>/.")
    ] = None,
    no_video: Annotated[bool, typer.Option("--no-video", help="Make no film.")] = False,
    no_figures: Annotated[bool, typer.Option("--no-figures", help="Draw no figure.")] = False,
    pdf: Pdf = False,
    no_report: Annotated[bool, typer.Option("--no-report", help="Write no report.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Write into a results folder that exists.")] = False,
) -> None:
    """Run a scenario under several laws, its own among them: a table, one figure, film and report of all.

    Exits with 0 if at least one law completed its run; a law that diverged says so in its row.
    """
    search = _search(budget, objective)
    from nhtrack.config.changes import overrides_of
    from nhtrack.studies.compare.laws_file import load_laws

    overrides, read = overrides_of(set=changes or (), backend=backend), partial(load_scenario, trust=trust)
    loaded, wanted = load_laws(partial(read, scenario, overrides), laws, lambda law: read(law, []))
    from nhtrack.studies.compare.run import compare_laws
    from nhtrack.studies.compare.tables import print_comparison

    made = {"figures": not no_figures, "pdf": pdf, "video": not no_video, "report": not no_report, "overwrite": force}
    with shown_progress() as stage:
        found = compare_laws(loaded, wanted, out, search=search, **made, processes=cores(), stage=stage)
    print_comparison(found, screen())
    if found.interrupted:
        fail("interrupted; what was recorded until then is kept", EXIT_INTERRUPTED)
    if not found.completed:
        fail("diverged: every law did; what was recorded until then is kept", EXIT_DIVERGED)


def _search(budget: int | None, objective: str | None) -> Search | None:
    """Returns how gains are to be searched, or None."""
    from nhtrack.studies.compare.result import search_of
    from nhtrack.studies.tune.objective import ObjectiveError

    try:
        return search_of(budget, objective)
    except ObjectiveError as error:
        raise typer.BadParameter(str(error), param_hint="--objective") from None
