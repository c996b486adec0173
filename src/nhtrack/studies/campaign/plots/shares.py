"""Map of a campaign: the share of starts that converge, for every law and family."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nhtrack.colours import INK
from nhtrack.plots.style import plain, styled
from nhtrack.presentation.numbers import grouped, percent
from nhtrack.studies.campaign.plots.pieces import BLANK, DARK, QUIET, SHADES, criterion, names, title

_CELL = (0.98, 0.60)  # [in] width and height of a cell of the map of shares


@styled
def share_map(cells: pd.DataFrame) -> Figure:
    """Returns the share of starts that converge, laws down, families across, with its 95 % interval (Wilson).

    A combination that was not measured is left blank.

    Args:
        cells: rows of law x family with `law`, `family`, `backend`, `starts`, `lost`, `share`, `share_low`,
            `share_high`, `position_limit` [m] and `heading_limit` [rad].
    """
    laws, families = names(cells, "law"), names(cells, "family")
    labels = [textwrap.fill(law, 24) for law in laws]
    margin = 0.35 + 0.066 * max(len(line) for label in labels for line in label.splitlines())
    width = max(margin + _CELL[0] * len(families), 4.6)
    caption = textwrap.fill(f"{criterion(cells)}; in brackets: 95 % interval (Wilson)", int(16 * width))
    height = 0.9 + 0.16 * caption.count("\n") + _CELL[1] * len(laws)
    figure = Figure(figsize=(width, height))
    axes = figure.subplots()
    shares = np.full((len(laws), len(families)), np.nan)
    for _, cell in cells.iterrows():
        row, column = laws.index(cell["law"]), families.index(cell["family"])
        shares[row, column] = cell["share"]
        _write_cell(axes, row, column, cell)
    axes.pcolormesh(np.ma.masked_invalid(shares), cmap=SHADES, vmin=0, vmax=1)
    for row, column in np.argwhere(np.isnan(shares)):
        axes.text(column + 0.5, row + 0.5, "not run", ha="center", va="center", fontsize=7.5, color=QUIET)
    _frame_matrix(axes, [plain(label) for label in labels], [plain(family) for family in families])
    title(figure, "Starts that converge [%]")
    figure.supxlabel(caption, x=0.01, ha="left", fontsize=7.5, color=QUIET)
    return figure


def _write_cell(axes: Axes, row: int, column: int, cell: pd.Series) -> None:
    """Writes a share, its interval and how many runs were lost."""
    look: dict[str, Any] = {
        "ha": "center", "va": "center", "color": "white" if cell["share"] > DARK else "black", "zorder": 3,
    }  # fmt: skip
    lost = int(cell["lost"])
    share, interval = (0.30, 0.60) if lost else (0.38, 0.72)
    axes.text(column + 0.5, row + share, percent(cell["share"]), fontsize=12.0, fontweight="bold", **look)
    low, high = percent(cell["share_low"]), percent(cell["share_high"])
    axes.text(column + 0.5, row + interval, f"[{low}, {high}]", fontsize=7.0, **look)
    if lost:
        axes.text(column + 0.5, row + 0.83, f"{grouped(lost)} lost", fontsize=7.0, fontstyle="italic", **look)


def _frame_matrix(axes: Axes, laws: Sequence[str], families: Sequence[str]) -> None:
    """Names rows and columns; the first law stands above."""
    axes.set_facecolor(BLANK)
    axes.grid(False)
    axes.set_xlim(0, len(families))
    axes.set_ylim(len(laws), 0)
    axes.set_aspect(_CELL[1] / _CELL[0], anchor="W")
    axes.xaxis.tick_top()
    axes.set_xticks(np.arange(len(families)) + 0.5, families, color=INK)
    axes.set_yticks(np.arange(len(laws)) + 0.5, laws, color=INK, fontsize=9.0)
    axes.tick_params(length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)
    for edge in range(len(families) + 1):
        axes.axvline(edge, color="white", linewidth=2.0)
    for edge in range(len(laws) + 1):
        axes.axhline(edge, color="white", linewidth=2.0)
