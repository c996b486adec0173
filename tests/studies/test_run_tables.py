"""What a run prints of few robots and of many."""

from __future__ import annotations

import io
from typing import Any

import pytest
from rich.console import Console

from nhtrack.presentation.result_table import ResultTable, TableRow
from nhtrack.studies.run.tables import followers_table
from nhtrack.terminal.screen import rich_table

FIGURES = (
    "initial_position_error", "final_position_error", "final_heading_error", "late_position_error",
    "late_heading_error", "settling_time",
)  # fmt: skip


def printed(errors: dict[str, float | None]) -> list[str]:
    summary: dict[str, Any] = {
        "name": "run",
        "settling_limits": {"position": 0.001, "heading": 0.02},
        "followers": {name: dict.fromkeys(FIGURES, 0.5) | {"late_position_error": e} for name, e in errors.items()},
    }
    console = Console(width=130)
    with console.capture() as screen:
        console.print(rich_table(followers_table(summary)))
    return [line.split()[0] for line in screen.get().splitlines()[2:] if line.strip()]


def test_few_robots_have_a_row_each_in_their_order() -> None:
    rows = printed({f"f{k}": 0.1 * k for k in range(12)})
    assert rows[:13] == [*(f"f{k}" for k in range(12)), "settled:"]


@pytest.mark.parametrize("unknown", [None, 99.0])
def test_of_many_robots_the_worst_are_shown_and_the_table_says_so(unknown: float | None) -> None:
    rows = printed({f"f{k}": 0.1 * k for k in range(40)} | {"lost": unknown})
    assert rows[:13] == ["lost", *(f"f{k}" for k in range(39, 28, -1)), "settled:"]
    assert rows[-1] == "the"


@pytest.mark.parametrize("name", ["[red]x[-]", "[/]", "[bold", "[link=x]y[/link]", "\\[red]x", "a]b["])
def test_names_are_no_markup_of_the_terminal(name: str) -> None:
    table = ResultTable(name, (name, "figure"), (TableRow((name, "1")),), notes=(name,))
    console = Console(width=200, file=io.StringIO(), force_terminal=False)
    console.print(rich_table(table))
    assert console.file.getvalue().count(name) == 4


@pytest.mark.parametrize("width", [20, 40])
def test_a_screen_too_narrow_for_a_table_gets_a_line_for_each_value(width: int) -> None:
    rows = tuple(TableRow((f"follower{k}", f"{k} mm", "[i]")) for k in range(2))
    table = ResultTable("what was measured", ("robot", "start", "of the floor's friction"), rows)
    console = Console(width=width, file=io.StringIO(), force_terminal=False)
    console.print(rich_table(table))
    lines = [line.strip() for line in console.file.getvalue().splitlines()]
    assert ("start: 1 mm" in lines) == (width == 20)
    assert " ".join(lines).count("[i]") == 2
    assert max(map(len, lines)) <= width
