"""Figures of a campaign: which laws converge to which references, from where, how fast, and what is left.

They are drawn from the two tables that a campaign leaves: `starts`, a row a run, and `cells`, a row for every law and
family of references; both in scenario units. Laws and families stand in the order of the tables.
"""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from matplotlib.patheffects import withStroke
from matplotlib.ticker import LogLocator, MaxNLocator

from nhtrack import se2
from nhtrack.plots.paths import DART
from nhtrack.plots.style import INK, panel_title, styled
from nhtrack.recording import atomic_path
from nhtrack.simulation.palette import FOLLOWERS, ROOT

__all__ = ["late_errors", "percent", "save_campaign_figures", "settling", "share_map", "start_map"]

# One hue from light to dark: the order survives colour blindness and a grey print.
_SHADES = LinearSegmentedColormap.from_list("share", ["#F3F7FA", "#A9CDE5", "#3E8FC4", "#005A9C", "#00325C"])
_TIMES = LinearSegmentedColormap.from_list("time", _SHADES(np.linspace(0.22, 1.0, 64)))  # its light end on white
_DARK = 0.595  # share of which white and black letters are equally readable
_BLANK = "#ECECEC"  # a cell that was not measured
_QUIET = "#666666"
_FAILED = ROOT

# A law is told from the others by colour, and in a grey print by its dashes.
_LAW_COLOURS = (FOLLOWERS[0], ROOT, *FOLLOWERS[1:], INK)
_LAW_DASHES: tuple[Any, ...] = (
    "-", (0, (4, 1.6)), (0, (1.3, 1.3)), (0, (4, 1.4, 1.2, 1.4)), (0, (8, 1.8)), (0, (2.4, 1.4)),
    (0, (4, 1.4, 1.2, 1.4, 1.2, 1.4)), (0, (1.2, 2.6)), (0, (8, 1.6, 1.2, 1.6)),
)  # fmt: skip

_CELL = (0.98, 0.60)  # [in] width and height of a cell of the map of shares
_DISC = 2.05  # [in] side of a panel of the map of starts
_LONE = 1.7  # a panel that is alone is larger by so much
_MOST_COLUMNS = 5
_DOTS = 2500  # more starts than this are dots: darts would hide each other, and their headings could not be seen
_OUTLINED = 300  # starts that do not converge have an outline, which a grey print needs, unless there are more
_ROUND = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
_CURVE_POINTS = 500  # of a distribution; more could not be seen
_LEAST, _MOST = 1e-12, 1e3  # late errors [m], [rad] beyond these are drawn at them
_LATE = ((-0.16, "position", FOLLOWERS[0], "o"), (0.16, "heading", ROOT, "D"))  # place in a row, what, colour, marker
_CRITERION: dict[str, Any] = {"linewidth": 0.9, "linestyle": (0, (1, 1.5)), "zorder": 1}
_BACKENDS = {"ideal": "Ideal model", "mujoco": "Wheels in MuJoCo"}
_HEXAGON = np.stack([np.cos(np.arange(6) * np.pi / 3), np.sin(np.arange(6) * np.pi / 3)], axis=-1)


def percent(share: float) -> str:
    """Returns a share in per cent, with as many digits as tell it from none and from all.

    0 and 100 mean exactly none and all: 9999 of 10 000 are 99.99.
    """
    rest = 100 * min(share, 1 - share)
    if rest < 1e-9:  # nothing but rounding: a share of a hundred thousand million runs
        return "100" if share > 0.5 else "0"
    digits = max(1, math.ceil(-math.log10(rest)))
    return f"{100 * share:.{digits}f}".rstrip("0").rstrip(".")


# -- shares -----------------------------------------------------------------------------------------


@styled
def share_map(cells: pd.DataFrame) -> Figure:
    """Returns the share of starts that converge, laws down, families across, with its 95 % interval (Wilson).

    A combination that was not measured is left blank.

    Args:
        cells: rows of law x family with `law`, `family`, `backend`, `starts`, `lost`, `share`, `share_low`,
            `share_high`, `position_limit` [m] and `heading_limit` [rad].
    """
    laws, families = _names(cells, "law"), _names(cells, "family")
    labels = [textwrap.fill(law, 24) for law in laws]
    margin = 0.35 + 0.066 * max(len(line) for label in labels for line in label.splitlines())
    width = max(margin + _CELL[0] * len(families), 4.6)
    caption = textwrap.fill(_criterion(cells), int(16 * width))
    height = 0.9 + 0.16 * caption.count("\n") + _CELL[1] * len(laws)
    figure = Figure(figsize=(width, height))
    axes = figure.subplots()
    shares = np.full((len(laws), len(families)), np.nan)
    for _, cell in cells.iterrows():
        row, column = laws.index(cell["law"]), families.index(cell["family"])
        shares[row, column] = cell["share"]
        _write_cell(axes, row, column, cell)
    axes.pcolormesh(np.ma.masked_invalid(shares), cmap=_SHADES, vmin=0, vmax=1)
    for row, column in np.argwhere(np.isnan(shares)):
        axes.text(column + 0.5, row + 0.5, "not run", ha="center", va="center", fontsize=7.5, color=_QUIET)
    _frame_matrix(axes, labels, families)
    _title(figure, "Starts that converge [%]")
    figure.supxlabel(caption, x=0.01, ha="left", fontsize=7.5, color=_QUIET)
    return figure


