"""The house style of the figures, and the pieces every figure is drawn with.

Figures are made without pyplot: nothing registers a window, and the style holds only while a figure is being
drawn.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import Any, ParamSpec, TypeVar

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from nhtrack.recording import Recording
from nhtrack.simulation.palette import ROOT, robot_colour

__all__ = [
    "CROWD",
    "INK",
    "draw_robots",
    "panel_title",
    "robot_legend",
    "run_title",
    "styled",
    "time_axes",
]

CROWD = 7  # more followers than this are drawn as a band: single curves could no longer be told apart
BAND_COLOUR = "#0072B2"
INK = "#1A1A1A"

STYLE: Any = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.labelsize": 9.0,
    "axes.edgecolor": "#666666",
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.use_mathtext": True,
    "axes.formatter.limits": (-4, 4),
    "grid.color": "#E4E4E4",
    "grid.linewidth": 0.6,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "xtick.color": "#444444",
    "ytick.color": "#444444",
    "lines.linewidth": 1.2,
    "lines.solid_capstyle": "round",
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "mathtext.fontset": "dejavusans",
    "figure.constrained_layout.use": True,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "savefig.dpi": 200,
    "pdf.fonttype": 42,  # letters stay letters: searchable, and accepted by journals
    "path.simplify_threshold": 0.5,
}

P = ParamSpec("P")
R = TypeVar("R")


def styled(function: Callable[P, R]) -> Callable[P, R]:
    """Returns `function` run in the house style, which ends with the call."""

    @functools.wraps(function)
    def inside(*args: P.args, **kwargs: P.kwargs) -> R:
        with mpl.rc_context(STYLE):
            return function(*args, **kwargs)

    return inside


def draw_robots(
    axes: Axes, time: np.ndarray, values: np.ndarray, places: Sequence[int], *, crowd: int, **line: Any
) -> None:
    """Draws one curve a robot in its colour; a crowd of followers as its range and its median.

    Args:
        axes: where to draw.
        time: times [s], shape (t,).
        values: shape (t, k), one column a robot; NaN leaves a gap.
        places: the k robots' places in the recording, 0 the root.
        crowd: how many followers the recording has.
        **line: properties of the curves.
    """
    alone = [column for column, place in enumerate(places) if crowd <= CROWD or place == 0]
    together = [column for column, place in enumerate(places) if crowd > CROWD and place != 0]
    if together:
        band = values[:, together]
        axes.fill_between(time, band.min(axis=1), band.max(axis=1), color=BAND_COLOUR, alpha=0.22, linewidth=0)
        axes.plot(time, np.median(band, axis=1), color=BAND_COLOUR, zorder=3, **line)
    for column in alone:
        place = places[column]
        axes.plot(time, values[:, column], color=robot_colour(place), zorder=3.5 if place == 0 else 3, **line)


def robot_legend(figure: Figure, recording: Recording, extra: Sequence[Line2D] = (), *, root: bool = True) -> None:
    """Writes the robots' names in their colours, and `extra` handles, in one row below the figure."""
    entries: list[Any] = []
    if root:
        entries.append(Line2D([], [], color=ROOT, label=recording.robots[0]))
    followers = list(enumerate(recording.robots))[1:]
    if len(followers) <= CROWD:
        entries += [Line2D([], [], color=robot_colour(place), label=name) for place, name in followers]
    else:
        entries.append(Line2D([], [], color=BAND_COLOUR, label=f"median of {len(followers)} followers"))
        entries.append(Patch(color=BAND_COLOUR, alpha=0.22, linewidth=0, label="their range"))
    entries += list(extra)
    figure.legend(handles=entries, loc="outside lower center", ncols=min(len(entries), 6), handlelength=1.8)


def panel_title(axes: Axes, letter: str, text: str) -> None:
    """Writes `(letter) text` above a panel."""
    axes.set_title(f"({letter}) {text}", color=INK)


def time_axes(figure: Figure, panels: np.ndarray, recording: Recording) -> None:
    """Labels a grid's time axes: robot seconds below, the scenario's above where they differ."""
    scale = recording.time_scale
    last = float(recording.time[-1]) if recording.time.size else 1.0
    for axes in panels[-1]:
        axes.set_xlabel("time [s]" if scale == 1.0 else "robot time [s]")
    for axes in panels.ravel():
        axes.set_xlim(0.0, max(last, 1e-9))
        axes.margins(x=0)
    if scale != 1.0:
        for axes in panels[0]:
            top = axes.secondary_xaxis("top", functions=(lambda t: t / scale, lambda t: t * scale))
            top.xaxis.set_major_locator(MaxNLocator(5))
            top.set_xlabel("scenario time [s]", color="#777777", fontsize=8.0)
            top.tick_params(colors="#777777", labelsize=7.5)
            top.spines["top"].set_visible(True)
            top.spines["top"].set_color("#BBBBBB")


def run_title(figure: Figure, recording: Recording) -> None:
    """Says in the figure's title which run this is, and why it ended if it did not complete."""
    ended = "" if recording.outcome == "completed" else f"  ({recording.outcome})"
    figure.suptitle(f"{recording.name}{ended}", x=0.01, ha="left", fontsize=11.0, fontweight="bold", color=INK)
