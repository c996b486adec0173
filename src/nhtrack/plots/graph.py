"""Who tracks whom, drawn."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch

from nhtrack.arrays import Array
from nhtrack.colours import INK, ink_on, robot_colour
from nhtrack.plots.style import COLUMN, plain
from nhtrack.presentation.graph_layout import graph_places, graph_radius
from nhtrack.presentation.shown import short_name

_RADIUS = 0.13  # [in] of a robot's circle, where there is room
_MARGIN = 0.20  # [in] around the circles
_LETTERS = 1.0  # [pt] of a circle's letters over its radius [pt]
_NAMED = 10  # robots, at most, whose names are written in full below their circles


def draw_graph(parents: Mapping[str, Sequence[str]], header: Callable[[Figure], float] = lambda figure: 0.0) -> Figure:
    """Returns a figure one column wide of arrows from parents to the robots that track them.

    Circles have the robots' colours, and the numbers at the ends of their names.

    Args:
        parents: of every robot by name, the root first.
        header: writes what stands above into the figure and returns the height that this takes up [in].
    """
    spots = graph_places(parents, COLUMN - 2 * _MARGIN)
    everything = np.array(list(spots.values()))
    radius = graph_radius(spots, _RADIUS)
    named = len(spots) <= _NAMED and any(short_name(name) != name for name in spots)
    low = everything.min(axis=0) - _MARGIN - [0.0, 0.12 if named else 0.0]
    high = everything.max(axis=0) + _MARGIN
    height = float(high[1] - low[1])
    figure = Figure(figsize=(COLUMN, height))
    figure.set_figheight(height + header(figure))
    axes = figure.add_axes((0.0, 0.0, 1.0, height / figure.get_figheight()))  # a unit is an inch
    middle = (low[0] + high[0]) / 2
    axes.set(xlim=(middle - COLUMN / 2, middle + COLUMN / 2), ylim=(low[1], high[1]))
    axes.axis("off")
    for name, others in parents.items():
        for parent in others:
            ends = spots[parent], spots[name]
            _draw_arrow(axes, *ends, radius, bent=_passes(everything, *ends, radius))
    for place, name in enumerate(parents):
        _draw_robot(axes, name, spots[name], robot_colour(place), radius, named=named)
    return figure


def _draw_arrow(axes: Axes, start: Array, end: Array, radius: float, *, bent: bool) -> None:
    """Draws an arrow from circle to circle, bent where a straight one would run over others."""
    axes.add_patch(
        FancyArrowPatch(
            (float(start[0]), float(start[1])), (float(end[0]), float(end[1])),
            arrowstyle="-|>", mutation_scale=min(7.0, 45 * radius), shrinkA=72 * radius, shrinkB=72 * radius + 0.5,
            connectionstyle=f"arc3,rad={0.25 if bent else 0.0}", color="#777777", linewidth=0.6, zorder=1,
        )
    )  # fmt: skip


def _draw_robot(axes: Axes, name: str, spot: Array, colour: str, radius: float, *, named: bool) -> None:
    axes.add_patch(Circle(_point(spot), radius, facecolor=colour, edgecolor="none", zorder=2))
    size = min(7.5, _LETTERS * 72 * radius)
    look: dict[str, Any] = {"ha": "center", "va": "center_baseline", "zorder": 3}
    short = short_name(name)
    if short.isdigit() or not named:  # a letter says no more than the name below
        inside = look | {"color": ink_on(colour), "fontsize": size, "fontweight": "bold"}
        axes.annotate(plain(short.upper()), _point(spot), **inside)
    if named:
        axes.annotate(plain(name), _point(spot - [0.0, radius + 0.08]), color=INK, fontsize=6.0, **look)


def _passes(spots: Array, start: Array, end: Array, radius: float) -> bool:
    """Returns whether a straight line between two circles runs over any other."""
    way = end - start
    along = (spots - start) @ way / (way @ way)
    beside = np.abs((spots - start) @ np.array([-way[1], way[0]])) / np.linalg.norm(way)
    between = (along * np.linalg.norm(way) > radius) & ((1 - along) * np.linalg.norm(way) > radius)
    return bool((between & (beside < 1.1 * radius)).any())


def _point(place: Array) -> tuple[float, float]:
    return float(place[0]), float(place[1])
