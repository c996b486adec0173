"""Paths in a panel: equal axes around them, robots as darts where they began and where they are."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from nhtrack.colours import robot_colour
from nhtrack.presentation.footprint import DART, draw_dart
from nhtrack.presentation.shown import CROWD

__all__ = ["DART", "draw_glyphs", "frame_panel"]

_GLYPH_SHARE = 0.055  # a robot's length as a share of the panel's larger side


def frame_panel(axes: Axes, pose: np.ndarray, shape: float, margin: float = 0.0) -> None:
    """Sets equal axes around all positions, so that headings and curvature are seen undistorted.

    Args:
        axes: the panel.
        pose: everything that is shown, shape (t, n, 3).
        shape: height of the panel over its width.
        margin: around the positions, in the axes' unit: half of a robot.
    """
    low = np.nanmin(pose[..., :2], axis=(0, 1)) - margin
    high = np.nanmax(pose[..., :2], axis=(0, 1)) + margin
    width = max(float(high[0] - low[0]), float(high[1] - low[1]) / shape, 1e-6) * (1 + 3 * _GLYPH_SHARE)
    centre = (low + high) / 2
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlim(centre[0] - width / 2, centre[0] + width / 2)
    axes.set_ylim(centre[1] - width * shape / 2, centre[1] + width * shape / 2)
    axes.locator_params(nbins=6)


def draw_glyphs(axes: Axes, pose: np.ndarray, size: float | None = None) -> None:
    """Draws the robots as darts where they began and where they are, each smaller than the last: none hides another.

    Args:
        axes: with its limits as they stay.
        pose: shape (t, n, 3).
        size: length of a dart in the axes' unit; a share of the panel by default.
    """
    count = pose.shape[1]
    length = _GLYPH_SHARE * float(np.ptp(axes.get_xlim())) if size is None else size
    length *= 0.75 if count - 1 > CROWD else 1.0
    lengths = length * np.concatenate([[1.3], np.linspace(0.95, 0.95 if count == 2 else 0.55, count - 1)])
    thin = 1.0 if size is None else 0.6
    for place, each in enumerate(lengths):
        colour = robot_colour(place)
        start: dict[str, Any] = {"facecolor": "white", "edgecolor": colour, "linewidth": 0.9 * thin, "zorder": 3}
        now: dict[str, Any] = {"facecolor": colour, "edgecolor": "white", "linewidth": 0.6 * thin, "zorder": 4}
        for index, look in ((0, start), (-1, now)):
            draw_dart(axes, pose[index, place], each, **look)
