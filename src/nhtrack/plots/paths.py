"""Where the robots went: trajectories with oriented robots, as the paper draws them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon

from nhtrack import se2
from nhtrack.plots.ground import draw_ground, ground_of
from nhtrack.plots.style import CROWD, INK, panel_title, run_title, styled
from nhtrack.recording import Recording
from nhtrack.simulation.palette import ROOT, robot_colour

__all__ = ["draw_glyphs", "frame_panel", "trajectories"]

# A robot: a dart of unit length about its axle midpoint, nose along +x.
DART = np.array([[0.62, 0.0], [-0.38, 0.34], [-0.20, 0.0], [-0.38, -0.34]])

_GLYPH_SHARE = 0.055  # a robot's length as a share of the panel's larger side


@styled
def trajectories(recording: Recording, fractions: Sequence[float] = (0.15, 0.25, 0.5, 1.0)) -> Figure:
    """Returns the paths so far, with oriented robots, at fractions of the run.

    Lengths are in the scenario's own units, robot metres over `recording.length_scale`. MuJoCo's path is
    solid; the ideal twin's is dashed over it. Hollow robots mark where each began.

    Args:
        recording: the run; an interrupted one is shown as far as it went.
        fractions: shares of the run's end time, one panel each, in reading order.
    """
    columns = 1 if len(fractions) == 1 else 2
    rows = -(-len(fractions) // columns)
    pose = recording["pose"].values.copy()
    pose[..., :2] /= recording.length_scale
    twin, shape, ground = _twin(recording), _shape(pose), ground_of(recording)
    figure = Figure(figsize=(4.1 * columns, (3.5 * shape + 0.5) * rows + 0.8))
    panels = figure.subplots(rows, columns, squeeze=False)
    for k, (axes, fraction) in enumerate(zip(panels.flat, fractions, strict=False)):
        last = int(np.searchsorted(recording.time, fraction * recording.time[-1] + 1e-9, side="right"))
        shown = slice(0, max(last, 1))
        frame_panel(axes, pose[shown], shape)
        draw_ground(axes, ground, recording.length_scale)
        _draw_paths(axes, pose[shown], None if twin is None else twin[shown])
        draw_glyphs(axes, pose[shown])
        reached = recording.time[shown][-1] / recording.time_scale
        panel_title(axes, "abcdefghijklmnop"[k % 16], f"$t$ = {reached:.4g} s  ({fraction:.0%} of the run)")
    for axes in panels.flat[len(fractions) :]:
        axes.remove()
    for axes in panels[:, 0]:
        axes.set_ylabel("$y$ [m]")
    for axes in panels[-1]:
        axes.set_xlabel("$x$ [m]")
    run_title(figure, recording)
    _legend(figure, recording, twin is not None and len(recording.robots) - 1 <= CROWD)
    return figure


def _twin(recording: Recording) -> np.ndarray | None:
    """Returns the ideal twin's poses in scenario units, or None where the run is its own twin."""
    if recording.backend == "ideal" or "ideal_pose" not in recording.dataset:
        return None
    twin = recording["ideal_pose"].values.copy()
    twin[..., :2] /= recording.length_scale
    return twin


def _shape(pose: np.ndarray) -> float:
    """Returns the panels' height over width: the whole run's, within what looks well."""
    low, high = (bound(pose[..., :2], axis=(0, 1)) for bound in (np.nanmin, np.nanmax))
    width, height = np.maximum(high - low, 1e-9)
    return float(np.clip(height / width, 0.55, 1.15))


def frame_panel(axes: Axes, pose: np.ndarray, shape: float) -> None:
    """Sets equal axes around all positions, so that headings and curvature are seen undistorted."""
    low, high = (bound(pose[..., :2], axis=(0, 1)) for bound in (np.nanmin, np.nanmax))
    width = max(float(high[0] - low[0]), float(high[1] - low[1]) / shape, 1e-6) * (1 + 3 * _GLYPH_SHARE)
    centre = (low + high) / 2
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlim(centre[0] - width / 2, centre[0] + width / 2)
    axes.set_ylim(centre[1] - width * shape / 2, centre[1] + width * shape / 2)
    axes.locator_params(nbins=6)


def _draw_paths(axes: Axes, pose: np.ndarray, twin: np.ndarray | None) -> None:
    crowded = pose.shape[1] - 1 > CROWD
    for place in reversed(range(pose.shape[1])):
        path: dict[str, Any] = {"linewidth": 2.6, "zorder": 1.8} if place == 0 else {"linewidth": 1.4, "zorder": 2.0}
        if crowded and place:
            path |= {"linewidth": 0.7, "alpha": 0.6}
        axes.plot(*pose[:, place, :2].T, color=robot_colour(place), **path)
        if twin is not None and place and not crowded:
            axes.plot(*twin[:, place, :2].T, color=INK, linewidth=0.6, dashes=(5, 7), zorder=2.5)


def draw_glyphs(axes: Axes, pose: np.ndarray) -> None:
    """Draws the robots where they began and where they are, each smaller than the last: none hides another."""
    count = pose.shape[1]
    size = _GLYPH_SHARE * float(np.ptp(axes.get_xlim())) * (0.75 if count - 1 > CROWD else 1.0)
    lengths = size * np.concatenate([[1.3], np.linspace(0.95, 0.95 if count == 2 else 0.55, count - 1)])
    for place, length in enumerate(lengths):
        colour = robot_colour(place)
        start: dict[str, Any] = {"facecolor": "white", "edgecolor": colour, "linewidth": 0.9, "zorder": 3}
        now: dict[str, Any] = {"facecolor": colour, "edgecolor": "white", "linewidth": 0.6, "zorder": 4}
        for index, properties in ((0, start), (-1, now)):
            corners = se2.act(pose[index, place][None, :], length * DART)
            if np.isfinite(corners).all():
                axes.add_patch(Polygon(corners, closed=True, **properties))


def _legend(figure: Figure, recording: Recording, twin: bool) -> None:
    dart: dict[str, Any] = {
        "marker": ">",
        "markersize": 6,
        "markeredgecolor": "white",
        "markeredgewidth": 0.4,
    }
    entries = [Line2D([], [], color=ROOT, label=recording.robots[0], **dart)]
    followers = list(enumerate(recording.robots))[1:]
    named = followers if len(followers) <= CROWD else []
    entries += [Line2D([], [], color=robot_colour(place), label=name, **dart) for place, name in named]
    if not named and followers:
        entries.append(Line2D([], [], color=robot_colour(1), label=f"{len(followers)} followers", **dart))
    if twin:
        entries.append(Line2D([], [], color=INK, linewidth=0.6, dashes=(5, 7), label="ideal twin"))
    start: dict[str, Any] = {"marker": ">", "markersize": 6, "linestyle": "none", "markerfacecolor": "white"}
    entries.append(Line2D([], [], color="#666666", markeredgecolor="#666666", label="start", **start))
    scale = recording.length_scale
    title = None if scale == 1.0 else f"lengths in the scenario's units: 1 m is {1000 * scale:.4g} mm on the floor"
    figure.legend(
        handles=entries, loc="outside lower center", ncols=min(len(entries), 6), title=title, title_fontsize=8
    )
