"""Maps of the starts of a campaign: where followers begin, how long they take, and which never arrive."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
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
from matplotlib.ticker import MaxNLocator

from nhtrack import se2
from nhtrack.colours import INK, ROOT
from nhtrack.plots.paths import DART
from nhtrack.plots.style import panel_title, plain, styled
from nhtrack.presentation.numbers import grouped
from nhtrack.simulation.faults import LOST
from nhtrack.studies.campaign.plots.pieces import (
    LONE,
    QUIET,
    SHADES,
    grid,
    legend,
    letter,
    name_outer,
    names,
    settled_within,
    title,
)

_TIMES = LinearSegmentedColormap.from_list("time", SHADES(np.linspace(0.22, 1.0, 64)))  # its light end on white
_FAILED = ROOT
_DISC = 2.05  # [in] side of a panel of the map of starts
_DOTS = 2500  # more starts than this are dots: darts would hide each other, and their headings could not be seen
_OUTLINED = 300  # starts that do not converge have an outline, which a grey print needs, unless there are more
_ROUND = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
_HEXAGON = np.stack([np.cos(np.arange(6) * np.pi / 3), np.sin(np.arange(6) * np.pi / 3)], axis=-1)


@styled
def start_map(
    starts: pd.DataFrame, cells: pd.DataFrame, law: str, worst: Mapping[str, int] | None = None
) -> Figure:
    """Returns where the followers of a law began and how long they took, a panel a family.

    A start is a dart at its place along its heading, or where there are very many a dot; the leader begins at the
    origin along x. The darker, the longer until the error stays within the criterion. Starts that do not converge lie
    on top, in a colour of their own.

    Args:
        starts: rows of runs with `law`, `family`, `start`, `x` [m], `y` [m], `theta` [rad], `converged`, `lost` and
            `settling_time` [s].
        cells: what converges, `position_limit` [m] and `heading_limit` [rad].
        law: label of the law that is shown.
        worst: families' starts (values of `start`) that are ringed and numbered.

    Raises:
        ValueError: no run of this law.
    """
    runs = starts[starts["law"] == law]
    if runs.empty:
        raise ValueError(f"no run of a law {law!r}; there are {', '.join(names(starts, 'law'))}")
    families, radius = names(runs, "family"), _disc(runs)
    scale, side = _time_scale(runs), _DISC * (LONE if len(families) == 1 else 1.0)
    figure, panels = grid(len(families), side, side + 0.35, margin=0.7 if scale is None else 1.6)
    for k, (axes, family) in enumerate(zip(panels, families, strict=True)):
        own = runs[runs["family"] == family]
        _frame_disc(axes, radius)
        _draw_starts(axes, own, radius, scale)
        leader = _darts(np.zeros((1, 3)), 0.13 * radius, color="white", edgecolor=INK, linewidth=1.0, zorder=5)
        axes.add_collection(leader)
        if worst is not None and family in worst:
            _ring(axes, own[own["start"] == worst[family]])
        panel_title(axes, letter(k), f"{plain(family)}\n")
        _write_count(axes, own)
    name_outer(panels, "$x$ [m]", "$y$ [m]")
    if scale is not None:
        _time_bar(figure, panels, scale, runs["settling_time"].dropna())
    title(figure, f"{plain(law)}: starts and settling times")
    _start_legend(figure, runs, f"converges: {settled_within(cells)}", scale, ringed=bool(worst))
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
    times = runs["settling_time"].dropna()
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
    return PolyCollection(list(se2.act(poses[:, None, :], size * DART)), facecolor=color, **look)


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
    said = f"all {grouped(every)} converge" if good == every else f"{grouped(good)} of {grouped(every)} converge"
    text = axes.annotate(
        said + (f", {grouped(lost)} lost" if lost else ""), (0, 1), xycoords="axes fraction", xytext=(0, 4),
        textcoords="offset points", fontsize=7.5, color=QUIET if good == every else _FAILED,
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


def _start_legend(figure: Figure, runs: pd.DataFrame, note: str, scale: Normalize | None, *, ringed: bool) -> None:
    """Says below the panels what darts and rings are, as far as there are any."""
    look: dict[str, Any] = {"marker": ">", "markersize": 7, "linestyle": "none", "markeredgecolor": "white"}
    entries = [Line2D([], [], label="leader", **look | {"markerfacecolor": "white", "markeredgecolor": INK})]
    if scale is not None:
        entries.append(Line2D([], [], color=_TIMES(0.5), label="converges", **look))
    if (~runs["converged"] & ~runs["lost"]).any():
        entries.append(Line2D([], [], color=_FAILED, label="does not converge", **look | {"markeredgecolor": INK}))
    if runs["lost"].any():
        entries.append(Line2D([], [], color=INK, label=f"lost: {LOST}", **look))
    if ringed:
        ring = {"marker": "o", "markersize": 10, "markerfacecolor": "none", "markeredgecolor": INK}
        entries.append(Line2D([], [], label="the worst, with its number", **look | ring))
    legend(figure, entries, note)
