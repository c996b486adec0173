"""The figures of the paper, drawn from recordings: its panels, its instants, its units.

The ideal twin lies under MuJoCo's path as a broad pale line; where the two part, it shows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon
from matplotlib.ticker import MaxNLocator

from nhtrack import se2
from nhtrack.arrays import Array
from nhtrack.colours import INK, robot_colour
from nhtrack.plots.graph import draw_graph
from nhtrack.plots.paths import DART, draw_glyphs, frame_panel
from nhtrack.plots.style import column_styled, panel_title, styled
from nhtrack.recording import Recording

__all__ = [
    "Tracks",
    "leader_motion",
    "panels",
    "reference_path",
    "side_by_side",
    "tracks",
]

START = "#F0E442"  # the paper marks the start that two runs share in yellow

_IDEAL: dict[str, Any] = {"linewidth": 5.0, "alpha": 0.28, "solid_capstyle": "butt", "zorder": 1.6}
_DRIVEN: dict[str, Any] = {"linewidth": 1.2, "zorder": 2.2}

_RING: dict[str, Any] = {"marker": "o", "markersize": 9, "markerfacecolor": "none", "markeredgecolor": INK}
_START: dict[str, Any] = {"marker": ">", "markersize": 9, "markerfacecolor": START, "markeredgecolor": INK}
_STILL = 1e-3  # a leader that drives and turns slower than this share of its fastest stands


class Tracks(NamedTuple):
    """Where robots went, in scenario units.

    Attributes:
        names: the robots, the leader first, shape n.
        time: [scenario time], shape (t,).
        pose: x, y [scenario length], theta [rad], shape (t, n, 3).
        ideal: the same of the ideal twin, or None where the run is its own.
        length_scale: robot metres per scenario length unit.
        edges: places in `names` of a parent and of the robot that tracks it, for every pair to be joined by a line.
    """

    names: tuple[str, ...]
    time: Array
    pose: Array
    ideal: Array | None
    length_scale: float
    edges: tuple[tuple[int, int], ...] = ()


def tracks(recording: Recording, *, joined: bool = False) -> Tracks:
    """Returns where the robots of a run went; `joined` shows its graph too, as a formation's shape."""
    scale = np.array([recording.length_scale, recording.length_scale, 1.0])
    time = recording.time / recording.time_scale
    pose = recording["pose"].values / scale
    ideal = recording["ideal_pose"].values / scale if recording.backend != "ideal" else None
    places = {name: place for place, name in enumerate(recording.robots)}
    pairs = [
        (places[parent], places[name]) for name, others in recording.parents.items() for parent in others
    ]
    return Tracks(recording.robots, time, pose, ideal, recording.length_scale, tuple(pairs) if joined else ())


def side_by_side(runs: Mapping[str, Recording]) -> Tracks:
    """Returns the followers of several runs of one leader as if they were robots of one run.

    Args:
        runs: what to call the followers of each run; all runs have the same times.
    """
    parts = {name: tracks(recording) for name, recording in runs.items()}
    first = next(iter(parts.values()))
    names = (first.names[0], *(name for name, part in parts.items() for _ in part.names[1:]))
    pose = np.concatenate([first.pose[:, :1], *(part.pose[:, 1:] for part in parts.values())], axis=1)
    twins = [part.ideal for part in parts.values() if part.ideal is not None]
    ideal = np.concatenate([twins[0][:, :1], *(twin[:, 1:] for twin in twins)], axis=1) if twins else None
    return Tracks(names, first.time, pose, ideal, first.length_scale)


