"""A campaign's runs in parts: some starts of a law and a family side by side, with a file for their rows."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from nhtrack.studies.campaign.cell import Cell
from nhtrack.studies.campaign.outcomes import run_outcomes
from nhtrack.studies.campaign.tables import rows_of, save_runs


class Part(NamedTuple):
    """Some starts of a cell, and the file their rows are written to."""

    cell: Cell
    starts: slice
    path: Path


def run_part(part: Part) -> None:
    """Runs some starts side by side and writes their rows."""
    save_runs(run_starts(part.cell, part.starts), part.path)


def run_starts(cell: Cell, starts: slice) -> pd.DataFrame:
    """Returns the rows of some consecutive starts of a cell, run side by side."""
    return rows_of(cell, starts.start, run_outcomes(cell.campaign, cell.experiment(starts)))


def parts_of(cell: Cell, folder: Path, size: int) -> Iterator[Part]:
    """Yields a cell in parts of at most so many starts."""
    count = cell.campaign.starts.count
    for first in range(0, count, size):
        name = f"{slug(cell.label)}-{slug(cell.family)}-{first}.parquet"
        yield Part(cell, slice(first, min(first + size, count)), folder / "parts" / name)


def slug(text: str) -> str:
    """Returns a label as names of files have it."""
    return text.replace(" ", "_")
