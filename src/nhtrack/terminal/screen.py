"""What a run shows: bars while it works, a table when it is done."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from nhtrack.config.law_sections import LawSection
    from nhtrack.studies.run.run import Outcome

# Called with the work done and the whole of it.
Report: TypeAlias = Callable[[int, int], None]

_EVENTS = 12  # rows of the table of events: more would push what matters off the screen


def cores() -> int:
    """Returns how many processes work side by side where nothing else is said."""
    return os.cpu_count() or 1


def screen() -> Console:
    """Returns what tables and coloured lines are printed on."""
    from rich.console import Console

    return Console()


def escape(text: str) -> str:
    """Returns a text whose brackets are letters on the screen, not markup."""
    from rich.markup import escape as escaped

    return escaped(text)


@contextmanager
def progress_bars() -> Iterator[Callable[[str], Report]]:
    """Shows bars on stderr while work goes on; yields what opens a bar by its name."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    columns = TextColumn("{task.description:12}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn()
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bars:

        def stage(name: str) -> Report:
            task = bars.add_task(name, total=None)

            def report(done: int, total: int) -> None:
                bars.update(task, completed=done, total=total)

            return report

        yield stage


def print_how_laws_run(laws: Iterable[LawSection]) -> None:
    """Says on stderr which laws cannot be compiled, and why: what is about to be done takes long."""
    for law in laws:
        reason = law.kind.entry.interpreted
        if reason is not None:
            from nhtrack.laws.address import runs_as_python

            sys.stderr.write(f"warning: law {law.name!r} {runs_as_python(reason)}\n")


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
    table = make_table(f"{summary['name']}: what each follower makes of its leader")
    for heading in ("follower", "start", "final", "final heading", "late", "late heading", "settled"):
        table.add_column(heading, justify="left" if heading == "follower" else "right")
    for name, figures in summary["followers"].items():
        table.add_row(
            name,
            show_metres(figures["initial_position_error"]),
            show_metres(figures["final_position_error"]),
            show_quantity(figures["final_heading_error"], "rad"),
            show_metres(figures["late_position_error"]),
            show_quantity(figures["late_heading_error"], "rad"),
            show_quantity(figures["settling_time"], "s"),
        )
    return table


def _robots_table(summary: dict[str, Any]) -> Table:
    table = make_table("How far wheels and ideal twin part, and what the floor had to do")
    for heading in ("robot", "path", "gap RMS", "gap max", "friction used", "torque at limit"):
        table.add_column(heading, justify="left" if heading == "robot" else "right")
    for name, figures in summary["robots"].items():
        table.add_row(
            name,
            show_metres(figures["path_length"]),
            show_metres(figures["gap_position_rms"]),
            show_metres(figures["gap_position_max"]),
            show_share(figures["peak_utilisation"]),
            show_share(figures["torque_saturation_share"]),
        )
    return table


def _events_table(events: list[dict[str, Any]]) -> Table:
    table = make_table("What went wrong on wheels")
    for heading in ("event", "robot", "wheel", "from", "to", "how bad"):
        table.add_column(heading, justify="right" if heading in ("from", "to") else "left")
    for event in events[:_EVENTS]:
        table.add_row(
            event["kind"],
            escape(event["robot"]),
            event["wheel"] or "-",
            f"{event['start']:.2f} s",
            f"{event['end']:.2f} s",
            f"{event['measure']} {_how_bad(event)}",
        )
    if len(events) > _EVENTS:
        table.caption, table.caption_justify = f"and {len(events) - _EVENTS} more in summary.json", "left"
    return table


def _how_bad(event: dict[str, Any]) -> str:
    """Returns the figure of an event as people read it: shares in per cent, angles in degrees."""
    match event["unit"]:
        case "1":
            return show_share(event["worst"])
        case "rad":
            return show_quantity(None if event["worst"] is None else math.degrees(event["worst"]), "degrees")
        case unit:
            return show_quantity(event["worst"], unit)


def make_table(title: str) -> Table:
    """Returns an empty table in the manner of all results."""
    from rich.table import Table

    return Table(title=title, title_justify="left", title_style="bold", box=None, padding=(0, 1))


def show_metres(value: float | None) -> str:
    """Returns a length in the unit that reads best."""
    if value is None:
        return "-"
    if value >= 1.0:
        return f"{value:.3g} m"
    return f"{1e3 * value:.3g} mm" if value >= 1e-6 else f"{value:.1e} m"


def show_quantity(value: float | None, unit: str) -> str:
    """Returns a number to three digits with its unit, `-` where there is none."""
    return "-" if value is None else f"{value:.3g} {unit}".rstrip()


def show_share(value: float | None) -> str:
    """Returns a share in per cent, `-` where there is none."""
    return "-" if value is None else f"{100 * value:.3g} %"
