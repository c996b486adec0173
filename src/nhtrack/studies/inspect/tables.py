"""What was read from a robot's file, in tables for terminals and notebooks."""

from __future__ import annotations

from math import isinf
from typing import TYPE_CHECKING

from nhtrack.presentation.numbers import cell
from nhtrack.presentation.result_table import ResultTable, TableRow

if TYPE_CHECKING:
    from nhtrack.studies.inspect.result import Inspection

__all__ = ["inspection_tables"]


def inspection_tables(found: Inspection) -> tuple[ResultTable, ...]:
    """Returns the elements that parts were read from, the numbers, and what the guard found."""
    return _elements(found), _numbers(found), _guard(found)


def _elements(found: Inspection) -> ResultTable:
    rows = tuple(TableRow((part, element)) for part, element in found.reading.sources.items())
    head = ("part", "read from")
    return ResultTable(f"{found.name}: {found.reading.file}", head, rows, frozenset(head))


def _numbers(found: Inspection) -> ResultTable:
    rows, part = list[TableRow](), ""
    for each in found.properties:
        value = "no limit" if isinf(each.value) else cell(each.value, each.unit)
        cells = ("" if each.part == part else each.part, each.name, value, each.source)
        rows.append(TableRow(cells, begins=bool(part) and each.part != part))
        part = each.part
    headings = ("", "property", "value", "from")
    return ResultTable("What follows", headings, tuple(rows), frozenset({"", "property", "from"}))


def _guard(found: Inspection) -> ResultTable:
    rows = tuple(
        TableRow(
            (each.quantity, *(cell(value, each.unit) for value in (each.expected, each.found, each.tolerance))),
            "" if each.holds else "fault",
        )
        for each in found.guard
    )
    headings = ("one robot alone on the floor", "reduced model", "scene", "may differ by")
    return ResultTable("Guard", headings, rows, frozenset(headings[:1]))
