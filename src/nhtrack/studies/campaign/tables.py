"""Tables of a campaign: a row for every run, and a row for every law and family."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from nhtrack.files.atomic import atomic_path
from nhtrack.simulation.faults import LOST
from nhtrack.studies.campaign.cell import Cell

# Of the table of runs; scenario units. What is not known (an error of a run that was lost) is NaN.
COLUMNS: Mapping[str, str] = {
    "law": "label of the law",
    "family": "name of the reference",
    "start": "index of the start",
    "x": "where the follower began [length], seen from the leader, as the others",
    "y": "[length]",
    "theta": "[rad]",
    "v": "[length/time]",
    "omega": "[rad/time]",
    "converged": "whether it settled: both errors stayed within the criterion over the last part of the run",
    "lost": f"whether it {LOST}",
    "late_position": "largest distance from its place in that part [length]",
    "late_heading": "largest heading error in that part [rad]",
    "settling_time": "since when both errors were within the criterion, NaN where it did not settle [time]",
    "peak_utilisation": "largest friction utilisation of a wheel, as predicted where there are no wheels [1]",
    "saturated": "share of the run in which a motor was at its limit [1]",
    "effort_x": "root mean square of u_x [length/time^2]",
    "effort_theta": "root mean square of u_theta [rad/time^2]",
    "switches": "in how many control periods a mode of the law changed",
}
# Of both tables, where families are over grids: the family that a row's one is a point of, and the values of its names.
GRID = "grid"
_SHORT = {"settling_time": "settling", "peak_utilisation": "utilisation"}  # in the names of summed-up columns
_LARGEST = ("late_position", "late_heading", "settling_time", "peak_utilisation", "switches")
_MEDIANS = (*_LARGEST, "effort_x", "effort_theta")


def rows_of(cell: Cell, first: int, figures: Mapping[str, Any]) -> pd.DataFrame:
    """Returns the rows of consecutive starts of a cell.

    Args:
        cell: law and family.
        first: index of the first start.
        figures: of the runs, see `nhtrack.studies.campaign.outcomes.outcomes_of`.
    """
    count, leader = len(figures["converged"]), cell.family_leader
    chosen = slice(first, first + count)
    began = dict(zip(("x", "y", "theta"), cell.draw.pose[chosen].T, strict=True))
    began |= dict(zip(("v", "omega"), cell.draw.twist[chosen].T, strict=True))
    place = {"law": cell.label, "family": cell.family, "start": np.arange(first, first + count)}
    rows = pd.DataFrame({**place, **began, **figures})[list(COLUMNS)]
    names = dict.fromkeys(name for grid in cell.campaign.grids for name in grid.grid)
    if names:
        rows.insert(2, GRID, "" if leader is None else leader.grid)
    for column, name in enumerate(names, start=3):
        rows.insert(column, f"{GRID}.{name}", math.nan if leader is None else leader.values.get(name, math.nan))
    return rows


def cells_of(
    runs: pd.DataFrame, gains: Mapping[tuple[str, str], Mapping[str, float]], **constants: Any
) -> pd.DataFrame:
    """Returns a row for every law and family: share with its Wilson interval, medians and worst figures.

    Args:
        runs: the table of runs.
        gains: found by tuning, by label and family.
        **constants: columns that are the same everywhere, such as the backend and the criterion.
    """
    rows = []
    for (law, family), part in runs.groupby(["law", "family"], sort=False):
        converged, interval = int(part["converged"].sum()), _wilson(part["converged"])
        row = {"law": law, "family": family, "starts": len(part), "converged": converged, "lost": part["lost"].sum()}
        row |= {name: part[name].iloc[0] for name in grid_columns(runs)}
        row |= {"share": converged / len(part), "share_low": interval[0], "share_high": interval[1]}
        row |= {f"{_SHORT.get(name, name)}_median": part[name].median() for name in _MEDIANS}
        row |= {f"{_SHORT.get(name, name)}_max": part[name].max() for name in _LARGEST}
        row |= {"settling_p99": part["settling_time"].quantile(0.99)}
        row |= {"saturated_share": (part["saturated"] > 0).mean(), "worst_start": worst_first(part).iloc[0]["start"]}
        row |= {"gains": " ".join(f"{name}={value:g}" for name, value in gains.get((law, family), {}).items())}
        rows.append(row | constants)
    return pd.DataFrame(rows)


def grid_columns(table: pd.DataFrame) -> list[str]:
    """Returns the columns that say which point of which grid a row is of, those that there are."""
    return [name for name in table if name == GRID or name.startswith(f"{GRID}.")]


def grid_of(table: pd.DataFrame) -> pd.Series:
    """Returns the grid of each row, empty where its family is no point of one; of a table that was read as well."""
    return table[GRID].fillna("") if GRID in table else pd.Series("", index=table.index)


def worst_first(runs: pd.DataFrame) -> pd.DataFrame:
    """Returns runs in order: the lost, those of the largest late errors, and among equals those that settled last."""
    order = runs.assign(error=np.hypot(runs["late_position"], runs["late_heading"]).round(12))
    keys = ["lost", "converged", "error", "settling_time"]
    return order.sort_values(keys, ascending=[False, True, False, False], kind="stable").drop(columns="error")


def save_runs(runs: pd.DataFrame, path: Path) -> Path:
    """Writes rows as Parquet; the file appears under its name only once it is whole."""
    with atomic_path(path) as temporary:
        runs.to_parquet(temporary, compression="zstd", index=False)
    return path


def save_cells(cells: pd.DataFrame, path: Path) -> Path:
    """Writes rows as CSV, six digits of every number; the file appears under its name only once it is whole."""
    with atomic_path(path) as temporary:
        cells.to_csv(temporary, index=False, float_format="%.6g")
    return path


def _wilson(converged: pd.Series) -> tuple[float, float]:
    """Returns the Wilson interval of a share at 95 % (E. B. Wilson, J. Am. Stat. Assoc. 22, 1927)."""
    from scipy.stats import binomtest  # only here: it takes a second to import

    found = binomtest(int(converged.sum()), len(converged)).proportion_ci(0.95, method="wilson")
    return float(found.low), float(found.high)
