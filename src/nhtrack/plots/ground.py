"""What the robots drove on: patches of another friction, and which way is up."""

from __future__ import annotations

import json
from typing import Any, TypeAlias

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Rectangle

from nhtrack.ground import Ground, Patch
from nhtrack.plots.style import INK
from nhtrack.recording import Recording
from nhtrack.simulation.palette import GRIP, ICE

__all__ = ["draw_ground", "ground_of"]

_LEAST_SEEN = 0.1  # share of a panel's sides that a patch must take up to be labelled

Box: TypeAlias = tuple[tuple[float, float], tuple[float, float]]


def ground_of(recording: Recording) -> Ground:
    """Returns what the robots of a recording stood on."""
    scene = json.loads(recording.dataset.attrs.get("scene", "{}"))  # by itself: a figure needs no MuJoCo
    patches = tuple(Patch(**patch) for patch in scene.get("patches", ()))
    plane = {name: scene[name] for name in ("friction", "slope", "uphill") if name in scene}
    return Ground(patches=patches, **plane)


def draw_ground(axes: Axes, ground: Ground, length_scale: float) -> None:
    """Draws patches with their friction, and an arrow uphill, below everything else.

    Args:
        axes: with their limits set, in scenario units.
        ground: in robot units.
        length_scale: robot metres per scenario length unit.
    """
    for patch in ground.patches:
        shape, box = _shape(patch, length_scale)
        colour = ICE if patch.friction < ground.friction else GRIP
        shape.set(facecolor=colour, edgecolor=INK, linewidth=0.5, alpha=0.45, zorder=0.8, clip_on=True)
        axes.add_artist(shape)
        place = _label_place(box, axes)
        if place is not None:
            look: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 7, "color": INK, "zorder": 1.2}
            axes.text(*place, f"friction\n{patch.friction:g}", **look)
    if ground.slope:
        x, y = 0.07 * float(np.cos(ground.uphill)), 0.07 * float(np.sin(ground.uphill))
        axes.annotate(
            "", (0.91 + x, 0.90 + y), (0.91 - x, 0.90 - y), xycoords="axes fraction", textcoords="axes fraction",
            arrowprops={"arrowstyle": "->", "color": INK, "linewidth": 0.9},
        )  # fmt: skip
        axes.annotate(
            f"uphill, {np.degrees(ground.slope):.3g}°", (0.98, 0.80), xycoords="axes fraction", ha="right", fontsize=7,
            color=INK,
        )  # fmt: skip


def _shape(patch: Patch, length_scale: float) -> tuple[Artist, Box]:
    """Returns the drawing of a patch and its sides (x_min, x_max), (y_min, y_max)."""
    if patch.disc is not None:
        x, y, radius = (value / length_scale for value in patch.disc)
        return Circle((x, y), radius), ((x - radius, x + radius), (y - radius, y + radius))
    assert patch.rectangle is not None
    x_min, x_max, y_min, y_max = (value / length_scale for value in patch.rectangle)
    return Rectangle((x_min, y_min), x_max - x_min, y_max - y_min), ((x_min, x_max), (y_min, y_max))


def _label_place(box: Box, axes: Axes) -> tuple[float, float] | None:
    """Returns a place in the lower part of what is seen of a box, or None where too little of it is."""
    low, high = (
        [choose(side[end], limits[end]) for side, limits in zip(box, (axes.get_xlim(), axes.get_ylim()), strict=True)]
        for choose, end in ((max, 0), (min, 1))
    )
    spans = float(np.ptp(axes.get_xlim())), float(np.ptp(axes.get_ylim()))
    if any(top - bottom < _LEAST_SEEN * span for bottom, top, span in zip(low, high, spans, strict=True)):
        return None
    return (low[0] + high[0]) / 2, low[1] + 0.2 * (high[1] - low[1])
