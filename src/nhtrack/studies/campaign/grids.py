"""Families over grids in the tables of a campaign: each as one reference, and as a map."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import pandas as pd

from nhtrack.arrays import Array
from nhtrack.studies.campaign.tables import GRID, cells_of, grid_columns, grid_of


def by_reference(runs: pd.DataFrame, cells: pd.DataFrame) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Returns both tables with the points of a grid as one reference, called as the family that they are points of."""
    if GRID not in cells:
        return runs, cells
    runs, cells = _without_points(runs), _without_points(cells)
    summed = cells_of(runs, {})
    first = cells.drop_duplicates(["law", "family"]).reset_index(drop=True)
    constants = [name for name in first if name not in summed or name == "gains"]
    return runs, summed.assign(**{name: first[name] for name in constants})


def _without_points(table: pd.DataFrame) -> pd.DataFrame:
    grid = grid_of(table)
    return table.assign(family=table["family"].where(grid == "", grid)).drop(columns=grid_columns(table))


class GridMap(NamedTuple):
    """Shares over a grid: of one law over two numbers, or of all laws over one.

    Attributes:
        name: of the family over the grid.
        law: label of the law, empty where the rows are laws.
        across: name of the number that the columns are of.
        up: name of the one that the rows are of, empty where they are laws.
        columns: what each is called.
        rows: likewise.
        shares: of starts that converge, NaN where none was run, shape (rows, columns).
        families: names of the points.
    """

    name: str
    law: str
    across: str
    up: str
    columns: tuple[str, ...]
    rows: tuple[str, ...]
    shares: Array
    families: tuple[str, ...]


def grid_maps(cells: pd.DataFrame) -> list[GridMap]:
    """Returns every map that a table of cells holds, grid after grid, the laws of each in order."""
    found = []
    for name, part in cells.groupby(grid_of(cells), sort=False):
        columns = [column for column in grid_columns(part) if column != GRID and part[column].notna().any()]
        if name and len(columns) == 1:
            found.append(_grid_map(str(name), "", part, columns[0], "law"))
        elif name:
            laws = part.groupby("law", sort=False)
            found += [_grid_map(str(name), str(law), own, columns[0], columns[1]) for law, own in laws]
    return found


def _grid_map(name: str, law: str, part: pd.DataFrame, across: str, up: str) -> GridMap:
    shares = part.pivot_table("share", up, across, sort=False)
    if law:
        shares = shares.sort_index()
    shares = shares.sort_index(axis=1)
    across, up = (column.removeprefix(f"{GRID}.") if column != "law" else "" for column in (across, up))
    columns, rows = (
        tuple(value if isinstance(value, str) else f"{value:g}" for value in axis)
        for axis in (shares.columns, shares.index)
    )
    return GridMap(name, law, across, up, columns, rows, shares.to_numpy(), tuple(part["family"].unique()))


def whole_percent(share: float) -> str:
    """Returns a share in whole per cent; only none is 0 and only all are 100."""
    return "0" if share == 0 else "100" if share == 1 else f"{min(max(round(100 * share), 1), 99)}"


def grid_labels(tree: Mapping[str, Any]) -> dict[str, dict[str, str]]:
    """Returns what the axes of maps say, by family and name, from the tree of a campaign."""
    return {each["name"]: each["labels"] for each in tree["families"] if isinstance(each, Mapping) and "labels" in each}
