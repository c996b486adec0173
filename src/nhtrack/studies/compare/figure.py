"""Several laws in one figure: their paths on the floor, and how far their followers were from their places."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator

from nhtrack.analysis.metrics import heading_error, position_error
from nhtrack.colours import ROOT, robot_colour
from nhtrack.plots.ground import draw_ground, ground_of
from nhtrack.plots.margins import (
    EDGE,
    Box,
    Decades,
    Numbers,
    axis_room,
    label_room,
    number_width,
    place_labels,
    place_panel,
    title_room,
)
from nhtrack.plots.names import Path, ends_room, name_ends, name_paths
from nhtrack.plots.paths import frame_panel
from nhtrack.plots.style import COLUMN, column_styled, line_style, panel_title, time_axes, write_note
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
from nhtrack.presentation.shown import CROWD, Room
from nhtrack.recording import Recording

__all__ = ["overlay"]

_DECADES = 6  # log axes show at most this many: below is rounding, not tracking
_LAST = 0.03  # share of a run at whose end its name stands
_NOTHING = 1e-300  # stands for an error of zero, which a logarithm has no place for
_DART = 8.0  # [pt] length of a robot that is too small to be drawn to scale
_PANEL, _GAP, _RIGHT = 0.94, 0.08, 0.10  # [in] a panel's height, between panels, and right of the floor


class _Shown(NamedTuple):
    """A law in the figure.

    Attributes:
        label: what it is called.
        colour: its colour.
        style: of its lines.
        run: its recording.
        path: where its followers were [m], NaN outside the room, shape (t, n - 1, 3).
    """

    label: str
    colour: str
    style: Any
    run: Recording
    path: np.ndarray


@column_styled
def overlay(runs: Mapping[str, Recording], room: Room) -> Figure:
    """Returns the paths of all laws on one floor, and below the worst position and heading error over time.

    Lengths are metres on the floor, as in the figures of a run. Each law has one colour, as
    in the film, and its name beside its curves; colours that come again have broken lines.

    Args:
        runs: by the laws' labels, of one scenario.
        room: part of the floor that is shown.
    """
    longest = max(runs.values(), key=lambda run: len(run.time))
    shown = [
        _Shown(label, robot_colour(place), line_style(place), run, _path(run, room)[:, 1:])
        for place, (label, run) in enumerate(runs.items(), start=1)
    ]
    root = _path(longest, room)[:, :1]
    everything = np.concatenate([root.reshape(-1, 3), *(each.path.reshape(-1, 3) for each in shown)])[:, None]
    shape = _shape(everything)
    figure = Figure(figsize=(COLUMN, 1.0))
    floor, *panels = figure.subplots(3, 1)
    frame_panel(floor, everything, shape)
    time_axes(np.array(panels)[:, None], longest)
    curves = _draw_errors(panels, shown, len(longest.robots) - 1)
    footprint = footprint_of(longest)
    below = write_note(figure, longest, "Hollow: start.", *([scale_note(footprint)] if footprint is not None else []))
    panels[0].tick_params(labelbottom=False)
    _label_floor(floor)
    _place(figure, shape, [each.label + _ending(each) for each in shown], below)
    patches = draw_ground(floor, ground_of(longest))
    _draw_lines(floor, shown, root)
    _draw_robots(floor, shown, root, footprint)
    _name_errors(panels, shown, curves)
    paths = {longest.robots[0]: Path(root[..., :2], ROOT)}
    paths |= {each.label: Path(each.path[..., :2], each.colour) for each in shown}
    robots = np.concatenate([root[0], shown[0].path[0], *(_last(each.path) for each in shown)])
    name_paths(floor, paths | patches, [dart_outlines(floor, robots, _DART)])
    return figure


def _place(figure: Figure, shape: float, names: list[str], below: float) -> None:
    """Puts floor and panels where they belong; the figure becomes as high as they ask for.

    Args:
        figure: of the floor and two panels, with limits and numbers as they stay.
        shape: height of the floor over its width.
        names: of the curves in the panels.
        below: height below the panels and their axis [in].
    """
    numbers = max(number_width(axes.yaxis) for axes in figure.axes)
    left = EDGE + label_room(numbers)
    widths = [COLUMN - left - right for right in (_RIGHT, *2 * [ends_room(names, COLUMN - left)])]
    heights = [widths[0] * shape, _PANEL, _PANEL]
    feet = [axis_room() + _GAP, _GAP, axis_room() + below]
    top = EDGE + sum(heights) + sum(feet) + 3 * title_room()
    figure.set_figheight(top)
    top -= EDGE
    for axes, width, height, foot in zip(figure.axes, widths, heights, feet, strict=True):
        top -= title_room() + height
        box = Box(left, top, width, height)
        place_panel(axes, box)
        place_labels(axes, box, numbers)
        top -= foot


def _path(run: Recording, room: Room) -> np.ndarray:
    """Returns poses, NaN outside the room, shape (t, n, 3)."""
    pose = run["pose"].values.copy()
    x_min, x_max, y_min, y_max = room
    x, y = pose[..., 0], pose[..., 1]
    pose[(x < x_min) | (x > x_max) | (y < y_min) | (y > y_max)] = np.nan
    return np.asarray(pose)


def _shape(pose: np.ndarray) -> float:
    """Returns the floor's height over width, within what looks well."""
    width, height = np.maximum(np.ptp(pose[np.isfinite(pose).all(axis=-1)][:, :2], axis=0), 1e-9)
    return float(np.clip(height / width, 0.35, 0.8))


# The floor ------------------------------------------------------------------------------------------------------------


