"""What a run shows: bars while it works, a table when it is done."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from nhtrack.config.law_sections import LawSection

# Called with the work done and the whole of it.
Report: TypeAlias = Callable[[int, int], None]


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


def make_table(title: str, note: str = "") -> Table:
    """Returns an empty table in the manner of all results, with a note below it."""
    from rich.table import Table

    table = Table(title=title, title_justify="left", title_style="bold", box=None, padding=(0, 1))
    if note:
        add_note(table, note)
    return table


def add_note(table: Table, note: str) -> None:
    """Adds a line below a table."""
    told = [table.caption, note] if isinstance(table.caption, str) else [note]
    table.caption, table.caption_justify = "\n".join(told), "left"