@styled
def panels(shown: Tracks, fractions: Sequence[float], title: str, shared_start: int | None = None) -> Figure:
    """Returns the paths so far, with oriented robots, at fractions of the run's duration T.

    Args:
        shown: what to draw.
        fractions: shares of T, one panel each, in reading order.
        title: of the figure.
        shared_start: a robot whose start is marked in yellow, as one that several runs share.
    """
    columns = min(2, len(fractions))
    rows = -(-len(fractions) // columns)
    frames = [shown.pose[: _rows(shown.time, fraction)] for fraction in fractions]
    shape = _shape(frames)
    width = 4.1 if columns > 1 else 5.6
    figure = Figure(figsize=(width * columns, (0.88 * width * shape + 0.6) * rows + 1.0))
    grid = figure.subplots(rows, columns, squeeze=False)
    for k, (axes, fraction, pose) in enumerate(zip(grid.flat, fractions, frames, strict=True)):
        frame_panel(axes, pose, shape)
        ideal = None if shown.ideal is None else shown.ideal[: len(pose)]
        _draw_paths(axes, pose, ideal)
        if shared_start is not None:
            _mark_start(axes, pose[0, shared_start])
        for ends in shown.edges:
            axes.plot(
                *pose[-1, ends, :2].T, color="#888888", linewidth=0.9, linestyle=(0, (2, 2)), zorder=2.6
            )
        draw_glyphs(axes, pose)
        if len(fractions) > 1:
            panel_title(axes, "abcdefgh"[k], f"$t$ = {fraction:.0%} $T$ = {shown.time[len(pose) - 1]:.4g} s")
    for axes in grid.flat[len(fractions) :]:
        axes.remove()
    _label_lengths(grid)
    start = Line2D([], [], linestyle="none", label="the start they share", **_START)
    _finish(figure, shown, title, [] if shared_start is None else [start])
    return figure


@styled
def reference_path(recording: Recording, title: str) -> Figure:
    """Returns the leader's path, with the leader drawn at the start, at every halt, and at the end."""
    shown = tracks(recording)
    pose = shown.pose[:, :1]
    figure = Figure(figsize=(5.0, 3.9 * _shape([pose]) + 1.0))
    axes = figure.subplots()
    frame_panel(axes, pose, _shape([pose]))
    _draw_paths(axes, pose, None if shown.ideal is None else shown.ideal[:, :1])
    halts = _halts(recording["twist"].values[:, 0])
    axes.plot(*pose[halts, 0, :2].T, linestyle="none", zorder=5, **_RING)
    draw_glyphs(axes, pose)
    _label_lengths(np.array([[axes]]))
    halt = Line2D([], [], linestyle="none", label="halt", **_RING)
    _finish(figure, shown._replace(names=shown.names[:1]), title, [halt] if halts else [])
    return figure


@styled
def leader_motion(recording: Recording, title: str) -> Figure:
    """Returns the leader's input and the velocity it drives with, over scenario time, in scenario units."""
    length, time = recording.length_scale, recording.time_scale
    clock = recording.time / time
    u = recording["input"].values[:, 0] * np.array([time**2 / length, time**2])
    twist = recording["twist"].values[:, 0, [0, 2]] * np.array([time / length, time])
    figure = Figure(figsize=(8.2, 3.3))
    left, right = figure.subplots(1, 2)
    colours = (robot_colour(0), robot_colour(1))
    for column, label in enumerate((r"$u_{x0}$ [m/s²]", r"$u_{\theta 0}$ [rad/s²]")):
        left.plot(clock, u[:, column], color=colours[column], drawstyle="steps-post", label=label)
    for column, label in enumerate((r"$v_{x0}$ [m/s]", r"$\omega_0$ [rad/s]")):
        right.plot(clock, twist[:, column], color=colours[column], label=label)
    for letter, axes, text in (("a", left, "reference input"), ("b", right, "velocity under that input")):
        panel_title(axes, letter, text)
        axes.set_xlim(0, clock[-1])
        axes.xaxis.set_major_locator(MaxNLocator(5))
        axes.set_xlabel("$t$ [s]")
        axes.axhline(0.0, color="#999999", linewidth=0.6, zorder=1)
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)
    left_title(figure, title)
    return figure


