"""What a comparison of laws shows: how they did, the gains that were found, what there is to say of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from nhtrack.presentation.numbers import cell, seconds
from nhtrack.presentation.result_table import ResultTable, TableRow
from nhtrack.presentation.shown import settled_note
from nhtrack.settling import settling_limits
from nhtrack.studies.compare.ranking import MEASURES, Standing, best
from nhtrack.terminal.screen import escape, print_line, rich_table

if TYPE_CHECKING:
    from rich.console import Console

    from nhtrack.studies.compare.result import Comparison

_WARNINGS = 12  # on the screen: more would push the tables off it


def print_comparison(found: Comparison, console: Console) -> None:
    """Prints how the laws did, the gains that were found, what there is to say of it, and where its files are."""
    for table in comparison_tables(found):
        console.print(rich_table(table))
    for line in tuned_lines(found):
        print_line(console, f"tuned: {line}")
    for note in found.notes:
        print_line(console, f"note: {escape(note)}")
    for warning in found.warnings[:_WARNINGS]:
        print_line(console, f"[yellow]warning:[/] {escape(warning)}")
    if len(found.warnings) > _WARNINGS:
        print_line(console, f"and {len(found.warnings) - _WARNINGS} more warnings in comparison.json")
    for reason in found.skipped:
        print_line(console, f"[yellow]left out:[/] {escape(reason)}")
    for file in found.files:
        print_line(console, f"wrote {escape(str(file))}")


def comparison_tables(found: Comparison) -> list[ResultTable]:
    """Returns how the laws tracked, and what they asked for."""
    title = f"{found.scenario.name}: the worst follower of each law"
    note = settled_note(settling_limits(found.scenario.similarity.length))
    asked = "Gap to the ideal twin, and what was asked of wheels"
    return [_table(title, found, _TRACKING, note, outcome=True), _table(asked, found, _ASKING)]


def tuned_lines(found: Comparison) -> list[str]:
    """Returns the gains that were found for each law, and their cost, in a line each."""
    lines = []
    for label, tuning in found.tunings.items():
        gains = ", ".join(f"{name} {gain:g}" for name, gain in tuning.gains.items())
        cost = f"cost {cell(tuning.cost_before, '1')} -> {cell(tuning.cost, '1')}"
        lines.append(f"{label}: {gains} ({cost})")
    return lines


# What the tables show of a law, by measure.
_TRACKING = ("late_position_error", "late_heading_error", "settling_time")
_ASKING = ("gap_position_rms", "peak_utilisation", "torque_saturation_share", "effort_x", "effort_theta")


def _table(
    title: str, found: Comparison, measures: Sequence[str], *notes: str, outcome: bool = False
) -> ResultTable:
    """Returns a table with a row for each law, the best value of each column marked, and how its run ended."""
    standings = found.standings
    first, rows = best(standings), list[TableRow]()
    for place, law in enumerate(standings):
        cells = tuple(cell(getattr(law, measure), MEASURES[measure].unit) for measure in measures)
        marked = frozenset(i for i, measure in enumerate(measures, start=1) if first.get(measure) == place)
        ended = (_outcome(law),) if outcome else ()
        rows.append(TableRow((law.label, *cells, *ended), "" if law.completed else "faint", marked))
    headings = ("law", *(MEASURES[measure].heading for measure in measures), *(("outcome",) if outcome else ()))
    return ResultTable(title, headings, tuple(rows), frozenset({"law", "outcome"}), frozenset({"law"}), notes)


def _outcome(law: Standing) -> str:
    """Returns how a run ended, and when, if not as it should."""
    kind = law.outcome.split(":")[0]
    return kind if law.completed else f"{kind} at {seconds(law.end)}"
