"""Who tracks whom, drawn as SVG: the root at the left, every robot right of all its parents."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from markupsafe import Markup

from nhtrack.colours import ink_on, robot_colour
from nhtrack.network import Network
from nhtrack.presentation.shown import short_name

_RADIUS = 14.0  # of a robot [px]
_ROW, _COLUMN, _LEVEL = 36.0, 44.0, 92.0  # [px] between robots, between columns of one level, between levels
_TALL = 20  # robots in a column; a level with more has several columns
_MARGIN = 22.0

Spot = tuple[float, float]


def graph_svg(parents: Mapping[str, Sequence[str]], colours: Sequence[str] = ()) -> Markup:
    """Returns the communication graph as an SVG element; names are escaped.

    Args:
        parents: of every robot by name; the root has none.
        colours: of the robots, `#RRGGBB`; by default those of their places.
    """
    looks = dict(zip(parents, colours, strict=True)) if colours else {}
    network = Network.from_parents(parents)
    spots = _spots(network)
    width, height = (max(spot[side] for spot in spots) + _MARGIN for side in (0, 1))
    edges = [(parent, child) for child, others in enumerate(network.parents) for parent in others]
    lines = Markup("").join(_edge(spots[parent], spots[child]) for parent, child in edges)
    robots = Markup("").join(
        _robot(spots[k], name, looks.get(name, robot_colour(k))) for k, name in enumerate(network.names)
    )
    label = f"Communication graph of {len(network)} robots in {len(network.levels)} levels"
    return Markup(
        '<svg class="graph" role="img" aria-label="{}" viewBox="0 0 {:.0f} {:.0f}" width="{:.0f}" height="{:.0f}">'
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
        '<path d="M0,0.8 L8,4 L0,7.2 z"/></marker></defs><g class="edges">{}</g>{}</svg>'
    ).format(label, width, height, width, height, lines, robots)


def _spots(network: Network) -> list[Spot]:
    """Returns where every robot stands [px]: levels from left to right, each centred on half the height."""
    columns = [
        level[start : start + per_column]
        for level in network.levels
        for per_column in [math.ceil(len(level) / math.ceil(len(level) / _TALL))]
        for start in range(0, len(level), per_column)
    ]
    level_of = {int(robot): k for k, level in enumerate(network.levels) for robot in level}
    middle = _MARGIN + _ROW * (max(len(column) for column in columns) - 1) / 2
    spots: list[Spot] = [(0.0, 0.0)] * len(network)
    x = _MARGIN
    for k, column in enumerate(columns):
        if k:
            x += _COLUMN if level_of[int(column[0])] == level_of[int(columns[k - 1][0])] else _LEVEL
        for row, robot in enumerate(column):
            spots[int(robot)] = (x, middle + _ROW * (row - (len(column) - 1) / 2))
    return spots


def _edge(start: Spot, end: Spot) -> Markup:
    """Returns an arrow from the rim of one robot to that of another."""
    length = math.dist(start, end)
    x, y = ((_RADIUS + 2) * (b - a) / length for a, b in zip(start, end, strict=True))
    places = start[0] + x, start[1] + y, end[0] - x, end[1] - y
    return Markup('<line x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}" marker-end="url(#tip)"/>').format(*places)


def _robot(spot: Spot, name: str, colour: str) -> Markup:
    circle = Markup('<circle cx="{:.1f}" cy="{:.1f}" r="{:.0f}" fill="{}"/>').format(*spot, _RADIUS, colour)
    place = spot[0], spot[1] + 4, ink_on(colour), short_name(name)
    text = Markup('<text x="{:.1f}" y="{:.1f}" fill="{}">{}</text>').format(*place)
    return Markup("<g><title>{}</title>{}{}</g>").format(name, circle, text)
