"""Distributions of a campaign: settling times, and the errors that are left."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator

from nhtrack.colours import FOLLOWERS, ROOT
from nhtrack.plots.style import panel_title, plain, styled
from nhtrack.studies.campaign.plots.pieces import (
    LONE,
    QUIET,
    grid,
    legend,
    letter,
    line,
    name_outer,
    names,
    settled_within,
    title,
)

_CURVE_POINTS = 500  # of a distribution; more could not be seen
_LEAST, _MOST = 1e-12, 1e3  # late errors [m], [rad] beyond these are drawn at them
_LATE = ((-0.16, "position", FOLLOWERS[0], "o"), (0.16, "heading", ROOT, "D"))  # place in a row, what, colour, marker
_CRITERION: dict[str, Any] = {"linewidth": 0.9, "linestyle": (0, (1, 1.5)), "zorder": 1}


@styled
def settling(starts: pd.DataFrame, cells: pd.DataFrame) -> Figure:
    """Returns the share of starts that have settled by a time, a panel a family, a curve a law.

    A curve ends at the share that converges; a dot stands where the last of them has settled.

    Args:
        starts: rows of runs with `law`, `family` and `settling_time` [s], NaN where a follower did not settle.
        cells: within which errors it has, `position_limit` [m] and `heading_limit` [rad].
    """
    laws, families = names(starts, "law"), names(starts, "family")
    times = starts["settling_time"]
    larger = LONE if len(families) == 1 else 1.0
    figure, panels = grid(len(families), 2.1 * larger, 1.75 * larger, sharey=True)
    last = 5.0 * max(1, math.ceil(1.02 * np.nan_to_num(times.max()) / 5.0))
    for k, (axes, family) in enumerate(zip(panels, families, strict=True)):
        for place, law in enumerate(laws):
            own = times[(starts["family"] == family) & (starts["law"] == law)]
            _draw_distribution(axes, own.to_numpy(dtype=float), last, line(place))
        axes.set_xlim(0, last)
        axes.set_ylim(-4, 104)
        if times.isna().all():
            axes.set_xticks([])
        axes.set_yticks([0, 25, 50, 75, 100])
        panel_title(axes, letter(k), plain(family))
    name_outer(panels, "time [s]", "settled [%]")
    title(figure, "Starts that have settled by a time")
    curves = [Line2D([], [], label=plain(law), **line(place)) for place, law in enumerate(laws)]
    legend(figure, curves, f"settled: {settled_within(cells)}", handlelength=2.6)
    return figure


def _draw_distribution(axes: Axes, times: np.ndarray, last: float, line: Mapping[str, Any]) -> None:
    """Draws the empirical distribution of times [s], NaN for never, up to the axis's end."""
    if not len(times):
        return
    settled = np.sort(times[np.isfinite(times)])
    shares = 100 * np.arange(1, len(settled) + 1) / len(times)
    if not len(settled):
        axes.plot([0.0, last], [0.0, 0.0], **line)
        return
    shown = np.unique(np.linspace(0, len(settled) - 1, _CURVE_POINTS).round().astype(int))
    x, y = np.concatenate([[0.0], settled[shown], [last]]), np.concatenate([[0.0], shares[shown], shares[-1:]])
    axes.plot(x, y, drawstyle="steps-post", **line)
    axes.plot(settled[-1], shares[-1], "o", color=line["color"], markersize=3.2, markeredgewidth=0, zorder=4)


@styled
def late_errors(starts: pd.DataFrame, cells: pd.DataFrame) -> Figure:
    """Returns how large the largest late errors of the starts are, a panel a law, a row a family.

    Thin bars hold nine starts in ten, thick ones every other; dots are medians, ticks the worst start. Errors of
    followers that were lost count as infinite; arrows stand where there were any.

    Args:
        starts: rows of runs with `law`, `family`, `late_position` [m], `late_heading` [rad] and `lost`.
        cells: what was demanded, `position_limit` [m] and `heading_limit` [rad].
    """
    laws, families = names(starts, "law"), names(starts, "family")
    width, height = 3.0 * (LONE if len(laws) == 1 else 1.0), 0.75 + 0.25 * len(families)
    figure, panels = grid(len(laws), width, height, most=4, sharey=True)
    for k, (axes, law) in enumerate(zip(panels, laws, strict=True)):
        for offset, name, colour, marker in _LATE:
            for limit in cells[f"{name}_limit"].unique():
                axes.axvline(limit, color=colour, **_CRITERION)
            for row, family in enumerate(families):
                own = starts[(starts["law"] == law) & (starts["family"] == family)]
                if len(own):
                    errors = own[f"late_{name}"].where(~own["lost"]).fillna(np.inf).to_numpy(dtype=float)
                    _draw_spread(axes, errors, row + offset, colour, marker)
        axes.set_xscale("log")
        axes.set_ylim(len(families) - 0.5, -0.5)
        axes.set_yticks(np.arange(len(families)), [plain(family) for family in families])
        axes.tick_params(axis="y", length=0)
        axes.grid(visible=False, axis="y")
        panel_title(axes, letter(k), plain(law))
    _share_decades(panels)
    name_outer(panels, "largest late error [m], [rad]", "")
    title(figure, "What is left at the end")
    entries = [
        Line2D([], [], color=colour, marker=marker, markersize=5, markeredgecolor="white", linewidth=3, label=name)
        for _, name, colour, marker in _LATE
    ]
    entries.append(Line2D([], [], color=QUIET, label="criterion", **_CRITERION))
    if starts["lost"].any():
        entries.append(Line2D([], [], color=QUIET, marker=">", markersize=5, linestyle="none", label="some were lost"))
    legend(figure, entries)
    return figure


def _draw_spread(axes: Axes, errors: np.ndarray, row: float, colour: str, marker: str) -> None:
    """Draws quantiles of errors, which are values that occur, so that infinite ones do not spread."""
    levels = [0.05, 0.25, 0.5, 0.75, 0.95, 1.0]
    quantiles = np.quantile(errors, levels, method="inverted_cdf")
    least, low, middle, high, most, worst = np.clip(quantiles, _LEAST, _MOST)
    axes.plot([least, most], [row, row], color=colour, linewidth=1.0, zorder=2, solid_capstyle="butt")
    axes.plot([low, high], [row, row], color=colour, linewidth=3.6, zorder=2, solid_capstyle="butt")
    point: dict[str, Any] = {"color": colour, "markersize": 5, "clip_on": False}
    axes.plot(worst, row, "|" if np.isfinite(quantiles[-1]) else ">", zorder=2.5, **point)
    axes.plot(middle, row, marker, markeredgecolor="white", markeredgewidth=0.8, zorder=3, **point)


def _share_decades(panels: Sequence[Axes]) -> None:
    """Gives logarithmic axes the same whole decades and few enough of them labelled."""
    low = 10.0 ** math.floor(math.log10(min(axes.dataLim.x0 for axes in panels)) - 0.1)
    high = 10.0 ** math.ceil(math.log10(max(axes.dataLim.x1 for axes in panels)) + 0.1)
    for axes in panels:
        axes.set_xlim(max(low, _LEAST), min(high, _MOST))  # what lies beyond stands on the edge
        axes.xaxis.set_major_locator(LogLocator(numticks=6))
        axes.xaxis.minorticks_off()