def _write_cell(axes: Axes, row: int, column: int, cell: pd.Series) -> None:
    """Writes a share, its interval and how many runs were lost."""
    look: dict[str, Any] = {
        "ha": "center", "va": "center", "color": "white" if cell["share"] > _DARK else "black", "zorder": 3,
    }  # fmt: skip
    lost = int(cell["lost"])
    share, interval = (0.30, 0.60) if lost else (0.38, 0.72)
    axes.text(column + 0.5, row + share, percent(cell["share"]), fontsize=12.0, fontweight="bold", **look)
    low, high = percent(cell["share_low"]), percent(cell["share_high"])
    axes.text(column + 0.5, row + interval, f"[{low}, {high}]", fontsize=7.0, **look)
    if lost:
        axes.text(column + 0.5, row + 0.83, f"{_grouped(lost)} lost", fontsize=7.0, fontstyle="italic", **look)


def _frame_matrix(axes: Axes, laws: Sequence[str], families: Sequence[str]) -> None:
    """Names rows and columns; the first law stands above."""
    axes.set_facecolor(_BLANK)
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


def _criterion(cells: pd.DataFrame) -> str:
    """Returns on what, from how many starts and by which criterion the shares were measured."""
    backends = " and ".join(_BACKENDS.get(name, name) for name in _names(cells, "backend"))
    least, most = int(cells["starts"].min()), int(cells["starts"].max())
    count = _grouped(most) if least == most else f"{_grouped(least)} to {_grouped(most)}"
    limits = sorted({(row.position_limit, row.heading_limit) for row in cells.itertuples()})
    within = " or ".join(f"{position:g} m and {heading:g} rad" for position, heading in limits)
    return f"{backends}, {count} starts a cell; converged: stays within {within}; in brackets: 95 % interval (Wilson)"


# -- starts -----------------------------------------------------------------------------------------


@styled
def start_map(starts: pd.DataFrame, law: str, worst: Mapping[str, int] | None = None) -> Figure:
    """Returns where the followers of a law began and how long they took, a panel a family.

    A start is a dart at its place along its heading, or where there are very many a dot; the leader begins at the
    origin along x. The darker, the longer until the error stays within the criterion. Starts that do not converge lie
    on top, in a colour of their own.

    Args:
        starts: rows of runs with `law`, `family`, `start`, `x` [m], `y` [m], `theta` [rad], `converged`, `lost` and
            `settling_time` [s].
        law: label of the law that is shown.
        worst: families' starts (values of `start`) that are ringed and numbered.

    Raises:
        ValueError: no run of this law.
    """
    runs = starts[starts["law"] == law]
    if runs.empty:
        raise ValueError(f"no run of a law {law!r}; there are {', '.join(_names(starts, 'law'))}")
    families, radius = _names(runs, "family"), _disc(runs)
    scale, side = _time_scale(runs), _DISC * (_LONE if len(families) == 1 else 1.0)
    figure, panels = _grid(len(families), side, side + 0.35, margin=0.7 if scale is None else 1.6)
    for k, (axes, family) in enumerate(zip(panels, families, strict=True)):
        own = runs[runs["family"] == family]
        _frame_disc(axes, radius)
        _draw_starts(axes, own, radius, scale)
        leader = _darts(np.zeros((1, 3)), 0.13 * radius, color="white", edgecolor=INK, linewidth=1.0, zorder=5)
        axes.add_collection(leader)
        if worst is not None and family in worst:
            _ring(axes, own[own["start"] == worst[family]])
        panel_title(axes, _letter(k), f"{family}\n")
        _write_count(axes, own)
    _name_outer(panels, "$x$ [m]", "$y$ [m]")
    if scale is not None:
        _time_bar(figure, panels, scale, runs.loc[runs["converged"], "settling_time"])
    _title(figure, f"{law}: starts and settling times")
    _start_legend(figure, runs, scale, ringed=bool(worst))
    return figure


