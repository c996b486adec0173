"""Columns of numbers over time in a scenario, or the name of the file that has them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Annotated, Any, TypeAlias

from pydantic import Discriminator, Field

from nhtrack.references.contract import ReferenceInputError
from nhtrack.section import is_bounded

Numbers: TypeAlias = Annotated[tuple[float, ...], Field(strict=False)]
RowFault: TypeAlias = tuple[int, str, str]  # row, counted from 0, column, and message

_LEAST = 1e-9  # from one time to the next: what is divided by less has no end

file_or_columns = Discriminator(lambda value: "<file>" if isinstance(value, str) else "<columns>")


def increasing_faults(times: Sequence[float], name: str = "t") -> Iterator[RowFault]:
    """Yields row, column and message of each time that is not later, by `_LEAST`, than the one before it."""
    for row, (before, now) in enumerate(pairwise(times), start=1):
        if now - before < _LEAST:
            least = "" if now <= before else f" by {_LEAST:g} at least"
            yield row, name, f"times must increase{least}, got {now:.10g} after {before:.10g}"


def require_rows(columns: Mapping[str, Sequence[float]]) -> None:
    """Raises ReferenceInputError unless columns are of one length and their times increase."""
    for row, name, message in column_faults(columns):
        raise ReferenceInputError(f"{name}, row {row + 1}: {message}")


def number_columns(given: Any, names: tuple[str, ...]) -> dict[str, list[float]] | None:
    """Returns raw columns by their names, or None where one is missing or holds anything but finite numbers."""
    if not isinstance(given, Mapping):
        return None
    columns = {name: given.get(name) for name in names}
    sound = all(isinstance(column, (list, tuple)) and all(map(is_bounded, column)) for column in columns.values())
    return {name: list(column) for name, column in columns.items()} if sound else None  # type: ignore[arg-type]


def column_faults(columns: Mapping[str, Sequence[float]]) -> Iterator[RowFault]:
    """Yields row, column and message of what is wrong with columns of numbers over times."""
    for name, column in columns.items():
        if len(column) != len(columns["t"]):
            yield 0, name, f"expected as many numbers as times, {len(columns['t'])}, got {len(column)}"
            return
    if len(columns["t"]) < 2:
        yield 0, "t", "expected at least two rows"
    yield from increasing_faults(columns["t"])
