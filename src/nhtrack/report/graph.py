"""Who tracks whom, drawn as SVG."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from markupsafe import Markup

from nhtrack.arrays import Array
from nhtrack.colours import ink_on, robot_colour
from nhtrack.network import Network
from nhtrack.presentation.graph_layout import graph_places, graph_radius
from nhtrack.presentation.shown import short_name

_INCH = 110.0  # [px] of an inch of the layout
_WIDTH = 6.0  # [in] between the outermost robots, at most
_RADIUS = 14.0  # of a robot, where there is room [px]
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
    places = graph_places(parents, _WIDTH)
    spots, radius = _spots(places), _INCH * graph_radius(places, _RADIUS / _INCH)
    width, height = (max(spot[side] for spot in spots) + _MARGIN for side in (0, 1))
    edges = [(parent, child) for child, others in enumerate(network.parents) for parent in others]
    lines = Markup("").join(_edge(spots[parent], spots[child], radius) for parent, child in edges)
    robots = Markup("").join(
        _robot(spots[k], radius, name, looks.get(name, robot_colour(k))) for k, name in enumerate(network.names)
    )
    label = f"Communication graph of {len(network)} robots in {len(network.levels)} levels"
    return Markup(
        '<svg class="graph" role="img" aria-label="{}" viewBox="0 0 {:.0f} {:.0f}" width="{:.0f}" height="{:.0f}">'
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
        '<path d="M0,0.8 L8,4 L0,7.2 z"/></marker></defs><g class="edges">{}</g>{}</svg>'
    ).format(label, width, height, width, height, lines, robots)


def _spots(places: Mapping[str, Array]) -> list[Spot]:
    """Returns where robots stand [px], from the upper left."""
    spots = _INCH * np.array(list(places.values())) * (1.0, -1.0)
    return [(float(x), float(y)) for x, y in spots - spots.min(axis=0) + _MARGIN]


def _edge(start: Spot, end: Spot, radius: float) -> Markup:
    """Returns an arrow from the rim of one robot to that of another."""
    length = math.dist(start, end)
    x, y = ((radius + 2) * (b - a) / length for a, b in zip(start, end, strict=True))
    places = start[0] + x, start[1] + y, end[0] - x, end[1] - y
    return Markup('<line x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}" marker-end="url(#tip)"/>').format(*places)


def _robot(spot: Spot, radius: float, name: str, colour: str) -> Markup:
    circle = Markup('<circle cx="{:.1f}" cy="{:.1f}" r="{:.1f}" fill="{}"/>').format(*spot, radius, colour)
    place = spot[0], spot[1] + 4, ink_on(colour), short_name(name)
    text = Markup('<text x="{:.1f}" y="{:.1f}" fill="{}">{}</text>').format(*place)
    return Markup("<g><title>{}</title>{}{}</g>").format(name, circle, text)
