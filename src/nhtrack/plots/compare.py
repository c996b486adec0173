"""Several laws in one figure: their paths on the floor, and how far their followers were from their places."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.ticker import NullFormatter

from nhtrack import se2
from nhtrack.metrics import heading_error, position_error
from nhtrack.plots.ground import draw_ground, ground_of
from nhtrack.plots.names import Path, name_ends, name_paths
from nhtrack.plots.paths import DART, frame_panel
from nhtrack.plots.style import CROWD, INK, panel_title, styled, time_axes
from nhtrack.recording import Recording
from nhtrack.simulation.palette import ROOT, robot_colour

__all__ = ["overlay"]

Room = tuple[float, float, float, float]  # x_min, x_max, y_min, y_max [m]

_DECADES = 6  # log axes show at most this many: below is rounding, not tracking
_LAST = 0.03  # share of a run at whose end its name stands
_NOTHING = 1e-300  # stands for an error of zero, which a logarithm has no place for
_DART = 0.045  # length of a robot as a share of the panel's larger side


class _Shown(NamedTuple):
    """A law in the figure.

    Attributes:
        label: what it is called.
        colour: its colour.
        run: its recording.
        path: where its followers were, in scenario units, NaN outside the room, shape (t, n - 1, 3).
    """

    label: str
    colour: str
    run: Recording
    path: np.ndarray


@styled
def overlay(runs: Mapping[str, Recording], room: Room) -> Figure:
    """Returns the paths of all laws on one floor, and below the worst position and heading error over time.

    Lengths on the floor are in the scenario's own units, errors in metres and radians. Each law has one colour, as
    in the film, and its name beside its curves.

    Args:
        runs: by the laws' labels, of one scenario.
        room: part of the floor that is shown.
    """
    longest = max(runs.values(), key=lambda run: len(run.time))
    shown = [
        _Shown(label, robot_colour(place), run, _path(run, room)[:, 1:])
        for place, (label, run) in enumerate(runs.items(), start=1)
    ]
    root = _path(longest, room)[:, :1]
    everything = np.concatenate([root.reshape(-1, 3), *(each.path.reshape(-1, 3) for each in shown)])[:, None]
    shape = _shape(everything)
    figure = Figure(figsize=(8.4, 7.0 * shape + 4.9))
    floor, *panels = figure.subplots(3, 1, height_ratios=(7.0 * shape, 2.1, 2.1))
    frame_panel(floor, everything, shape)
    draw_ground(floor, ground_of(longest), longest.length_scale)
    _draw_floor(floor, shown, root, longest)
    time_axes(figure, np.array(panels)[:, None], longest)
    _draw_errors(panels, shown, len(longest.robots) - 1)
    figure.suptitle(f"{longest.name}: {len(runs)} laws", x=0.01, ha="left", fontsize=11.0, fontweight="bold", color=INK)
    figure.align_ylabels(panels)
    figure.draw_without_rendering()  # the names of the paths need to know where these are
    paths = {longest.robots[0]: Path(root[..., :2], ROOT)}
    name_paths(floor, paths | {each.label: Path(each.path[..., :2], each.colour) for each in shown})
    return figure


def _path(run: Recording, room: Room) -> np.ndarray:
    """Returns poses in scenario units, NaN outside the room, shape (t, n, 3)."""
    pose = run["pose"].values.copy()
    x_min, x_max, y_min, y_max = room
    x, y = pose[..., 0], pose[..., 1]
    pose[(x < x_min) | (x > x_max) | (y < y_min) | (y > y_max)] = np.nan
    return np.asarray(pose / [run.length_scale, run.length_scale, 1.0])


def _shape(pose: np.ndarray) -> float:
    """Returns the floor's height over width, within what looks well."""
    width, height = np.maximum(np.ptp(pose[np.isfinite(pose).all(axis=-1)][:, :2], axis=0), 1e-9)
    return float(np.clip(height / width, 0.35, 0.8))


# The floor ------------------------------------------------------------------------------------------------------------


def _draw_floor(axes: Axes, shown: list[_Shown], root: np.ndarray, longest: Recording) -> None:
    """Draws paths and robots where they began and where they are; laws in turn thinner, so that none hides another."""
    axes.plot(*root[:, 0, :2].T, color=ROOT, linewidth=2.6, zorder=1.8)
    size = _DART * float(np.ptp(axes.get_xlim()))
    _draw_dart(axes, root[-1, 0], 1.5 * size, facecolor=ROOT, edgecolor="white", zorder=4)
    for start in (*root[0], *shown[0].path[0]):
        _draw_dart(axes, start, size, facecolor="white", edgecolor="#666666", zorder=3)
    widths, lengths = np.linspace(2.0, 1.0, len(shown)), np.linspace(1.15, 0.45, len(shown))
    for place, each in enumerate(shown):
        crowded = each.path.shape[1] > CROWD
        line: dict[str, Any] = {"linewidth": 0.7, "alpha": 0.7} if crowded else {"linewidth": widths[place]}
        axes.plot(*np.moveaxis(each.path[..., :2], -1, 0), color=each.colour, zorder=2.0, **line)
        length = size * lengths[place] * (0.75 if crowded else 1.0)
        for pose in _last(each.path):
            _draw_dart(axes, pose, length, facecolor=each.colour, edgecolor="none", zorder=4.1 + 0.1 * place)
    scale = longest.length_scale
    unit = "" if scale == 1.0 else f" in the scenario's units; 1 m is {1000 * scale:.4g} mm on the floor"
    panel_title(axes, "a", f"paths{unit}")
    axes.set_xlabel("$x$ [m]")
    axes.set_ylabel("$y$ [m]")


def _last(path: np.ndarray) -> np.ndarray:
    """Returns the last pose that each robot of a path (t, k, 3) has in the room, shape (k, 3)."""
    rows = len(path) - 1 - np.isfinite(path[::-1, :, 0]).argmax(axis=0)
    return np.asarray(path[rows, np.arange(path.shape[1])])


def _draw_dart(axes: Axes, pose: np.ndarray, length: float, **look: Any) -> None:
    corners = se2.act(pose[None, :], length * DART)
    if np.isfinite(corners).all():
        axes.add_patch(Polygon(corners, closed=True, linewidth=0.7, **look))


# Errors over time -----------------------------------------------------------------------------------------------------


def _draw_errors(panels: list[Axes], shown: list[_Shown], count: int) -> None:
    """Draws the worst position and heading error of each law's followers over time."""
    whose = "" if count == 1 else f", worst of {count} followers"
    rows = (("b", "position error", "m", position_error), ("c", "heading error", "rad", heading_error))
    for axes, (letter, name, unit, error) in zip(panels, rows, strict=True):
        curves = [np.abs(error(each.run)[:, 1:]).max(axis=1) for each in shown]
        low, high = _limits([curve for each, curve in zip(shown, curves, strict=True) if _whole(each)] or curves)
        for each, curve in zip(shown, curves, strict=True):  # no axis can bear what a run that diverges leaves
            axes.plot(each.run.time, np.where(curve > 0, np.minimum(curve, 10 * high), np.nan), color=each.colour)
        axes.set_yscale("log")
        axes.yaxis.set_minor_formatter(NullFormatter())
        axes.set_ylim(low, high)
        axes.set_ylabel(f"{name} [{unit}]")
        panel_title(axes, letter, f"{name}{whose}")
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
