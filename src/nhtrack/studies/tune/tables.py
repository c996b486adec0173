"""What a search of gains shows: gains and what they leave, before and after, and the search in a line."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nhtrack.presentation.numbers import cell
from nhtrack.presentation.result_table import ResultTable, TableRow
from nhtrack.presentation.shown import settled_note
from nhtrack.settling import settling_limits
from nhtrack.terminal.screen import escape, print_line, rich_table

if TYPE_CHECKING:
    from rich.console import Console

    from nhtrack.studies.tune.result import Tuning


def print_tuning(found: Tuning, console: Console) -> None:
    """Prints the table of a search, and the search in a line."""
    console.print(rich_table(tuning_table(found)))
    print_line(console, escape(found.account))


def tuning_html(found: Tuning) -> str:
    """Returns what a notebook shows of a search."""
    from nhtrack.presentation.notebook import NotebookView, html_of

    view = NotebookView(
        f"{found.scenario.name}: tuning",
        lead=f"{found.account}.",
        tables=[tuning_table(found)],
        notes=[f"What the gains leave: {found.leaves}."],
    )
    return html_of(view)


def tuning_table(found: Tuning) -> ResultTable:
    """Returns the gains and what they leave, before and after."""
    before, after = found.figures_before, found.figures
    gains = [TableRow((name, f"{found.gains_before[name]:g}", f"{gain:g}")) for name, gain in found.gains.items()]
    figures = [
        ("late error / path", before.late_position, after.late_position, "%"),
        ("late heading error", before.late_heading, after.late_heading, "rad"),
        ("settled after, of the run", before.settling, after.settling, "%"),
        ("peak friction utilisation", before.utilisation, after.utilisation, "%"),
        ("time scale needed, of given", before.pace, after.pace, "%"),
        ("cost", found.cost_before, found.cost, "1"),
    ]
    rows = [
        TableRow((meaning, cell(old, unit), cell(new, unit)), begins=place == 0)
        for place, (meaning, old, new, unit) in enumerate(figures)
    ]
    title = f"{found.scenario.name}: gains of the {found.scenario.law.name} law"
    note = settled_note(settling_limits(found.scenario.similarity.length))
    return ResultTable(title, ("", "before", "found"), (*gains, *rows), frozenset({""}), notes=(note,))
