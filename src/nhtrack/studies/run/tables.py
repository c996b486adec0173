"""What a run shows: tables of its figures, warnings, and where its files are."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any

from nhtrack.presentation.numbers import cell, degrees, row_of, seconds
from nhtrack.presentation.result_table import ResultTable, TableRow
from nhtrack.presentation.shown import settled_note
from nhtrack.settling import SettlingLimits
from nhtrack.terminal.screen import escape, print_line, rich_table

if TYPE_CHECKING:
    from rich.console import Console

    from nhtrack.studies.run.result import Outcome

_ROWS = 12  # of a table: more would push what matters off the screen


def print_outcome(outcome: Outcome, console: Console, told: Collection[str] = ()) -> None:
    """Prints the figures of a run, its notes and warnings but for those told before, and where its files are."""
    for table in run_tables(outcome.summary):
        console.print(rich_table(table))
    for note in outcome.notes:
        print_line(console, f"note: {escape(note)}")
    for warning in (each for each in outcome.warnings if each not in told):
        print_line(console, f"[yellow]warning:[/] {escape(warning)}")
    for reason in outcome.skipped:
        print_line(console, f"[yellow]left out:[/] {escape(reason)}")
    for file in outcome.files:
        console.print(f"wrote {file}", highlight=False, soft_wrap=True, markup=False)


def run_tables(summary: dict[str, Any]) -> list[ResultTable]:
    """Returns the tables of a run's figures: followers, robots, and events where there are any."""
    tables = [followers_table(summary), _robots_table(summary)]
    return tables + ([_events_table(summary["events"])] if summary["events"] else [])


# Figures and their units, as the columns of a table.
_TRACKING: Mapping[str, str] = {
    "initial_position_error": "m",
    "final_position_error": "m",
    "final_heading_error": "rad",
    "late_position_error": "m",
    "late_heading_error": "rad",
    "settling_time": "s",
}
_ON_WHEELS: Mapping[str, str] = {
    "path_length": "m",
    "gap_position_rms": "m",
    "gap_position_max": "m",
    "peak_utilisation": "%",
    "torque_saturation_share": "%",
}


def followers_table(summary: dict[str, Any]) -> ResultTable:
    """Returns how near each follower came to its leader; of many the worst."""
    rows, left_out = _worst(summary["followers"], "late_position_error", "largest late errors")
    return ResultTable(
        f"{summary['name']}: what each follower makes of its leader",
        ("follower", "start", "final", "final heading", "late", "late heading", "settled"),
        tuple(TableRow((name, *row_of(figures, _TRACKING))) for name, figures in rows),
        frozenset({"follower"}),
        notes=(settled_note(SettlingLimits(**summary["settling_limits"])), *left_out),
    )


def _robots_table(summary: dict[str, Any]) -> ResultTable:
    rows, left_out = _worst(summary["robots"], "peak_utilisation", "highest use of friction")
    return ResultTable(
        "How far wheels and ideal twin part, and what the floor had to do",
        ("robot", "path", "gap RMS", "gap max", "friction used", "torque at limit"),
        tuple(TableRow((name, *row_of(figures, _ON_WHEELS))) for name, figures in rows),
        frozenset({"robot"}),
        notes=(*_compared(summary["twin_compared_until"]), *left_out),
    )


def _compared(until: float | None) -> tuple[str, ...]:
    """Returns the note of a table that has gaps to ideal twins up to a time [s] only."""
    if until is None:
        return ()
    return (f"gaps are until {seconds(until)}, when robots first touched: ideal twins pass through",)


def _worst(rows: dict[str, Any], figure: str, called: str) -> tuple[list[tuple[str, Any]], tuple[str, ...]]:
    """Returns the rows of a table of robots, all or of a crowd the worst, and the note that tells of it."""
    if len(rows) <= _ROWS:
        return list(rows.items()), ()
    worst = sorted(rows.items(), key=lambda row: math.inf if row[1][figure] is None else row[1][figure], reverse=True)
    return worst[:_ROWS], (f"the {called} of {len(rows)}; all are in summary.json",)


def _events_table(events: list[dict[str, Any]]) -> ResultTable:
    rows = tuple(
        TableRow(
            (
                event["kind"],
                _who(event),
                event["wheel"] or "-",
                seconds(event["start"]),
                seconds(event["end"]),
                f"{event['measure']} {_how_bad(event)}",
            )
        )
        for event in events[:_ROWS]
    )
    more = (f"and {len(events) - _ROWS} more in summary.json",) if len(events) > _ROWS else ()
    headings = ("event", "robot", "wheel", "from", "to", "how bad")
    words = frozenset({"event", "robot", "wheel", "how bad"})
    return ResultTable("What went wrong on wheels", headings, rows, words, notes=more)


def _who(event: dict[str, Any]) -> str:
    """Returns whom an event is of."""
    return f"{event['robot']}, {event['touch']['other']}" if event["touch"] else str(event["robot"])


def _how_bad(event: dict[str, Any]) -> str:
    """Returns the figure of an event as people read it: shares in per cent, angles in degrees."""
    worst, unit = event["worst"], event["unit"]
    if unit == "rad":
        return "-" if worst is None else degrees(worst)
    return cell(worst, "%" if unit == "1" else unit)