def _disc(runs: pd.DataFrame) -> float:
    """Returns the radius of the disc that starts were drawn from [m]: the least round number that holds them all."""
    farthest = max(float(np.hypot(runs["x"], runs["y"]).max()), 1e-6)
    decade = 10.0 ** math.floor(math.log10(farthest))
    return next(decade * step for step in _ROUND if decade * step >= farthest * (1 - 1e-9))


def _time_scale(runs: pd.DataFrame) -> Normalize | None:
    """Returns the scale of settling times, None where nobody settles.

    Neither a few stragglers nor the few that start in their place stretch it.
    """
    times = runs.loc[runs["converged"], "settling_time"]
    if times.empty:
        return None
    low, high = times.quantile([0.05, 0.99])
    return Normalize(math.floor(low), max(math.ceil(high), math.floor(low) + 1), clip=True)


def _frame_disc(axes: Axes, radius: float) -> None:
    """Draws the disc, with the directions along and across the leader."""
    axes.set_aspect("equal")
    axes.set_xlim(-1.06 * radius, 1.06 * radius)
    axes.set_ylim(-1.06 * radius, 1.06 * radius)
    axes.set_xticks([-radius, 0, radius])
    axes.set_yticks([-radius, 0, radius])
    axes.tick_params(length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)
    axes.add_patch(Circle((0, 0), radius, facecolor="none", edgecolor="#999999", linewidth=0.7, zorder=1))


def _draw_starts(axes: Axes, runs: pd.DataFrame, radius: float, scale: Normalize | None) -> None:
    """Draws starts that converge, the slowest on top, and over them those that do not."""
    good = runs[runs["converged"]].sort_values("settling_time")
    if scale is not None:
        size = _glyph_size(len(runs), radius)
        _scatter(axes, good, size, dots=len(runs) > _DOTS, color=_TIMES(scale(good["settling_time"])), zorder=2)
    bad = runs[~runs["converged"]]
    size, dots = _glyph_size(max(len(bad), 20), radius), len(bad) > _DOTS
    edge: dict[str, Any] = {"edgecolor": INK, "linewidth": 0.5} if len(bad) < _OUTLINED else {}
    _scatter(axes, bad[~bad["lost"]], size, dots=dots, color=_FAILED, zorder=3, **edge)
    _scatter(axes, bad[bad["lost"]], size, dots=dots, color=INK, zorder=3, **edge)


def _glyph_size(count: int, radius: float) -> float:
    """Returns the length [m] at which so many darts fill a disc without hiding each other."""
    return min(1.25 * radius * math.sqrt(math.pi / max(count, 1)), 0.14 * radius)


def _scatter(axes: Axes, runs: pd.DataFrame, size: float, *, dots: bool, **look: Any) -> None:
    """Draws runs as darts, or as dots, of a size in metres."""
    poses = runs[["x", "y", "theta"]].to_numpy(dtype=float)
    if dots:
        corners = poses[:, None, :2] + 0.33 * size * _HEXAGON
        axes.add_collection(PolyCollection(corners, rasterized=True, linewidth=0, **look))
    else:
        axes.add_collection(_darts(poses, size, rasterized=len(poses) > 200, **{"linewidth": 0.0} | look))


def _darts(poses: np.ndarray, size: float, **look: Any) -> PolyCollection:
    """Returns robots at poses (n, 3) as darts of a length [m]."""
    color = look.pop("color")
    return PolyCollection(se2.act(poses[:, None, :], size * DART), facecolor=color, **look)


def _ring(axes: Axes, run: pd.DataFrame) -> None:
    """Rings a start and writes its number on the side of it that is farther from the edge."""
    ring: dict[str, Any] = {"marker": "o", "markersize": 11, "markerfacecolor": "none", "zorder": 5, "clip_on": False}
    for x, y, index in run[["x", "y", "start"]].itertuples(index=False):
        axes.plot(x, y, markeredgecolor="white", markeredgewidth=2.4, **ring)
        axes.plot(x, y, markeredgecolor=INK, markeredgewidth=1.1, **ring)
        text = axes.annotate(
            f"{index}", (x, y), xytext=(-8 if x > 0 else 8, 0), textcoords="offset points",
            ha="right" if x > 0 else "left", va="center", fontsize=8.0, fontweight="bold", color=INK, zorder=6,
        )  # fmt: skip
        text.set_path_effects([withStroke(linewidth=2.2, foreground="white")])


