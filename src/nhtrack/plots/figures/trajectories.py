"""Where the robots went: trajectories with oriented robots, as the paper draws them.

Lengths are metres on the floor and times seconds of the robots' clock, as in every other figure of a run: errors, slip
and gaps are told in metres of what was driven, and a reader holds them against the paths. A scenario that is scaled
from a paper's hundreds of metres says below what its metre and its second became; the figures of `nhtrack paper`, which
are held against the printed ones, keep the paper's units.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from nhtrack.analysis.event import Event
from nhtrack.analysis.events import find_events
from nhtrack.analysis.touches import touch_place
from nhtrack.colours import INK, PAPER, robot_colour
from nhtrack.plots.ground import draw_ground, draw_uphill, ground_of, slope_note
from nhtrack.plots.margins import (
    EDGE,
    Box,
    Numbers,
    axis_room,
    label_room,
    number_room,
    number_width,
    place_labels,
    place_panel,
    title_room,
)
from nhtrack.plots.names import Path, name_paths
from nhtrack.plots.paths import draw_glyphs, frame_panel
from nhtrack.plots.style import COLUMN, column_styled, panel_title, run_title, write_note
from nhtrack.presentation.footprint import (
    Footprint,
    dart_outlines,
    draw_dart,
    draw_footprint,
    footprint_of,
    is_seen,
    points_per_metre,
    scale_note,
)
from nhtrack.presentation.shown import CROWD
from nhtrack.recording import Recording

_DART = 8.0  # [pt] length of a robot that is too small to be drawn to scale
_GAP, _RIGHT = 0.08, 0.10  # [in] between panels, and right of them: half a number of their horizontal axes
_TOUCH: dict[str, Any] = {"marker": "X", "color": INK, "markeredgecolor": PAPER, "markersize": 5.0, "zorder": 5}
_TWIN: dict[str, Any] = {"color": INK, "linewidth": 0.5, "dashes": (4, 5), "zorder": 2.5}


@column_styled
def trajectories(
    recording: Recording,
    fractions: Sequence[float] = (0.15, 0.25, 0.5, 1.0),
    events: Sequence[Event] | None = None,
) -> Figure:
    """Returns the paths so far, with oriented robots, at fractions of the run.

    MuJoCo's path is solid; the ideal twin's is dashed over it. Hollow robots mark where each began, crosses where
    robots began to touch. Robots are drawn to scale in panels where they are large enough to be seen, and as darts of
    one size elsewhere; a virtual leader has no wheels.

    Args:
        recording: the run; an interrupted one is shown as far as it went.
        fractions: shares of the run's end time, one panel each, in reading order.
        events: of the run, if they are known; else they are looked for.
    """
    columns = 1 if len(fractions) == 1 else 2
    rows = -(-len(fractions) // columns)
    pose = recording["pose"].values
    lasts = [_rows(recording, fraction) for fraction in fractions]
    twin, shape, ground = _twin(recording), _shape([pose[:last] for last in lasts]), ground_of(recording)
    footprint = footprint_of(recording)
    margin = 0.0 if footprint is None else footprint.half_separation
    figure = Figure(figsize=(COLUMN, 1.0))
    panels = figure.subplots(rows, columns, squeeze=False)
    for k, (axes, fraction, last) in enumerate(zip(panels.flat, fractions, lasts, strict=False)):
        frame_panel(axes, pose[:last], shape, margin)
        panel_title(axes, "abcdefghijklmnop"[k % 16], f"t = {recording.time[last - 1]:.4g} s  ({fraction:.0%})")
    for axes in panels.flat[len(fractions) :]:
        axes.remove()
    _label_lengths(panels)
    found = find_events(recording) if events is None else events
    touches = [(event.start, touch_place(recording, event)) for event in found if event.touch is not None]
    said = [*slope_note(ground), *(["Cross: robots touched."] if touches else [])]
    _place(figure, panels, shape, run_title(figure, recording) or EDGE, _write_notes(figure, recording, twin, said))
    for axes, last in zip(panels.flat, lasts, strict=False):
        patches = draw_ground(axes, ground)
        _draw_paths(axes, pose[:last], None if twin is None else twin[:last])
        _draw_robots(axes, pose[:last], footprint, virtual_root=recording.scenario.leader.virtual)
        arrow = draw_uphill(axes, ground, pose[:last, :, :2])
        for time, place in touches:
            if time <= recording.time[last - 1]:
                axes.plot(*place, **_TOUCH)
    _write_names(panels.flat[len(fractions) - 1], recording, patches, arrow)
    return figure


def _place(figure: Figure, panels: np.ndarray, shape: float, above: float, below: float) -> None:
    """Puts panels of one shape where they belong; the figure becomes as high as they ask for.

    Args:
        figure: of the panels.
        panels: with limits and numbers as they stay, shape (rows, columns).
        shape: height of a panel over its width.
        above: height above the panels [in].
        below: height below the panels and their axes [in].
    """
    rows, columns = panels.shape
    numbers = [max(number_width(axes.yaxis) for axes in column) for column in panels.T]
    # Every panel of a column has room for the numbers of the others; only the first has a label.
    beside = [EDGE + label_room(numbers[0]), *(_GAP + number_room(width) for width in numbers[1:])]
    width = (COLUMN - sum(beside) - _RIGHT) / columns
    row_height = title_room() + width * shape + axis_room(labelled=False)
    label = axis_room() - axis_room(labelled=False)
    height = above + rows * row_height + (rows - 1) * _GAP + label + below
    figure.set_figheight(height)
    for (row, column), axes in np.ndenumerate(panels):
        left = sum(beside[: column + 1]) + column * width
        top = height - above - row * (row_height + _GAP) - title_room()
        box = Box(left, top - width * shape, width, width * shape)
        place_panel(axes, box)
        place_labels(axes, box, numbers[column])


def _rows(recording: Recording, fraction: float) -> int:
    """Returns how many rows of a run lie within a fraction of its duration, one at least."""
    last = np.searchsorted(recording.time, fraction * recording.time[-1] + 1e-9, side="right")
    return max(int(last), 1)


def _twin(recording: Recording) -> np.ndarray | None:
    """Returns the ideal twin's poses, or None where the run is its own twin or nobody could tell so many apart."""
    crowded = len(recording.robots) - 1 > CROWD
    if not recording.has_twin or crowded:
        return None
    return np.asarray(recording["ideal_pose"].values)


