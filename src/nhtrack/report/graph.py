"""Who tracks whom, drawn as SVG."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from markupsafe import Markup

from nhtrack.arrays import Array
from nhtrack.colours import ink_on, robot_colour
from nhtrack.network import generations
from nhtrack.presentation.graph_layout import graph_layout
from nhtrack.presentation.shown import short_name

_INCH = 120.0  # [px] of an inch of the layout
_WIDTH = 6.0  # [in] between the outermost robots, at most
_RADIUS = 0.13  # [in] of a robot, where there is room
_MARGIN = 32.0  # [px] around the circles
_LETTER = 6.2  # [px] width of a letter of a name
_BELOW = 12.0  # [px] from a circle to the base line of its name


def graph_svg(parents: Mapping[str, Sequence[str]], colours: Sequence[str] = ()) -> Markup:
    """Returns the communication graph as an SVG element; names are escaped.

    Args:
        parents: of every robot by name; the root has none.
        colours: of the robots, `#RRGGBB`; by default those of their places.
    """
    looks = colours or [robot_colour(place) for place in range(len(parents))]
    layout = graph_layout(parents, _WIDTH, _RADIUS)
    everything = np.concatenate([np.array(list(layout.places.values())), *layout.ways.values()]) * (1.0, -1.0)
    corner = _MARGIN - _INCH * everything.min(axis=0)
    width, height = _INCH * np.ptp(everything, axis=0) + 2 * _MARGIN
    arrows = Markup("").join(_arrow(corner + _INCH * way * (1.0, -1.0)) for way in layout.ways.values())
    letters = int(_INCH * layout.name_width / _LETTER)
    robots = Markup("").join(
        _robot(corner + _INCH * spot * (1.0, -1.0), _INCH * layout.radius, name, colour, letters)
        for (name, spot), colour in zip(layout.places.items(), looks, strict=True)
    )
    label = f"Communication graph of {len(parents)} robots in {len(list(generations(parents)))} levels"
    return Markup(
        '<svg class="graph" role="img" aria-label="{}" viewBox="0 0 {:.0f} {:.0f}" width="{:.0f}" height="{:.0f}">'
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
        '<path d="M0,0.8 L8,4 L0,7.2 z"/></marker></defs><g class="edges">{}</g>{}</svg>'
    ).format(label, width, height, width, height, arrows, robots)


def _arrow(way: Array) -> Markup:
    """Returns an arrow along a way, see `GraphLayout.ways`, in pixels."""
    start, *corners = (f"{x:.1f},{y:.1f}" for x, y in way)
    return Markup('<path d="M{}C{}" marker-end="url(#tip)"/>').format(start, " ".join(corners))


def _robot(spot: Array, radius: float, name: str, colour: str, letters: int) -> Markup:
    """Returns a robot: its number in its circle, and its name below where there is room for some letters."""
    short, (x, y) = short_name(name), spot
    parts = Markup('<circle cx="{:.1f}" cy="{:.1f}" r="{:.1f}" fill="{}"/>').format(x, y, radius, colour)
    if short.isdigit() or short == name or not letters:  # a letter says no more than the name below
        parts += Markup('<text x="{:.1f}" y="{:.1f}" fill="{}">{}</text>').format(x, y + 4, ink_on(colour), short)
    if letters and short != name:
        below = name if len(name) <= letters else f"{name[: letters - 1]}…"
        parts += Markup('<text class="name" x="{:.1f}" y="{:.1f}">{}</text>').format(x, y + radius + _BELOW, below)
    return Markup("<g><title>{}</title>{}</g>").format(name, parts)