def _write_count(axes: Axes, runs: pd.DataFrame) -> None:
    """Writes below a panel's name how many starts converge, in the colour of failure if any does not."""
    good, lost, every = int(runs["converged"].sum()), int(runs["lost"].sum()), len(runs)
    said = f"all {_grouped(every)} converge" if good == every else f"{_grouped(good)} of {_grouped(every)} converge"
    text = axes.annotate(
        said + (f", {_grouped(lost)} lost" if lost else ""), (0, 1), xycoords="axes fraction", xytext=(0, 4),
        textcoords="offset points", fontsize=7.5, color=_QUIET if good == every else _FAILED,
    )  # fmt: skip
    text.set_in_layout(False)  # the panel's name, two lines high, has made the room


def _time_bar(figure: Figure, panels: Sequence[Axes], scale: Normalize, times: pd.Series) -> None:
    """Draws the scale of settling times beside the panels, pointed at an end that some lie beyond."""
    assert scale.vmin is not None
    assert scale.vmax is not None
    below, above = times.min() < scale.vmin, times.max() > scale.vmax
    extend = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    bar = figure.colorbar(
        ScalarMappable(scale, _TIMES), ax=list(panels), location="right", aspect=30, pad=0.02,
        extend=extend[bool(below), bool(above)],
    )  # fmt: skip
    bar.ax.yaxis.set_major_locator(MaxNLocator(6, integer=True))
    bar.set_label("settling time [s]" + (f", up to {times.max():.0f} s" if above else ""))
    bar.outline.set_linewidth(0.0)
    bar.ax.grid(False)


def _start_legend(figure: Figure, runs: pd.DataFrame, scale: Normalize | None, *, ringed: bool) -> None:
    """Says below the panels what darts and rings are, as far as there are any."""
    look: dict[str, Any] = {"marker": ">", "markersize": 7, "linestyle": "none", "markeredgecolor": "white"}
    entries = [Line2D([], [], label="leader", **look | {"markerfacecolor": "white", "markeredgecolor": INK})]
    if scale is not None:
        entries.append(Line2D([], [], color=_TIMES(0.5), label="converges", **look))
    if (~runs["converged"] & ~runs["lost"]).any():
        entries.append(Line2D([], [], color=_FAILED, label="does not converge", **look | {"markeredgecolor": INK}))
    if runs["lost"].any():
        entries.append(Line2D([], [], color=INK, label="lost: ran away or tipped", **look))
    if ringed:
        ring = {"marker": "o", "markersize": 10, "markerfacecolor": "none", "markeredgecolor": INK}
        entries.append(Line2D([], [], label="the worst, with its number", **look | ring))
    _legend(figure, entries)


# -- distributions ----------------------------------------------------------------------------------


@styled
def settling(starts: pd.DataFrame) -> Figure:
    """Returns the share of starts that have settled by a time, a panel a family, a curve a law.

    A curve ends at the share that converges; a dot stands where the last of them has settled.

    Args:
        starts: rows of runs with `law`, `family`, `converged` and `settling_time` [s].
    """
    laws, families = _names(starts, "law"), _names(starts, "family")
    times = starts["settling_time"].where(starts["converged"])  # others may be near at the very end by chance
    larger = _LONE if len(families) == 1 else 1.0
    figure, panels = _grid(len(families), 2.1 * larger, 1.75 * larger, sharey=True)
    last = 5.0 * max(1, math.ceil(1.02 * np.nan_to_num(times.max()) / 5.0))
    for k, (axes, family) in enumerate(zip(panels, families, strict=True)):
        for place, law in enumerate(laws):
            own = times[(starts["family"] == family) & (starts["law"] == law)]
            _draw_distribution(axes, own.to_numpy(dtype=float), last, _line(place))
        axes.set_xlim(0, last)
        axes.set_ylim(-4, 104)
        if times.isna().all():
            axes.set_xticks([])
        axes.set_yticks([0, 25, 50, 75, 100])
        panel_title(axes, _letter(k), family)
    _name_outer(panels, "time [s]", "settled [%]")
    _title(figure, "Starts that have settled by a time")
    _legend(figure, [Line2D([], [], label=law, **_line(place)) for place, law in enumerate(laws)], handlelength=2.6)
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
    laws, families = _names(starts, "law"), _names(starts, "family")
    width, height = 3.0 * (_LONE if len(laws) == 1 else 1.0), 0.75 + 0.25 * len(families)
    figure, panels = _grid(len(laws), width, height, most=4, sharey=True)
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
        axes.set_yticks(np.arange(len(families)), families)
        axes.tick_params(axis="y", length=0)
        axes.grid(visible=False, axis="y")
        panel_title(axes, _letter(k), law)
    _share_decades(panels)
    _name_outer(panels, "largest late error [m], [rad]", "")
    _title(figure, "What is left at the end")
    entries = [
        Line2D([], [], color=colour, marker=marker, markersize=5, markeredgecolor="white", linewidth=3, label=name)
        for _, name, colour, marker in _LATE
    ]
    entries.append(Line2D([], [], color=_QUIET, label="criterion", **_CRITERION))
    if starts["lost"].any():
        entries.append(Line2D([], [], color=_QUIET, marker=">", markersize=5, linestyle="none", label="some were lost"))
    _legend(figure, entries)
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


