"""What a run shows when it is done: tables and lines."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from nhtrack.config.law_sections import LawSection
    from nhtrack.presentation.result_table import Look, ResultTable


def screen() -> Console:
    """Returns what tables and coloured lines are printed on."""
    from rich.console import Console

    return Console()


def escape(text: str) -> str:
    """Returns a text whose brackets are letters on the screen, not markup."""
    from rich.markup import escape as escaped

    return escaped(text)


def print_how_laws_run(laws: Iterable[LawSection]) -> None:
    """Says on stderr which laws cannot be compiled, and why: what is about to be done takes long."""
    from nhtrack.laws.address import entry_of, runs_as_python

    for law in laws:
        reason = entry_of(law.kind).interpreted
        if reason is not None:
            print_warning(f"law {law.name!r} {runs_as_python(reason)}")


def print_warning(warning: str) -> None:
    """Says on stderr what will go wrong, before it is done."""
    sys.stderr.write(f"warning: {warning}\n")
    sys.stderr.flush()


def rich_table(table: ResultTable) -> Table:
    """Returns a table of results in the manner of terminals."""
    from rich.table import Table

    shown = Table(title=table.title, title_justify="left", title_style="bold", box=None, padding=(0, 1))
    for heading in table.headings:
        justify: Literal["left", "right"] = "left" if heading in table.words else "right"
        shown.add_column(heading, justify=justify, no_wrap=heading in table.whole, overflow="fold")
    for row in table.rows:
        if row.begins:
            shown.add_section()
        cells = (escape(cell) for cell in row.cells)
        marked = [f"[bold]{cell}[/]" if place in row.best else cell for place, cell in enumerate(cells)]
        shown.add_row(*marked, style=_STYLES[row.look])
    if table.notes:
        shown.caption, shown.caption_justify = escape("\n".join(table.notes)), "left"
    return shown


_STYLES: Mapping[Look, str | None] = {"": None, "fault": "bold red", "caution": "yellow", "faint": "dim"}


def print_line(console: Console, line: str) -> None:
    """Prints a line that stays one, however narrow the screen."""
    console.print(line, highlight=False, soft_wrap=True)
