"""The leader's input as a CSV file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

from pydantic import Field

from nhtrack.references.columns import FileFaults, read_csv
from nhtrack.references.contract import InputSection, Reference
from nhtrack.references.table import LATE_START, Interpolation

_COLUMNS = ("t", "u_x", "u_theta")


class CsvInput(InputSection):
    """The leader's input from a file; loading turns it into a table, so a recording carries the numbers."""

    key: ClassVar[str] = "csv"
    words: ClassVar[str] = "a csv file"
    csv: str = Field(
        min_length=1,
        description="CSV file with the columns t, u_x, u_theta named in its first line, found relative to the scenario",
    )
    interpolation: Interpolation = Field(
        default="previous",
        description="hold each row until the next, the last for ever, or join rows by lines, with 0 after the last",
    )

    @classmethod
    def resolved(cls, given: Mapping[str, Any], directory: Path) -> Mapping[str, Any]:
        """Returns a raw section with the file's columns as a table."""
        if not isinstance(given["csv"], str) or not given["csv"]:
            return given  # the section's own fault, told by its model
        columns = read_csv(directory / given["csv"], _COLUMNS)
        if columns.values["t"][0] > 0:
            raise FileFaults([columns.fault(0, "t", LATE_START.format(columns.values["t"][0]))])
        rest = {key: value for key, value in given.items() if key != "csv"}
        return {"table": dict(columns.values), **rest}

    def reference(self) -> Reference:
        """Raises TypeError: loading makes a table of it."""
        raise TypeError("a CSV input becomes a table when the scenario is loaded; load it with nhtrack.load")