# -- pieces -----------------------------------------------------------------------------------------


def _names(table: pd.DataFrame, column: str) -> list[str]:
    """Returns the different names in a column, in order."""
    return [str(name) for name in table[column].unique()]


def _letter(place: int) -> str:
    return "abcdefghijklmnopqrstuvwxyz"[place % 26]


def _grouped(number: int) -> str:
    """Returns a number with its thousands apart."""
    return f"{number:,}".replace(",", " ") if number >= 10_000 else str(number)


def _title(figure: Figure, text: str) -> None:
    figure.suptitle(text, x=0.01, ha="left", fontsize=11.0, fontweight="bold", color=INK)


def _grid(
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


def _name_outer(panels: Sequence[Axes], xlabel: str, ylabel: str) -> None:
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


def _line(place: int) -> dict[str, Any]:
    """Returns how the curve of a law is drawn, by its place among the laws.

    The first is solid and the others broken above it, so that curves that coincide are all seen.
    """
    colour, dashes = _LAW_COLOURS[place % len(_LAW_COLOURS)], _LAW_DASHES[place % len(_LAW_DASHES)]
    return {"color": colour, "linestyle": dashes, "linewidth": 1.5, "zorder": 3 + 0.01 * place}


def _legend(figure: Figure, entries: Sequence[Line2D], **look: Any) -> None:
    """Writes a legend below a figure, in one row or, where the figure is narrow, in several, for which it grows."""
    widths = [0.65 + 0.065 * len(str(entry.get_label())) for entry in entries]  # [in] about
    room = figure.get_figwidth()
    columns = len(entries) if sum(widths) <= room else max(1, int(room / max(widths)))
    rows = -(-len(entries) // columns)
    figure.set_figheight(figure.get_figheight() + 0.18 * (rows - 1))
    figure.legend(handles=list(entries), loc="outside lower center", ncols=columns, **look)


# -- files ------------------------------------------------------------------------------------------


@styled
def save_campaign_figures(starts: pd.DataFrame, cells: pd.DataFrame, folder: Path) -> list[Path]:
    """Writes every figure of a campaign as PNG (200 dpi) and PDF; each file appears only once it is whole.

    The map of starts is one figure a law, `start_map_<label>`, the label in small letters and underscores.

    Args:
        starts: a row a run.
        cells: a row for every law and family; its `worst_start` is ringed in the map of starts.
        folder: where to write.

    Returns:
        The files, PNG before PDF.
    """
    figures = {"share_map": share_map(cells), "settling": settling(starts), "late_errors": late_errors(starts, cells)}
    for law, name in _file_names(_names(starts, "law")).items():
        own = cells[cells["law"] == law]
        worst = {str(family): int(start) for family, start in zip(own["family"], own["worst_start"], strict=True)}
        figures[f"start_map_{name}"] = start_map(starts, law, worst)
    return [path for name, figure in figures.items() for path in _write(figure, folder / name)]


def _file_names(labels: Sequence[str]) -> dict[str, str]:
    """Returns a name for a file for every label; those that would be the same are numbered."""
    names: dict[str, str] = {}
    for label in labels:
        slug = name = re.sub(r"[^a-z0-9]+", "_", label.lower()).strip("_")
        number = 1
        while name in names.values():
            number += 1
            name = f"{slug}_{number}"
        names[label] = name
    return names


def _write(figure: Figure, stem: Path) -> list[Path]:
    """Writes a figure as PNG and PDF."""
    written = []
    for suffix, metadata in ((".png", {}), (".pdf", {"CreationDate": None})):  # no date: same tables, same bytes
        target = stem.with_name(stem.name + suffix)
        with atomic_path(target) as temporary:
            figure.savefig(temporary, metadata=metadata)
        figure.set_layout_engine("none")  # laid out by the first drawing; the second need not do it again
        written.append(target)
    return written
