"""The command that runs one scenario under several laws."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nhtrack.execution import cores
from nhtrack.presentation.numbers import cell, seconds
from nhtrack.terminal.app import EXIT_DIVERGED, EXIT_INTERRUPTED, app, fail
from nhtrack.terminal.options import Backend, Changes, Pdf, load_scenario
from nhtrack.terminal.screen import (
    add_note,
    escape,
    make_table,
    progress_bars,
    screen,
)

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from nhtrack.config.schema import Scenario
    from nhtrack.studies.compare.ranking import Standing
    from nhtrack.studies.compare.result import Comparison, Search

_WARNINGS = 12  # on the screen: more would push the tables off it


@app.command()
def compare(
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
    overrides = list(changes or [])
    overrides += [f"backend={backend.value}"] if backend is not None else []
    from nhtrack.studies.compare.laws_file import load_laws

    loaded, wanted = load_laws(lambda: load_scenario(scenario, overrides), laws, _read)
    from nhtrack.studies.compare.run import compare as study

    made = {"figures": not no_figures, "pdf": pdf, "video": not no_video, "report": not no_report}
    with progress_bars() as stage:
        found = study(loaded, wanted, out, search=search, overwrite=force, **made, processes=cores(), stage=stage)
    _print_comparison(found, screen())
    if found.interrupted:
        fail("interrupted; what was recorded until then is kept", EXIT_INTERRUPTED)
    if not found.completed:
        fail("diverged: every law did; what was recorded until then is kept", EXIT_DIVERGED)


def _read(source: str) -> Scenario:
    return load_scenario(source, [])


def _search(budget: int | None, objective: str | None) -> Search | None:
    """Returns how gains are to be searched, or None."""
    if budget is None:
        if objective is not None:
            raise typer.BadParameter("says what --tune wants; add --tune N", param_hint="--objective")
        return None
    from nhtrack.studies.compare.result import Search
    from nhtrack.studies.tune.objective import Objective, ObjectiveError

    try:
        return Search(Objective.parse(objective or "late"), budget)
    except ObjectiveError as error:
        raise typer.BadParameter(str(error), param_hint="--objective") from None


def _print_comparison(found: Comparison, console: Console) -> None:
    """Prints how the laws did, the gains that were found, what there is to say of it, and where its files are."""
    from nhtrack.presentation.shown import settled_note
    from nhtrack.settling import settling_limits

    title = f"{found.scenario.name}: the worst follower of each law"
    tracking = _table(title, found, _TRACKING, outcome=True)
    add_note(tracking, settled_note(settling_limits(found.scenario.similarity.length)))
    console.print(tracking)
    console.print(_table("Gap to the ideal twin, and what was asked of wheels", found, _ASKING))
    for label, tuning in found.tunings.items():
        gains = ", ".join(f"{name} {gain:g}" for name, gain in tuning.gains.items())
        cost = f"cost {cell(tuning.cost_before, '1')} -> {cell(tuning.cost, '1')}"
        _print_line(console, f"tuned: {label}: {gains} ({cost})")
    for note in found.notes:
        _print_line(console, f"note: {escape(note)}")
    for warning in found.warnings[:_WARNINGS]:
        _print_line(console, f"[yellow]warning:[/] {escape(warning)}")
    if len(found.warnings) > _WARNINGS:
        _print_line(console, f"and {len(found.warnings) - _WARNINGS} more warnings in comparison.json")
    for reason in found.skipped:
        _print_line(console, f"[yellow]left out:[/] {escape(reason)}")
    for file in found.files:
        _print_line(console, f"wrote {escape(str(file))}")


def _print_line(console: Console, line: str) -> None:
    """Prints a line that stays one, however narrow the screen."""
    console.print(line, highlight=False, soft_wrap=True)


# What the tables show of a law, by measure.
_TRACKING = ("late_position_error", "late_heading_error", "settling_time")
_ASKING = ("gap_position_rms", "peak_utilisation", "torque_saturation_share", "effort_x", "effort_theta")


def _table(title: str, found: Comparison, measures: Sequence[str], *, outcome: bool = False) -> Table:
    """Returns a table with a row for each law, the best value of each column in bold, and how its run ended."""
    from nhtrack.studies.compare.ranking import MEASURES, best

    standings = found.standings
    first, table = best(standings), make_table(title)
    table.add_column("law", no_wrap=True)
    for measure in measures:
        table.add_column(MEASURES[measure].heading, justify="right")
    if outcome:
        table.add_column("outcome")
    for place, law in enumerate(standings):
        cells = [(cell(getattr(law, each), MEASURES[each].unit), first.get(each) == place) for each in measures]
        bold = [f"[bold]{text}[/]" if is_best else text for text, is_best in cells]
        ended = [_outcome(law)] if outcome else []
        table.add_row(law.label, *bold, *ended, style=None if law.completed else "dim")
    return table


def _outcome(law: Standing) -> str:
    """Returns how a run ended, and when, if not as it should."""
    kind = law.outcome.split(":")[0]
    return kind if law.completed else f"{kind} at {seconds(law.end)}"
