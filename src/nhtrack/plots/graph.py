"""Who tracks whom, as the paper draws it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.patches import Circle, FancyArrowPatch

from nhtrack.arrays import Array
from nhtrack.colours import INK, ink_on, robot_colour
from nhtrack.network import generations
from nhtrack.plots.style import styled
from nhtrack.presentation.shown import short_name

__all__ = ["left_title", "parents_graph", "point"]


@styled
def parents_graph(parents: Mapping[str, Sequence[str]], title: str) -> Figure:
    """Returns who tracks whom: the root at the left, every robot right of all its parents.

    Args:
        parents: of every robot, the root first.
        title: of the figure.
    """
    spots = _spots(parents)
    low, high = (bound(np.array(list(spots.values())), axis=0) for bound in (np.min, np.max))
    figure = Figure(figsize=(1.0 + 0.9 * (high[0] - low[0]), 1.1 + 0.9 * (high[1] - low[1])))
    axes = figure.subplots()
    axes.set_aspect("equal")
    axes.axis("off")
    for parent, name in ((parent, name) for name, others in parents.items() for parent in others):
        ends = np.array([spots[parent], spots[name]])
        away = 0.32 * (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        line: dict[str, Any] = {
            "arrowstyle": "-|>",
            "mutation_scale": 12,
            "shrinkA": 0,
            "shrinkB": 0,
            "color": INK,
        }
        axes.add_patch(FancyArrowPatch(ends[0] + away, ends[1] - away, **line))
    for place, name in enumerate(parents):
        axes.add_patch(Circle(point(spots[name]), 0.27, facecolor=robot_colour(place), edgecolor="white"))
        ink = ink_on(robot_colour(place))
        axes.annotate(short_name(name), point(spots[name]), color=ink, ha="center", va="center", fontweight="bold")
    axes.set_xlim(low[0] - 0.4, high[0] + 0.4)
    axes.set_ylim(low[1] - 0.4, high[1] + 0.4)
    left_title(figure, title)
    return figure


def left_title(figure: Figure, title: str) -> None:
    """Writes a title at the left of a figure, with air below it."""
    figure.suptitle(title, x=0.01, ha="left", fontsize=11.0, fontweight="bold", color=INK)
    engine = figure.get_layout_engine()
    if isinstance(engine, ConstrainedLayoutEngine):
        engine.set(h_pad=0.09)


def _spots(parents: Mapping[str, Sequence[str]]) -> dict[str, Array]:
    """Returns places of the robots of a graph: levels 1.6 apart from left to right, a level's robots 1 apart."""
    return {
        name: np.array([1.6 * level, (len(names) - 1) / 2 - row])
        for level, names in enumerate(generations(parents))
        for row, name in enumerate(names)
    }


def point(place: Array) -> tuple[float, float]:
    """Returns a place as Matplotlib takes it."""
    return float(place[0]), float(place[1])