def _shape(frames: Sequence[np.ndarray]) -> float:
    """Returns the panels' height over width: the mean of what several paths would have, within what looks well."""
    sizes = [np.nanmax(pose[..., :2], axis=(0, 1)) - np.nanmin(pose[..., :2], axis=(0, 1)) for pose in frames]
    ratios = [np.log(max(height, 1e-9) / max(width, 1e-9)) for width, height in sizes]
    return float(np.clip(np.exp(np.mean(np.clip(ratios, -2, 2))), 0.55, 1.15))


def _label_lengths(panels: np.ndarray) -> None:
    for axes in panels.flat:
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
            axis.set_major_formatter(Numbers())
    for axes in panels[:, 0]:
        axes.set_ylabel("y [m]")
    for axes in panels[-1]:
        axes.set_xlabel("x [m]")


def _draw_paths(axes: Axes, pose: np.ndarray, twin: np.ndarray | None) -> None:
    crowded = pose.shape[1] - 1 > CROWD
    for place in reversed(range(pose.shape[1])):
        path: dict[str, Any] = {"linewidth": 1.8, "zorder": 1.8} if place == 0 else {"linewidth": 1.0, "zorder": 2.0}
        if crowded and place:
            path |= {"linewidth": 0.4, "alpha": 0.6}
        axes.plot(*pose[:, place, :2].T, color=robot_colour(place), **path)
        if twin is not None and place:
            axes.plot(*twin[:, place, :2].T, **_TWIN)


def _draw_robots(axes: Axes, pose: np.ndarray, footprint: Footprint | None, *, virtual_root: bool) -> None:
    """Draws the robots where they began and where they are, to scale if that can be seen."""
    if footprint is None or not is_seen(footprint, axes):
        draw_glyphs(axes, pose, _DART / points_per_metre(axes))
        return
    for index, hollow, zorder in ((0, True, 3.0), (-1, False, 4.0)):
        if virtual_root:
            look = {"edgecolor": robot_colour(0), "facecolor": PAPER if hollow else (robot_colour(0), 0.65)}
            draw_dart(axes, pose[index, 0], 2 * footprint.half_separation, linewidth=0.6, zorder=zorder, **look)
        for place in range(int(virtual_root), pose.shape[1]):
            draw_footprint(axes, pose[index, place], footprint, robot_colour(place), hollow=hollow, zorder=zorder)


def _write_names(axes: Axes, recording: Recording, patches: Mapping[str, Path], arrow: np.ndarray) -> None:
    """Writes the robots' names beside their paths, the root's alone in a crowd, and what patches are."""
    pose = recording["pose"].values
    shown, crowded = pose[..., :2], len(recording.robots) - 1 > CROWD
    named = recording.robots[:1] if crowded else recording.robots
    paths = {name: Path(shown[:, place : place + 1], robot_colour(place)) for place, name in enumerate(named)}
    outlines = dart_outlines(axes, np.concatenate([pose[0], pose[-1]]), _DART)
    nameless = [outlines, *([arrow] if arrow.size else []), *([shown[:, 1:]] if crowded else [])]
    name_paths(axes, paths | dict(patches), nameless)


def _write_notes(figure: Figure, recording: Recording, twin: np.ndarray | None, more: Sequence[str]) -> float:
    """Says what lines and robots mean, and more; returns the height that this takes up [in]."""
    notes = ["Hollow: start."] + (["Dashed: ideal twin."] if twin is not None else [])
    footprint = footprint_of(recording)
    if footprint is not None:
        notes.append(scale_note(footprint))
    return write_note(figure, recording, *notes, *more)
