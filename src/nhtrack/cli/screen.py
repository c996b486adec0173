"""What a run shows: bars while it works, a table when it is done."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeAlias

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn
from rich.table import Table

if TYPE_CHECKING:
    from nhtrack.study.run import Outcome

# Called with the work done and the whole of it.
Report: TypeAlias = Callable[[int, int], None]

_REDRAWS = 200  # a bar moves at most this often, so that reporting costs nothing beside a control period


@contextmanager
def progress_bars() -> Iterator[Callable[[str], Report]]:
    """Shows bars on stderr while work goes on; yields what opens a bar by its name."""
    columns = TextColumn("{task.description:12}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn()
    with Progress(*columns, console=Console(stderr=True), transient=True) as bars:

        def stage(name: str) -> Report:
            task = bars.add_task(name, total=None)

            def report(done: int, total: int) -> None:
                if done == total or done % max(1, total // _REDRAWS) == 0:
                    bars.update(task, completed=done, total=total)

            return report

        yield stage


def print_outcome(outcome: Outcome, console: Console) -> None:
    """Prints the figures of a run, its warnings, and where its files are."""
    console.print(_followers_table(outcome.summary))
    console.print(_robots_table(outcome.summary))
    for warning in outcome.summary.get("warnings", ()):
        console.print(f"[yellow]warning:[/] {escape(warning)}", highlight=False, soft_wrap=True)
    for reason in outcome.skipped:
        console.print(f"[yellow]left out:[/] {escape(reason)}", highlight=False, soft_wrap=True)
    for file in outcome.files:
        console.print(f"wrote {file}", highlight=False, soft_wrap=True, markup=False)


def _followers_table(summary: dict[str, Any]) -> Table:
    table = _table(f"{summary['name']}: what each follower makes of its leader")
    for heading in ("follower", "start", "final", "final heading", "late", "late heading", "settled"):
        table.add_column(heading, justify="left" if heading == "follower" else "right")
    for name, figures in summary["followers"].items():
        table.add_row(
            name,
            _metres(figures["initial_position_error"]),
            _metres(figures["final_position_error"]),
            _quantity(figures["final_heading_error"], "rad"),
            _metres(figures["late_position_error"]),
            _quantity(figures["late_heading_error"], "rad"),
            _quantity(figures["settling_time"], "s"),
        )
    return table


def _robots_table(summary: dict[str, Any]) -> Table:
    table = _table("How far wheels and ideal twin part, and what the floor had to do")
    for heading in ("robot", "path", "gap RMS", "gap max", "friction used", "torque at limit"):
        table.add_column(heading, justify="left" if heading == "robot" else "right")
    for name, figures in summary["robots"].items():
        table.add_row(
            name,
            _metres(figures["path_length"]),
            _metres(figures["gap_position_rms"]),
            _metres(figures["gap_position_max"]),
            _percent(figures["peak_utilisation"]),
            _percent(figures["torque_saturation_share"]),
        )
    return table


def _table(title: str) -> Table:
    return Table(title=title, title_justify="left", title_style="bold", box=None, padding=(0, 1))


def _metres(value: float | None) -> str:
    """Returns a length in the unit that reads best."""
    if value is None:
        return "-"
    if value >= 1.0:
        return f"{value:.3g} m"
    return f"{1e3 * value:.3g} mm" if value >= 1e-6 else f"{value:.1e} m"


def _quantity(value: float | None, unit: str) -> str:
    return "-" if value is None else f"{value:.3g} {unit}"


def _percent(value: float | None) -> str:
    return "-" if value is None else f"{100 * value:.3g} %"