@styled
def _rows(time: Array, fraction: float) -> int:
    """Returns how many rows of a run lie within a fraction of its duration."""
    return max(1, int(np.searchsorted(time, fraction * time[-1] * (1 + 1e-12), side="right")))


def _shape(frames: Sequence[Array]) -> float:
    """Returns a height over width in which every one of some paths can be seen well."""
    sizes = np.array([np.ptp(pose[..., :2].reshape(-1, 2), axis=0) for pose in frames])
    ratio = np.maximum(sizes[:, 1], 1e-9) / np.maximum(sizes[:, 0], 1e-9)
    return float(np.clip(np.exp(np.log(ratio).mean()), 0.5, 1.1))


def _halts(twist: Array) -> list[int]:
    """Returns the middle row of every time a robot of twist (t, 3) stands, the start and the end left out."""
    moves = np.abs(twist[:, [0, 2]])
    still = (moves <= _STILL * moves.max(axis=0)).all(axis=1)
    edges = np.flatnonzero(np.diff(still.astype(int), prepend=0, append=0))
    return [(begin + end - 1) // 2 for begin, end in edges.reshape(-1, 2) if begin > 0 and end < len(still)]


def _draw_paths(axes: Axes, pose: Array, ideal: Array | None) -> None:
    for place in reversed(range(pose.shape[1])):
        if ideal is not None:
            axes.plot(*ideal[:, place, :2].T, color=robot_colour(place), **_IDEAL)
        axes.plot(*pose[:, place, :2].T, color=robot_colour(place), **_DRIVEN)


def _mark_start(axes: Axes, pose: Array) -> None:
    size = 0.1 * float(np.ptp(axes.get_xlim()))
    corners = se2.act(pose[None, :], size * DART)
    axes.add_patch(Polygon(corners, closed=True, facecolor=START, edgecolor=INK, zorder=2.8))


def _label_lengths(grid: np.ndarray) -> None:
    for axes in grid[:, 0]:
        axes.set_ylabel("$y$ [m]")
    for axes in grid[-1]:
        axes.set_xlabel("$x$ [m]")


def _finish(figure: Figure, shown: Tracks, title: str, extra: Sequence[Line2D] = ()) -> None:
    """Writes the title, and below the figure whose paths these are."""
    dart: dict[str, Any] = {
        "marker": ">",
        "markersize": 6,
        "markeredgecolor": "white",
        "markeredgewidth": 0.4,
    }
    entries = [
        Line2D([], [], color=robot_colour(i), label=name, **dart) for i, name in enumerate(shown.names)
    ]
    if shown.ideal is not None:
        entries.append(Line2D([], [], color="#666666", linewidth=1.2, label="MuJoCo"))
        entries.append(Line2D([], [], color="#666666", linewidth=5.0, alpha=0.28, label="ideal twin"))
    entries += extra
    scale = f"1 m of the paper is {1000 * shown.length_scale:.4g} mm on the floor"
    if shown.edges:
        entries.append(Line2D([], [], color="#888888", linewidth=0.9, linestyle=(0, (2, 2)), label="tracks"))
    columns = len(entries) if len(entries) <= 4 else -(-len(entries) // 2)
    legend: dict[str, Any] = {"ncols": columns, "title": scale, "title_fontsize": 8}
    figure.legend(handles=entries, loc="outside lower center", **legend)
    left_title(figure, title)


@column_styled
def topology(parents: Mapping[str, Sequence[str]]) -> Figure:
    """Returns who tracks whom."""
    return draw_graph(parents, _graph_title)


def _graph_title(figure: Figure) -> float:
    left_title(figure, "Topology")
    return 0.35


def left_title(figure: Figure, title: str) -> None:
    """Writes a title at the left of a figure, with air below it."""
    figure.suptitle(title, x=0.01, ha="left", fontsize=11.0, fontweight="bold", color=INK)
    engine = figure.get_layout_engine()
    if isinstance(engine, ConstrainedLayoutEngine):
        engine.set(h_pad=0.09)
