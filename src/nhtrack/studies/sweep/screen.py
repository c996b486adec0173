"""What a sweep shows: how much it is, and what came of it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import pandas as pd
import typer

from nhtrack.config.changes import value_text
from nhtrack.config.sweep import COLUMNS, METRICS, Sweep
from nhtrack.execution import cores
from nhtrack.presentation.numbers import cell, counted, grouped
from nhtrack.presentation.result_table import ResultTable, TableRow
from nhtrack.studies.sweep.parts import COMPLETED, metric_columns
from nhtrack.studies.sweep.result import SweepResults
from nhtrack.studies.sweep.run import part_size, plan_of, seconds_of, sweep_beforehand
from nhtrack.terminal.screen import print_line, print_warning, rich_table

if TYPE_CHECKING:
    from rich.console import Console

_NUMBER = 10  # [bytes] of the table, about


def print_extent(sweep: Sweep, processes: int | None) -> None:
    """Prints how much a sweep is; nothing is run."""
    plan, workers = plan_of(sweep), processes or cores()
    size, one = part_size(plan), seconds_of(plan)
    columns = len(sweep.axes) + len(COLUMNS) + len(metric_columns(sweep, plan.base))
    disk = 2e-6 * _NUMBER * columns * sweep.runs  # parts, and the whole
    runs = f"{counted(sweep.points, 'point')}, {counted(sweep.runs, 'run')}, {plan.base.backend} backend"
    typer.echo(f"{sweep.name}: {runs}, {counted(math.ceil(sweep.runs / size), 'part')} of at most {size}")
    whole = f"{_time(one * sweep.runs / workers)} with {workers} at once"
    typer.echo(f"about {one:.2g} s a run on one core, {whole}; at most {disk:.2g} MB of disk")
    for warning in sweep_beforehand(plan):
        print_warning(warning)


def _time(seconds: float) -> str:
    named = ((5400.0, 3600.0, "h"), (90.0, 60.0, "min"), (0.0, 1.0, "s"))
    return next(f"{seconds / unit:.2g} {name}" for least, unit, name in named if seconds >= least)


def print_results(results: SweepResults, console: Console) -> None:
    """Prints what came of each metric, how many runs were lost or refused, and the command of its largest."""
    console.print(rich_table(results_table(results)))
    for (outcome, reason), part in not_completed(results.runs):
        print_line(console, f"{outcome}: {counted(len(part), 'run')}, the first {int(part['run'].iloc[0])}: {reason}")


def not_completed(runs: pd.DataFrame, most: int = 5) -> list[tuple[Any, pd.DataFrame]]:
    """Returns the rows of runs that did not end well, by outcome and reason, the most frequent first."""
    groups = runs[runs["outcome"] != COMPLETED].groupby(["outcome", "reason"], sort=False)
    return sorted(groups, key=lambda group: -len(group[1]))[:most]


def results_table(results: SweepResults) -> ResultTable:
    """Returns smallest, median and largest of each metric, and where the smallest and the largest are."""
    rows = tuple(TableRow(_cells(results, name)) for name in results.metrics)
    return ResultTable(
        f"{results.sweep.name}: {grouped(len(results.runs))} runs, {grouped(len(results.completed))} completed",
        ("metric", "smallest", "median", "largest", "smallest at", "largest at"),
        rows,
        frozenset({"metric", "smallest at", "largest at"}),
    )


def _cells(results: SweepResults, name: str) -> tuple[str, ...]:
    known = results.completed[name].dropna()
    if known.empty:
        return (name, "-", "-", "-", "", "")
    texts = (figure_text(float(value), unit_of(name)) for value in (known.min(), known.median(), known.max()))
    places = (_place(results, int(known.idxmin())), _place(results, int(known.idxmax())))
    return (name, *texts, *places)


def figure_text(value: float, unit: str) -> str:
    """Returns a figure as tables have it, with its unit; a plain number where there is none."""
    return cell(value, unit) if unit else f"{value:.3g}"


def _place(results: SweepResults, row: int) -> str:
    values = results.runs.loc[row]
    return " ".join(f"{key}={_short(values[key])}" for key in results.sweep.axes)


def _short(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else value_text(value)


def unit_of(metric: str) -> str:
    """Returns the unit of a metric; none of a number, or of an expression."""
    unit = METRICS.get(metric, "[1]").rpartition("[")[2].partition("]")[0]
    return "" if unit == "1" else unit
