"""The leader's input as a CSV file."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

from pydantic import Field

from nhtrack.references.contract import InputSection, Reference
from nhtrack.references.table import Interpolation

CSV_COLUMNS = ("t", "u_x", "u_theta")


class CsvInput(InputSection):
    """The leader's input from a file; loading turns it into a table, so a recording carries the numbers."""

    key: ClassVar[str] = "csv"
    words: ClassVar[str] = "a csv file"
    csv: str = Field(
        min_length=1,
        description="CSV file with the columns t, u_x, u_theta named in its first line, found relative to the scenario",
    )
    interpolation: Interpolation = Field(
        default="previous", description="hold each row until the next, or join rows by lines"
    )

    @classmethod
    def resolved(cls, given: Mapping[str, Any], directory: Path) -> Mapping[str, Any]:
        """Returns a raw section with the file's columns as a table."""
        if not isinstance(given["csv"], str) or not given["csv"]:
            return given  # the section's own fault, told by its model
        rest = {key: value for key, value in given.items() if key != "csv"}
        return {"table": read_table(directory / given["csv"]), **rest}

    def reference(self) -> Reference:
        """Raises TypeError: loading makes a table of it."""
        raise TypeError("a CSV input becomes a table when the scenario is loaded; load it with nhtrack.load")


def read_table(path: Path) -> dict[str, list[float]]:
    """Returns the columns t, u_x, u_theta of a CSV file whose first line names them.

    Raises:
        ValueError: no such file, columns missing, no rows, or a cell that is not a number.
    """
    if not path.is_file():
        raise ValueError(f"no CSV file {str(path)!r}")
    try:
        rows = list(csv.reader(path.read_text(encoding="utf-8-sig").splitlines(), skipinitialspace=True))
    except (UnicodeDecodeError, csv.Error) as error:
        raise ValueError(f"{path.name}: not a CSV file of text ({error})") from None
    header = [cell.strip() for cell in rows[0]] if rows else []
    if not set(CSV_COLUMNS) <= set(header):
        names = ", ".join(header) or "nothing"
        raise ValueError(f"{path.name} line 1: expected the columns t, u_x, u_theta, got {names}")
    columns: dict[str, list[float]] = {name: [] for name in CSV_COLUMNS}
    for line, row in enumerate(rows[1:], start=2):
        if any(cell.strip() for cell in row):
            for name in CSV_COLUMNS:
                columns[name].append(_cell(path, line, name, row, header.index(name)))
    if not columns["t"]:
        raise ValueError(f"{path.name}: no rows under the header")
    return columns


def _cell(path: Path, line: int, name: str, row: Sequence[str], index: int) -> float:
    if index >= len(row):
        raise ValueError(f"{path.name} line {line}: no value for {name}")
    try:
        value = float(row[index])
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"{path.name} line {line}: {name} must be a finite number, got {row[index]!r}")
    return value
