"""What a run shows when it is done: tables and lines."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderableType
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


def rich_table(table: ResultTable) -> _Fitted:
    """Returns a table of results in the manner of terminals; a list of its values on a screen too narrow for it."""
    return _Fitted(table)


@dataclass(frozen=True)
class _Fitted:
    table: ResultTable

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[RenderableType]:
        headings, rows = self.table.headings, self.table.rows
        columns = zip(headings, *(row.cells for row in rows), strict=True)
        least = sum(2 + max(len(word) for cell in column for word in cell.split() or [""]) for column in columns)
        yield _as_table(self.table) if least <= options.max_width else _as_list(self.table)


def _as_list(table: ResultTable) -> str:
    """Returns a line for each value, under the first of its row."""
    lines = [f"[bold]{escape(table.title)}[/]"]
    for row in table.rows:
        first, *others = map(escape, row.cells)
        lines += [first, *(f"  {name}: {cell}" for name, cell in zip(table.headings[1:], others, strict=True))]
    return "\n".join([*lines, *map(escape, table.notes)])


def _as_table(table: ResultTable) -> Table:
    from rich.table import Table

    shown = Table(title=escape(table.title), title_justify="left", title_style="bold", box=None, padding=(0, 1))
    for heading in table.headings:
        justify: Literal["left", "right"] = "left" if heading in table.words else "right"
        shown.add_column(escape(heading), justify=justify, no_wrap=heading in table.whole, overflow="fold")
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
