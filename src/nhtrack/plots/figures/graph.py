"""Who tracks whom in a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch

from nhtrack.arrays import Array
from nhtrack.colours import INK, ink_on, robot_colour
from nhtrack.network import generations
from nhtrack.plots.graph import point
from nhtrack.plots.names import spread
from nhtrack.plots.style import COLUMN, column_styled, plain, run_title
from nhtrack.presentation.shown import short_name
from nhtrack.recording import Recording

_RADIUS = 0.13  # [in] of a robot's circle, where there is room
_FILLS = 0.44  # its radius, at most, over the distance to the next circle
_SPACING = (0.8, 0.42)  # [in] between levels, and between the robots of a level, at most
_LEAST_ROW = 0.19  # [in] between the robots of a level, at least
_MARGIN = 0.20  # [in] around the circles
_WIDEST = 20  # a level of more robots is a ring around the root
_LINE = 10  # levels in a line; a longer chain goes on in the next, back and forth
_LETTERS = 1.0  # [pt] of a circle's letters over its radius [pt]
_NAMED = 10  # robots, at most, whose names are written in full below their circles


@column_styled
def graph(recording: Recording) -> Figure:
    """Returns who tracks whom in a run: arrows from parents to the robots that track them.

    Levels, robots by the length of the longest way from the root, go from left to right; where one has very many, they
    are rings around it. Circles have the robots' colours, and the numbers at the ends of their names.
    """
    parents = recording.parents
    spots = _placed(parents)
    everything = np.array(list(spots.values()))
    gap = _least_distance(everything)
    radius = min(_RADIUS, _FILLS * gap)
    named = len(spots) <= _NAMED and any(short_name(name) != name for name in spots)
    low = everything.min(axis=0) - _MARGIN - [0.0, 0.12 if named else 0.0]
    high = everything.max(axis=0) + _MARGIN
    height = float(high[1] - low[1])
    figure = Figure(figsize=(COLUMN, height))
    figure.set_figheight(height + run_title(figure, recording))
    axes = figure.add_axes((0.0, 0.0, 1.0, height / figure.get_figheight()))  # a unit is an inch
    middle = (low[0] + high[0]) / 2
    axes.set(xlim=(middle - COLUMN / 2, middle + COLUMN / 2), ylim=(low[1], high[1]))
    axes.axis("off")
    for name, others in parents.items():
        for parent in others:
            ends = spots[parent], spots[name]
            _draw_arrow(axes, *ends, radius, bent=_passes(everything, *ends, radius))
    for place, name in enumerate(recording.robots):
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
    axes.add_patch(Circle(point(spot), radius, facecolor=colour, edgecolor="none", zorder=2))
    size = min(7.5, _LETTERS * 72 * radius)
    look: dict[str, Any] = {"ha": "center", "va": "center_baseline", "zorder": 3}
    short = short_name(name)
    if short.isdigit() or not named:  # a letter says no more than the name below
        inside = look | {"color": ink_on(colour), "fontsize": size, "fontweight": "bold"}
        axes.annotate(plain(short.upper()), point(spot), **inside)
    if named:
        axes.annotate(plain(name), point(spot - [0.0, radius + 0.08]), color=INK, fontsize=6.0, **look)


def _passes(spots: Array, start: Array, end: Array, radius: float) -> bool:
    """Returns whether a straight line between two circles runs over any other."""
    way = end - start
    along = (spots - start) @ way / (way @ way)
    beside = np.abs((spots - start) @ np.array([-way[1], way[0]])) / np.linalg.norm(way)
    between = (along * np.linalg.norm(way) > radius) & ((1 - along) * np.linalg.norm(way) > radius)
    return bool((between & (beside < 1.1 * radius)).any())


def _least_distance(spots: Array) -> float:
    """Returns the distance between the two places that are nearest to each other."""
    apart = np.linalg.norm(spots[:, None] - spots[None], axis=-1)
    return float(apart[apart > 0].min(initial=np.inf))


def _placed(parents: Mapping[str, Sequence[str]]) -> dict[str, Array]:
    """Returns places of robots [in]: levels as columns from left to right, or rings where one has very many robots."""
    levels = _levels(parents)
    return _rings(levels, parents) if max(map(len, levels)) > _WIDEST else _columns(levels)


def _levels(parents: Mapping[str, Sequence[str]]) -> list[list[str]]:
    """Returns the robots of every level, each as near as may be to its parents' places in theirs."""
    share: dict[str, float] = {}  # how far down its level a robot is
    levels = []
    for level in generations(parents):
        level.sort(key=lambda name: float(np.mean([share[parent] for parent in parents[name]] or [0.0])))
        share |= {name: (row + 0.5) / len(level) for row, name in enumerate(level)}
        levels.append(level)
    return levels


def _columns(levels: Sequence[Sequence[str]]) -> dict[str, Array]:
    most = max(map(len, levels))
    across = min(_SPACING[0], (COLUMN - 2 * _MARGIN) / max(min(len(levels), _LINE) - 1, 1))
    down = float(np.clip(2.4 / max(most - 1, 1), _LEAST_ROW, _SPACING[1]))
    spots = {}
    for k, level in enumerate(levels):
        line, column = divmod(k, _LINE)
        x = across * (column if line % 2 == 0 else _LINE - 1 - column)
        for row, name in enumerate(level):
            y = down * ((len(level) - 1) / 2 - row) - line * (down * (most - 1) + _SPACING[1])
            spots[name] = np.array([x, y])
    return spots


def _rings(levels: Sequence[Sequence[str]], parents: Mapping[str, Sequence[str]]) -> dict[str, Array]:
    """Returns places on rings around the root, each robot about as far round as its parents."""
    step = (COLUMN / 2 - _MARGIN) / (len(levels) - 1)
    share: dict[str, float] = {}  # how far round its ring a robot is, from 0 to 1
    spots = {levels[0][0]: np.zeros(2)}
    for k, level in enumerate(levels[1:], start=1):
        if k == 1:
            shares = (np.arange(len(level)) + 0.5) / len(level)
        else:
            least = min(_LEAST_ROW / (2 * np.pi * k * step), 1 / len(level))
            wanted = [np.mean([share.get(parent, 0.5) for parent in parents[name]]) for name in level]
            shares = spread(np.array(wanted), least)
        share |= dict(zip(level, shares.tolist(), strict=True))
        angle = np.pi / 2 - 2 * np.pi * shares
        places = k * step * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        spots |= dict(zip(level, places, strict=True))
    return spots
