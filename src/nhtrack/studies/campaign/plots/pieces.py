"""What the figures of a campaign have in common."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nhtrack.colours import FOLLOWERS, INK, ROOT
from nhtrack.presentation.numbers import grouped
from nhtrack.presentation.shown import within
from nhtrack.settling import SettlingLimits

# One hue from light to dark: the order survives colour blindness and a grey print.
SHADES = LinearSegmentedColormap.from_list("share", ["#F3F7FA", "#A9CDE5", "#3E8FC4", "#005A9C", "#00325C"])
DARK = 0.595  # share of which white and black letters on these shades are equally readable
QUIET = "#666666"
BLANK = "#ECECEC"  # a cell that was not measured
LONE = 1.7  # a panel that is alone is larger by so much
# A law is told from the others by colour, and in a grey print by its dashes.
_LAW_COLOURS = (FOLLOWERS[0], ROOT, *FOLLOWERS[1:], INK)
_LAW_DASHES: tuple[Any, ...] = (
    "-", (0, (4, 1.6)), (0, (1.3, 1.3)), (0, (4, 1.4, 1.2, 1.4)), (0, (8, 1.8)), (0, (2.4, 1.4)),
    (0, (4, 1.4, 1.2, 1.4, 1.2, 1.4)), (0, (1.2, 2.6)), (0, (8, 1.6, 1.2, 1.6)),
)  # fmt: skip
_MOST_COLUMNS = 5
_BACKENDS = {"ideal": "Ideal model", "mujoco": "Wheels in MuJoCo"}


def names(table: pd.DataFrame, column: str) -> list[str]:
    """Returns the different names in a column, in order."""
    return [str(name) for name in table[column].unique()]


def letter(place: int) -> str:
    """Returns the letter of a panel; after z come aa, ab and so on."""
    before = letter(place // 26 - 1) if place >= 26 else ""
    return before + "abcdefghijklmnopqrstuvwxyz"[place % 26]


def title(figure: Figure, text: str) -> None:
    """Writes a figure's title."""
    figure.suptitle(text, x=0.01, ha="left", fontsize=11.0, fontweight="bold", color=INK)


def settled_within(cells: pd.DataFrame) -> str:
    """Returns what has settled, from the columns `position_limit` [m] and `heading_limit` [rad] of cells."""
    limits = sorted({SettlingLimits(row.position_limit, row.heading_limit) for row in cells.itertuples()})
    return f"stays {' or '.join(within(each) for each in limits)} of its place until the end"


def criterion(cells: pd.DataFrame) -> str:
    """Returns on what, from how many starts and by which criterion shares were measured."""
    backends = " and ".join(_BACKENDS.get(name, name) for name in names(cells, "backend"))
    least, most = int(cells["starts"].min()), int(cells["starts"].max())
    count = grouped(most) if least == most else f"{grouped(least)} to {grouped(most)}"
    return f"{backends}, {count} starts a cell; converged: {settled_within(cells)}"


def grid(
    count: int, width: float, height: float, *, most: int = _MOST_COLUMNS, margin: float = 0.9, **subplots: Any
) -> tuple[Figure, list[Axes]]:
    """Returns a figure of panels, in rows of about the same length, and the panels.

    Args:
        count: of the panels.
        width: of each [in].
        height: of each, with its name [in].
        most: panels in a row.
        margin: width beside the panels [in].
        **subplots: what the panels share.
    """
    rows = -(-count // most)
    columns = -(-count // rows)
    figure = Figure(figsize=(max(width * columns + margin, 4.6), height * rows + 1.0))
    grid = figure.subplots(rows, columns, squeeze=False, **subplots)
    for axes in grid.flat[count:]:
        axes.remove()
    return figure, list(grid.flat[:count])


def name_outer(panels: Sequence[Axes], xlabel: str, ylabel: str) -> None:
    """Names the axes of panels that have none below them, or none to their left; the others have no numbers."""
    columns = panels[0].get_gridspec().ncols  # type: ignore[union-attr]
    for k, axes in enumerate(panels):
        if k + columns >= len(panels):
            axes.set_xlabel(xlabel)
        else:
            axes.tick_params(labelbottom=False)
        if k % columns == 0:
            axes.set_ylabel(ylabel)
        else:
            axes.tick_params(labelleft=False)


def line(place: int) -> dict[str, Any]:
    """Returns how the curve of a law is drawn, by its place among the laws.

    The first is solid and the others broken above it, so that curves that coincide are all seen.
    """
    colour, dashes = _LAW_COLOURS[place % len(_LAW_COLOURS)], _LAW_DASHES[place % len(_LAW_DASHES)]
    return {"color": colour, "linestyle": dashes, "linewidth": 1.5, "zorder": 3 + 0.01 * place}


def legend(figure: Figure, entries: Sequence[Line2D], note: str = "", **look: Any) -> None:
    """Writes a legend below a figure, in one row or, where the figure is narrow, in several, for which it grows.

    Args:
        figure: of the campaign.
        entries: of the legend.
        note: what to say above them.
        **look: of the legend.
    """
    widths = [0.65 + 0.065 * len(str(entry.get_label())) for entry in entries]  # [in] about
    room = figure.get_figwidth()
    columns = len(entries) if sum(widths) <= room else max(1, int(room / max(widths)))
    rows = -(-len(entries) // columns)
    figure.set_figheight(figure.get_figheight() + 0.18 * (rows - 1 + bool(note)))
    if note:
        look |= {"title": note, "title_fontsize": 7.5, "alignment": "left"}
    found = figure.legend(handles=list(entries), loc="outside lower center", ncols=columns, **look)
    found.get_title().set_color(QUIET)
