"""What a run prints: tables of its figures, warnings, and where its files are."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from nhtrack.presentation.numbers import cell, degrees, seconds
from nhtrack.terminal.screen import add_note, escape, make_table

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from nhtrack.studies.run.run import Outcome

_ROWS = 12  # of a table: more would push what matters off the screen


def print_outcome(outcome: Outcome, console: Console) -> None:
    """Prints the figures of a run, its warnings, and where its files are."""
    console.print(_followers_table(outcome.summary))
    console.print(_robots_table(outcome.summary))
    if outcome.summary["events"]:
        console.print(_events_table(outcome.summary["events"]))
    for warning in outcome.summary.get("warnings", ()):
        console.print(f"[yellow]warning:[/] {escape(warning)}", highlight=False, soft_wrap=True)
    for reason in outcome.skipped:
        console.print(f"[yellow]left out:[/] {escape(reason)}", highlight=False, soft_wrap=True)
    for file in outcome.files:
        console.print(f"wrote {file}", highlight=False, soft_wrap=True, markup=False)


def _followers_table(summary: dict[str, Any]) -> Table:
    from nhtrack.presentation.shown import settled_note
    from nhtrack.settling import SettlingLimits

    note = settled_note(SettlingLimits(**summary["settling_limits"]))
    table = make_table(f"{summary['name']}: what each follower makes of its leader", note)
    for heading in ("follower", "start", "final", "final heading", "late", "late heading", "settled"):
        table.add_column(heading, justify="left" if heading == "follower" else "right")
    for name, figures in _worst(table, summary["followers"], "late_position_error", "largest late errors"):
        table.add_row(
            name,
            cell(figures["initial_position_error"], "m"),
            cell(figures["final_position_error"], "m"),
            cell(figures["final_heading_error"], "rad"),
            cell(figures["late_position_error"], "m"),
            cell(figures["late_heading_error"], "rad"),
            cell(figures["settling_time"], "s"),
        )
    return table


def _robots_table(summary: dict[str, Any]) -> Table:
    table = make_table("How far wheels and ideal twin part, and what the floor had to do")
    for heading in ("robot", "path", "gap RMS", "gap max", "friction used", "torque at limit"):
        table.add_column(heading, justify="left" if heading == "robot" else "right")
    for name, figures in _worst(table, summary["robots"], "peak_utilisation", "highest use of friction"):
        table.add_row(
            name,
            cell(figures["path_length"], "m"),
            cell(figures["gap_position_rms"], "m"),
            cell(figures["gap_position_max"], "m"),
            cell(figures["peak_utilisation"], "%"),
            cell(figures["torque_saturation_share"], "%"),
        )
    return table


def _worst(table: Table, rows: dict[str, Any], figure: str, called: str) -> list[tuple[str, Any]]:
    """Returns the rows of a table of robots: all, or of a crowd the worst, of which the table's caption tells."""
    if len(rows) <= _ROWS:
        return list(rows.items())
    worst = sorted(rows.items(), key=lambda row: math.inf if row[1][figure] is None else row[1][figure], reverse=True)
    add_note(table, f"the {called} of {len(rows)}; all are in summary.json")
    return worst[:_ROWS]


def _events_table(events: list[dict[str, Any]]) -> Table:
    table = make_table("What went wrong on wheels")
    for heading in ("event", "robot", "wheel", "from", "to", "how bad"):
        table.add_column(heading, justify="right" if heading in ("from", "to") else "left")
    for event in events[:_ROWS]:
        table.add_row(
            event["kind"],
            escape(event["robot"]),
            event["wheel"] or "-",
            seconds(event["start"]),
            seconds(event["end"]),
            f"{event['measure']} {_how_bad(event)}",
        )
    if len(events) > _ROWS:
        add_note(table, f"and {len(events) - _ROWS} more in summary.json")
    return table


def _how_bad(event: dict[str, Any]) -> str:
    """Returns the figure of an event as people read it: shares in per cent, angles in degrees."""
    worst, unit = event["worst"], event["unit"]
    if unit == "rad":
        return "-" if worst is None else degrees(worst)
    return cell(worst, "%" if unit == "1" else unit)
