"""Maps over a grid of references: which share of starts converges at each of its points."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from nhtrack.colours import INK
from nhtrack.plots.style import plain, styled
from nhtrack.studies.campaign.grids import GridMap, whole_percent
from nhtrack.studies.campaign.plots.pieces import BLANK, DARK, QUIET, SHADES, criterion, title

_CELL = (0.31, 0.25)  # [in] width and height of a point of the grid


@styled
def grid_map(cells: pd.DataFrame, grid: GridMap, labels: Mapping[str, str] | None = None) -> Figure:
    """Returns the share of starts that converge over a grid, a cell a point, the same shades in every map.

    Cells are equally large: an axis is logarithmic where the numbers of the grid are spaced by factors.

    Args:
        cells: rows of law x family, see `nhtrack.studies.campaign.plots.shares.share_map`.
        grid: the map, see `nhtrack.studies.campaign.grids.grid_maps`.
        labels: what axes say, by the grid's names; a name says itself otherwise.
    """
    rows, columns = grid.shares.shape
    across, up = ((labels or {}).get(name, name) for name in (grid.across, grid.up))
    margin = 0.9 if grid.up else 0.5 + 0.075 * max(len(text) for text in grid.rows)
    width = max(margin + _CELL[0] * columns + 0.9, 4.6)
    caption = textwrap.fill(criterion(cells[cells["family"].isin(grid.families)]), int(16 * width))
    figure = Figure(figsize=(width, 1.35 + 0.16 * caption.count("\n") + _CELL[1] * rows))
    axes = figure.subplots()
    _draw(axes, grid)
    axes.set_xlabel(plain(across))
    axes.set_ylabel(plain(up))
    bar = figure.colorbar(ScalarMappable(Normalize(0, 100), SHADES), ax=axes, aspect=18, pad=0.02)
    bar.outline.set_linewidth(0.0)
    bar.ax.grid(False)
    title(figure, plain(f"{', '.join(filter(None, (grid.law, grid.name)))}: starts that converge [%]"))
    figure.supxlabel(caption, x=0.01, ha="left", fontsize=7.5, color=QUIET)
    return figure


def _draw(axes: Axes, grid: GridMap) -> None:
    """Draws cells, and in each its share in per cent; the first row is the lowest, but the first law the highest."""
    rows, columns = grid.shares.shape
    axes.set_facecolor(BLANK)
    axes.pcolormesh(np.ma.masked_invalid(grid.shares), cmap=SHADES, vmin=0, vmax=1, edgecolor="white", linewidth=0.8)
    for (row, column), share in np.ndenumerate(grid.shares):
        if np.isfinite(share):
            axes.text(
                column + 0.5, row + 0.5, whole_percent(share), ha="center", va="center", fontsize=6.5,
                color="white" if share > DARK else "black",
            )  # fmt: skip
    axes.set_xticks(np.arange(columns) + 0.5, _ticks(grid.columns))
    axes.set_yticks(np.arange(rows) + 0.5, _ticks(grid.rows))
    axes.set_ylim((0, rows) if grid.up else (rows, 0))
    axes.tick_params(length=0, labelsize=7.5, labelcolor=INK)
    axes.grid(False)
    for spine in axes.spines.values():
        spine.set_visible(False)


def _ticks(values: Sequence[str]) -> list[str]:
    return [plain(value) for value in values]