def _label_floor(axes: Axes) -> None:
    panel_title(axes, "a", "paths")
    axes.set(xlabel="x [m]", ylabel="y [m]")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
        axis.set_major_formatter(Numbers())


def _draw_lines(axes: Axes, shown: list[_Shown], root: np.ndarray) -> None:
    """Draws paths, those of laws in turn thinner, so that none hides another."""
    axes.plot(*root[:, 0, :2].T, color=ROOT, linewidth=1.8, zorder=1.8)
    for width, each in zip(np.linspace(1.4, 0.8, len(shown)), shown, strict=True):
        line: dict[str, Any] = {"linewidth": 0.4, "alpha": 0.7} if _is_crowded(each) else {"linewidth": width}
        axes.plot(*np.moveaxis(each.path[..., :2], -1, 0), color=each.colour, linestyle=each.style, zorder=2.0, **line)


def _draw_robots(axes: Axes, shown: list[_Shown], root: np.ndarray, footprint: Footprint | None) -> None:
    """Draws robots where they began and where they are: to scale where that can be seen, as darts elsewhere."""
    starts, ends = [*root[0], *shown[0].path[0]], [(root[-1, 0], ROOT)]
    ends += [(pose, each.colour) for each in shown for pose in _last(each.path)]
    if footprint is not None and is_seen(footprint, axes):
        for pose in starts:
            draw_footprint(axes, pose, footprint, "#666666", hollow=True, zorder=3)
        for pose, colour in ends:
            draw_footprint(axes, pose, footprint, colour, hollow=False, zorder=4)
        return
    size = _DART / points_per_metre(axes)
    lengths = [1.5, *np.repeat(np.linspace(1.15, 0.45, len(shown)), shown[0].path.shape[1])]
    small = 0.75 if _is_crowded(shown[0]) else 1.0
    for pose in starts:
        draw_dart(axes, pose, size, facecolor="white", edgecolor="#666666", linewidth=0.5, zorder=3)
    for place, ((pose, colour), length) in enumerate(zip(ends, lengths, strict=True)):
        edge: dict[str, Any] = {"edgecolor": "none" if place else "white", "linewidth": 0.5, "zorder": 4 + 1e-3 * place}
        draw_dart(axes, pose, size * length * (small if place else 1.0), facecolor=colour, **edge)


def _is_crowded(each: _Shown) -> bool:
    return bool(each.path.shape[1] > CROWD)


def _last(path: np.ndarray) -> np.ndarray:
    """Returns the last pose that each robot of a path (t, k, 3) has in the room, shape (k, 3)."""
    rows = len(path) - 1 - np.isfinite(path[::-1, :, 0]).argmax(axis=0)
    return np.asarray(path[rows, np.arange(path.shape[1])])


# Errors over time -----------------------------------------------------------------------------------------------------


def _draw_errors(panels: list[Axes], shown: list[_Shown], count: int) -> list[list[np.ndarray]]:
    """Draws the worst position and heading error of each law's followers over time; returns them, by panels."""
    whose = "" if count == 1 else f", worst of {count} followers"
    rows = (("b", "position error", "m", position_error), ("c", "heading error", "rad", heading_error))
    drawn = []
    for axes, (letter, name, unit, error) in zip(panels, rows, strict=True):
        curves = [np.abs(error(each.run)[:, 1:]).max(axis=1) for each in shown]
        low, high = _limits([curve for each, curve in zip(shown, curves, strict=True) if _whole(each)] or curves)
        for each, curve in zip(shown, curves, strict=True):  # no axis can bear what a run that diverges leaves
            shown_part = np.where(curve > 0, np.minimum(curve, 10 * high), np.nan)
            axes.plot(each.run.time, shown_part, color=each.colour, linestyle=each.style)
        axes.set_ylim(low, high)  # first: margins of their own would be beyond what numbers reach
        axes.set_yscale("log")
        axes.yaxis.set_major_locator(LogLocator(numticks=5))
        axes.yaxis.set_major_formatter(Decades())
        axes.yaxis.set_minor_locator(NullLocator())
        axes.set_ylabel(f"{name.split()[0]} [{unit}]")
        panel_title(axes, letter, f"{name}{whose}")
        drawn.append(curves)
    return drawn


def _name_errors(panels: list[Axes], shown: list[_Shown], drawn: list[list[np.ndarray]]) -> None:
    for axes, curves in zip(panels, drawn, strict=True):
        ends = np.array([_end(each, curve) for each, curve in zip(shown, curves, strict=True)])
        name_ends(axes, [each.label + _ending(each) for each in shown], [each.colour for each in shown], ends)


def _whole(each: _Shown) -> bool:
    return each.run.outcome == "completed"


def _limits(curves: list[np.ndarray]) -> tuple[float, float]:
    """Returns whole decades that hold curves, without what is next to nothing."""
    values = np.concatenate(curves)
    values = values[np.isfinite(values) & (values > 0)]
    if not values.size:
        return 1e-6, 1.0
    top = float(values.max())
    bottom = np.clip(float(np.quantile(values, 0.005)), top / 10**_DECADES, top / 10)
    return float(10 ** np.floor(np.log10(bottom))), float(10 ** np.ceil(np.log10(1.05 * top)))


def _ending(each: _Shown) -> str:
    """Returns what to say of a run that did not complete."""
    return "" if _whole(each) else f", {each.run.outcome.split(':')[0]}"


def _end(each: _Shown, curve: np.ndarray) -> float:
    """Returns where a curve is as its run ends: the median of the last rows, since errors swing."""
    known = curve[np.isfinite(curve) & (curve > 0)]
    return float(np.median(known[-max(1, round(_LAST * len(curve))) :])) if known.size else _NOTHING
