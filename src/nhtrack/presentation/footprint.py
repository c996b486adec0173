"""Robots as seen from above: to scale where they are large enough to be seen, as darts of a fixed size elsewhere."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

from nhtrack import se2
from nhtrack.colours import INK
from nhtrack.presentation.numbers import quantity
from nhtrack.recording import Recording

__all__ = [
    "DART",
    "Footprint",
    "dart_outlines",
    "draw_dart",
    "draw_footprint",
    "footprint_of",
    "is_seen",
    "points_per_metre",
    "scale_note",
]

# A robot: a dart of unit length about its axle midpoint, nose along +x.
DART = np.array([[0.62, 0.0], [-0.38, 0.34], [-0.20, 0.0], [-0.38, -0.34]])

_LEAST_SEEN = 9.0  # [pt] from wheel to wheel: in a smaller footprint no wheel could be told from the body
_TYRE = 0.35  # width of a wheel over its radius: a recording does not tell it, nor the outline of the body
# The body between the wheels, over its half width: as long as it is wide, with a nose.
_BODY = np.array([[1.0, 0.0], [0.6, 0.8], [-1.0, 0.8], [-1.0, -0.8], [0.6, -0.8]])
_SQUARE = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])


class Footprint(NamedTuple):
    """What a recording tells of a robot's outline.

    Attributes:
        half_separation: of the wheels [m].
        wheel_radius: [m].
    """

    half_separation: float
    wheel_radius: float


def footprint_of(recording: Recording) -> Footprint | None:
    """Returns the footprint of a recording's robots, or None where it does not tell."""
    robot = recording.robot
    known = np.isfinite(robot.half_separation) and np.isfinite(robot.wheel_radius)
    return Footprint(robot.half_separation, robot.wheel_radius) if known else None


def points_per_metre(axes: Axes) -> float:
    """Returns how large a metre of a panel is [pt], its limits and layout as they stay."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    return float(axes.get_window_extent().width * 72 / figure.dpi / np.ptp(axes.get_xlim()))


def is_seen(footprint: Footprint | None, axes: Axes) -> bool:
    """Returns whether a footprint is large enough in a panel to be drawn to scale."""
    return footprint is not None and 2 * footprint.half_separation * points_per_metre(axes) >= _LEAST_SEEN


def draw_footprint(
    axes: Axes, pose: np.ndarray, footprint: Footprint, colour: str, *, hollow: bool, zorder: float
) -> None:
    """Draws a robot to scale: wheels, and a body between them whose nose points ahead.

    The body lets through what is below it, so that robots that coincide are both seen.

    Args:
        axes: in robot metres.
        pose: x, y [m], theta [rad], shape (3,); one that is not finite is not drawn.
        footprint: of the robot.
        colour: of the robot.
        hollow: whether only its outline is drawn.
        zorder: of the body; the wheels are just above.
    """
    if not np.isfinite(pose).all():
        return
    width, radius = _TYRE * footprint.wheel_radius, footprint.wheel_radius
    body = footprint.half_separation * _BODY
    look: dict[str, Any] = {"closed": True, "edgecolor": colour, "linewidth": 0.6}
    face: dict[str, Any] = {"facecolor": "none"} if hollow else {"facecolor": (colour, 0.65)}
    axes.add_artist(Polygon(se2.act(pose[None, :], body), zorder=zorder, **look, **face))
    for side in (1.0, -1.0):
        wheel = _SQUARE * [radius, width / 2] + [0.0, side * footprint.half_separation]
        tyre: dict[str, Any] = {"facecolor": "white" if hollow else INK, "edgecolor": colour if hollow else INK}
        tyre |= {"linewidth": 0.4, "zorder": zorder + 0.05}
        axes.add_artist(Polygon(se2.act(pose[None, :], wheel), closed=True, **tyre))


def dart_outlines(axes: Axes, poses: np.ndarray, points: float) -> np.ndarray:
    """Returns the corners of darts of a length in points [pt] at poses (k, 3) in a panel, shape (4, k, 2)."""
    return np.asarray(se2.act(poses[None], points / points_per_metre(axes) * DART[:, None]))


def draw_dart(axes: Axes, pose: np.ndarray, length: float, **look: Any) -> None:
    """Draws a robot as a dart of a length in the axes' unit; a pose (3,) that is not finite is not drawn."""
    corners = se2.act(pose[None, :], length * DART)
    if np.isfinite(corners).all():
        axes.add_artist(Polygon(corners, closed=True, **look))  # add_patch would look at limits, which stay


def scale_note(footprint: Footprint) -> str:
    """Returns a sentence for the note below a figure that draws robots as darts: how large they are."""
    return f"Darts not to scale: wheels {quantity(2 * footprint.half_separation, 'm')} apart."
