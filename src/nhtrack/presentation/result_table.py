"""Tables of results, whatever shows them: terminals, notebooks."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

Look = Literal["", "fault", "caution", "faint"]


@dataclass(frozen=True)
class TableRow:
    """A row of a table.

    Attributes:
        cells: what is written, under each heading.
        look: `fault` or `caution` where something is wrong, `faint` for what counts less.
        best: places of the cells that are the best of their column.
        begins: whether it begins a part of the table.
    """

    cells: tuple[str, ...]
    look: Look = ""
    best: frozenset[int] = frozenset()
    begins: bool = False


@dataclass(frozen=True)
class ResultTable:
    """A table of results.

    Attributes:
        title: what it is of.
        headings: of its columns.
        rows: its rows.
        words: headings of the columns that hold words; the others hold figures and are aligned to the right.
        whole: headings of the columns whose cells stay in one line.
        notes: sentences below it, a line each.
    """

    title: str
    headings: tuple[str, ...]
    rows: tuple[TableRow, ...]
    words: frozenset[str] = field(default=frozenset())
    whole: frozenset[str] = field(default=frozenset())
    notes: tuple[str, ...] = ()
