"""The command `run`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from nhtrack.execution import cores
from nhtrack.terminal.app import EXIT_DIVERGED, EXIT_INTERRUPTED, app, fail
from nhtrack.terminal.options import Backend, Changes, Pdf, Trust, load_scenario
from nhtrack.terminal.progress import shown_progress
from nhtrack.terminal.screen import print_warning, screen


@app.command("run")
def run_command(
    scenario: Annotated[
        str, typer.Argument(help="A scenario file, a bundled name (`nhtrack list`), or a recording.nc.")
    ],
    out: Annotated[Path | None, typer.Option(help="Results folder; by default a fresh runs/<name>-<n>/.")] = None,
    backend: Annotated[Backend | None, typer.Option(help="Override the scenario's backend.")] = None,
    seed: Annotated[int | None, typer.Option(help="Override the scenario's seed.")] = None,
    changes: Changes = None,
    trust: Trust = False,
    no_video: Annotated[bool, typer.Option("--no-video", help="Make no film.")] = False,
    no_figures: Annotated[bool, typer.Option("--no-figures", help="Draw no figures.")] = False,
    pdf: Pdf = False,
    no_report: Annotated[bool, typer.Option("--no-report", help="Write no report.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Write into a results folder that exists.")] = False,
) -> None:
    """Run a scenario: summary, recording, figures, film and report in a fresh folder."""
    from nhtrack.config.changes import overrides_of

    loaded = load_scenario(scenario, overrides_of(set=changes or (), backend=backend, seed=seed), trust=trust)
    from nhtrack.studies.run.run import run_scenario
    from nhtrack.studies.run.tables import print_outcome

    made = {"figures": not no_figures, "pdf": pdf, "video": not no_video, "report": not no_report}
    told: list[str] = []

    def tell(warning: str) -> None:
        print_warning(warning)
        told.append(warning)

    with shown_progress() as stage:
        outcome = run_scenario(loaded, out, overwrite=force, **made, processes=cores(), stage=stage, tell=tell)
    print_outcome(outcome, screen(), told)
    if outcome.failure is not None:
        fail(f"diverged: {outcome.failure}; what was recorded until then is kept", EXIT_DIVERGED)
    if outcome.recording.outcome == "interrupted":
        fail("interrupted; what was recorded until then is kept", EXIT_INTERRUPTED)
