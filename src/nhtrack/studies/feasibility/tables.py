"""What is shown of a scenario's demands: a row for each quantity and robot, and the verdict."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nhtrack.presentation.numbers import cell
from nhtrack.presentation.result_table import ResultTable, TableRow
from nhtrack.terminal.screen import escape, print_line, rich_table

if TYPE_CHECKING:
    from rich.console import Console

    from nhtrack.studies.feasibility.result import Feasibility


def print_feasibility(found: Feasibility, console: Console) -> None:
    """Prints what each robot is asked for, and the verdict."""
    console.print(rich_table(feasibility_table(found)))
    print_line(console, escape(found.verdict))


def feasibility_html(found: Feasibility) -> str:
    """Returns what a notebook shows of a scenario's demands."""
    from nhtrack.presentation.notebook import NotebookView, html_of

    none = [] if found.fitting_time is None else [("smallest time scale that fits", f"{found.fitting_time:g}")]
    given = ("time scale of the scenario", f"{found.scenario.similarity.time_scale:g}")
    view = NotebookView(
        f"{found.scenario.name}: feasibility",
        lead=found.verdict,
        tiles=[given, *none],
        tables=[feasibility_table(found)],
    )
    return html_of(view)


def feasibility_table(found: Feasibility) -> ResultTable:
    """Returns what each robot is asked for; what is beyond its limit is a fault."""
    rows, robot = list[TableRow](), ""
    for row in found.table:
        over = (row["share"] is None and row["limit"] is not None) or (row["share"] or 0.0) > 1
        cells = (
            row["robot"] if row["robot"] != robot else "",
            row["quantity"].replace("_", " "),
            cell(row["value"], row["unit"]),
            cell(row["limit"], row["unit"]),
            cell(row["share"], "%"),
            cell(row["time"], "s"),
            row["wheel"] or "",
        )
        rows.append(TableRow(cells, "fault" if over else ""))
        robot = row["robot"]
    return ResultTable(
        f"{found.scenario.name}: what the motion asks of the robots",
        ("robot", "quantity", "most", "limit", "used", "when", "wheel"),
        tuple(rows),
        frozenset({"robot", "quantity", "wheel"}),
        frozenset({"quantity"}),
    )
