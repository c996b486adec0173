"""What was read from a robot's file, in tables for terminals and notebooks."""

from __future__ import annotations

from collections.abc import Iterable
from math import isinf
from typing import NamedTuple

from nhtrack.presentation.numbers import cell
from nhtrack.presentation.result_table import ResultTable, TableRow
from nhtrack.robots.kind import Reading
from nhtrack.simulation.guard import GuardFigure

__all__ = ["Property", "elements_table", "guard_table", "numbers_table"]


class Property(NamedTuple):
    """A number that is known of a robot.

    Attributes:
        part: what it is a property of.
        name: what it is.
        value: the number, in its unit; infinite where there is no limit.
        unit: its unit; `1` for none.
        source: what it was read from, or follows from.
    """

    part: str
    name: str
    value: float
    unit: str
    source: str


def elements_table(title: str, reading: Reading) -> ResultTable:
    """Returns the elements that parts were read from."""
    rows = tuple(TableRow((part, element)) for part, element in reading.sources.items())
    head = ("part", "read from")
    return ResultTable(title, head, rows, frozenset(head))


def numbers_table(properties: Iterable[Property]) -> ResultTable:
    """Returns the numbers, part by part."""
    rows, part = list[TableRow](), ""
    for each in properties:
        value = "no limit" if isinf(each.value) else cell(each.value, each.unit)
        cells = ("" if each.part == part else each.part, each.name, value, each.source)
        rows.append(TableRow(cells, begins=bool(part) and each.part != part))
        part = each.part
    headings = ("", "property", "value", "from")
    return ResultTable("What follows", headings, tuple(rows), frozenset({"", "property", "from"}))


def guard_table(guard: Iterable[GuardFigure]) -> ResultTable:
    """Returns what the guard found."""
    rows = tuple(
        TableRow(
            (each.quantity, *(cell(value, each.unit) for value in (each.expected, each.found, each.tolerance))),
            "" if each.holds else "fault",
        )
        for each in guard
    )
    headings = ("one robot alone on the floor", "reduced model", "scene", "may differ by")
    return ResultTable("Guard", headings, rows, frozenset(headings[:1]))
