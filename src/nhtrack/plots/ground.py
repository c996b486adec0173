"""What the robots drove on: patches of another friction, and which way is up."""

from __future__ import annotations

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Rectangle

from nhtrack.colours import GRIP, ICE, INK
from nhtrack.ground import Ground, Patch
from nhtrack.plots.names import Path
from nhtrack.presentation.numbers import degrees
from nhtrack.presentation.shown import ground_of

__all__ = ["draw_ground", "draw_uphill", "ground_of", "slope_note"]

_LEAST_SEEN = 0.1  # share of a panel's sides that a patch must take up to be labelled
_CORNERS = np.array([[0.91, 0.89], [0.09, 0.89], [0.91, 0.11], [0.09, 0.11]])  # of a panel, in shares of it
_ARROW = 0.07  # half the length of an arrow, in shares of a panel
_POINTS = 201  # of the edge of a patch


def draw_ground(axes: Axes, ground: Ground) -> dict[str, Path]:
    """Draws patches below everything else.

    Args:
        axes: with their limits set, in robot metres.
        ground: what there is to draw.

    Returns:
        What is to be written beside which patches, for `name_paths`: the outlines of those that can be seen well.
    """
    named: dict[str, list[np.ndarray]] = {}
    for patch in ground.patches:
        shape, outline = _shape(patch)
        colour = ICE if patch.friction < ground.friction else GRIP
        shape.set(facecolor=colour, edgecolor=INK, linewidth=0.5, alpha=0.45, zorder=0.8, clip_on=True)
        axes.add_artist(shape)
        if _is_seen(outline, axes):
            named.setdefault(f"friction {patch.friction:g}", []).append(outline)
    return {text: Path(np.stack(outlines, axis=1), INK, tied=True) for text, outlines in named.items()}


def draw_uphill(axes: Axes, ground: Ground, taken: np.ndarray) -> np.ndarray:
    """Draws an arrow uphill, if there is a way up, into the corner of a panel that keeps clear of what is there.

    Args:
        axes: with their limits set, in robot metres.
        ground: of the run.
        taken: points to keep clear of [m], shape (..., 2).

    Returns:
        Both ends of the arrow [m], for others to keep clear of, shape (2, k, 2).
    """
    if not ground.slope:
        return np.empty((2, 0, 2))
    points = axes.transLimits.transform(taken.reshape(-1, 2))
    apart = [float(np.nanmin(np.hypot(*(points - corner).T), initial=np.inf)) for corner in _CORNERS]
    middle = _CORNERS[int(np.argmax(np.minimum(apart, 2 * _ARROW)))]  # the first that is clear
    along = _ARROW * np.array([np.cos(ground.uphill), np.sin(ground.uphill)])
    axes.annotate(
        "", tuple(middle + along), tuple(middle - along), xycoords="axes fraction", textcoords="axes fraction",
        arrowprops={"arrowstyle": "->", "color": INK, "linewidth": 0.9},
    )  # fmt: skip
    return np.asarray(axes.transLimits.inverted().transform([middle - along, middle + along]))[:, None]


def slope_note(ground: Ground) -> list[str]:
    """Returns what to say of the arrow uphill below a figure; nothing on a level floor."""
    return [f"Arrow: uphill, {degrees(ground.slope)}."] if ground.slope else []


def _shape(patch: Patch) -> tuple[Artist, np.ndarray]:
    """Returns the drawing of a patch and points along its edge, shape (m, 2)."""
    along = np.linspace(0.0, 1.0, _POINTS)
    if patch.disc is not None:
        x, y, radius = patch.disc
        angle = 2 * np.pi * along
        return Circle((x, y), radius), np.array([x, y]) + radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    assert patch.rectangle is not None
    x_min, x_max, y_min, y_max = patch.rectangle
    corners = np.array([[x_min, y_min], [x_max, y_min], [x_max, y_max], [x_min, y_max], [x_min, y_min]])
    edge = np.stack([np.interp(4 * along, range(5), corners[:, side]) for side in (0, 1)], axis=-1)
    return Rectangle((x_min, y_min), x_max - x_min, y_max - y_min), edge


def _is_seen(outline: np.ndarray, axes: Axes) -> bool:
    """Returns whether so much of a patch is in a panel that it is worth a name."""
    limits = np.array([axes.get_xlim(), axes.get_ylim()])
    seen = np.minimum(outline.max(axis=0), limits[:, 1]) - np.maximum(outline.min(axis=0), limits[:, 0])
    return bool((seen >= _LEAST_SEEN * np.ptp(limits, axis=1)).all())
