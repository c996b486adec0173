"""Who tracks whom, drawn."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch
from matplotlib.path import Path
from matplotlib.patheffects import withStroke

from nhtrack.arrays import Array
from nhtrack.colours import INK, PAPER, ink_on, robot_colour
from nhtrack.plots.margins import shortened
from nhtrack.plots.style import COLUMN, plain
from nhtrack.presentation.graph_layout import graph_layout
from nhtrack.presentation.shown import short_name

_RADIUS = 0.13  # [in] of a robot's circle, where there is room
_MARGIN = 0.20  # [in] around the circles
_LETTERS = 1.0  # [pt] of a circle's letters over its radius [pt]
_NAME = 6.0  # [pt] of the letters of names


def draw_graph(parents: Mapping[str, Sequence[str]], header: Callable[[Figure], float] = lambda figure: 0.0) -> Figure:
    """Returns a figure one column wide of arrows from parents to the robots that track them.

    Circles have the robots' colours and the numbers at the ends of their names, which stand below where there is room.

    Args:
        parents: of every robot by name, the root first.
        header: writes what stands above into the figure and returns the height that this takes up [in].
    """
    layout = graph_layout(parents, COLUMN - 2 * _MARGIN, _RADIUS)
    everything = np.concatenate([np.array(list(layout.places.values())), *layout.ways.values()])
    below = 0.12 if layout.name_width else 0.0
    low, high = everything.min(axis=0) - _MARGIN - [0.0, below], everything.max(axis=0) + _MARGIN
    height = float(high[1] - low[1])
    figure = Figure(figsize=(COLUMN, height))
    figure.set_figheight(height + header(figure))
    axes = figure.add_axes((0.0, 0.0, 1.0, height / figure.get_figheight()))  # a unit is an inch
    middle = (low[0] + high[0]) / 2
    axes.set(xlim=(middle - COLUMN / 2, middle + COLUMN / 2), ylim=(low[1], high[1]))
    axes.axis("off")
    for way in layout.ways.values():
        _draw_arrow(axes, way, layout.radius)
    for place, (name, spot) in enumerate(layout.places.items()):
        _draw_robot(axes, name, spot, robot_colour(place), layout.radius, layout.name_width)
    return figure


def _draw_arrow(axes: Axes, way: Array, radius: float) -> None:
    """Draws an arrow along a way, see `GraphLayout.ways`."""
    path = Path(way, [Path.MOVETO, *(len(way) - 1) * [Path.CURVE4]])
    look: dict[str, Any] = {"color": "#777777", "linewidth": 0.6, "zorder": 1}
    axes.add_patch(FancyArrowPatch(path=path, arrowstyle="-|>", mutation_scale=min(7.0, 45 * radius), **look))


def _draw_robot(axes: Axes, name: str, spot: Array, colour: str, radius: float, name_width: float) -> None:
    axes.add_patch(Circle(_point(spot), radius, facecolor=colour, edgecolor="none", zorder=2))
    look: dict[str, Any] = {"ha": "center", "va": "center_baseline", "zorder": 3}
    short = short_name(name)
    if short.isdigit() or short == name or not name_width:  # a letter says no more than the name below
        inside = look | {"color": ink_on(colour), "fontsize": min(7.5, _LETTERS * 72 * radius), "fontweight": "bold"}
        axes.annotate(plain(short.upper()), _point(spot), **inside)
    if name_width and short != name:
        look |= {"color": INK, "fontsize": _NAME, "path_effects": [withStroke(linewidth=2.0, foreground=PAPER)]}
        axes.annotate(plain(shortened(name, _NAME, name_width)), _point(spot - [0.0, radius + 0.08]), **look)


def _point(place: Array) -> tuple[float, float]:
    return float(place[0]), float(place[1])
