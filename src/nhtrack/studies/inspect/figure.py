"""A robot from above and from the side, to scale, with what was read from its file drawn in."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D
from matplotlib.path import Path
from matplotlib.ticker import MaxNLocator, MultipleLocator

from nhtrack.arrays import Array
from nhtrack.colours import FOLLOWERS, INK, PAPER, ROOT
from nhtrack.plots.margins import Box, Numbers, axis_room, place_labels, place_panel, title_room
from nhtrack.plots.style import column_styled, panel_title
from nhtrack.presentation.numbers import quantity
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.robots.kind import Reading
from nhtrack.studies.inspect.silhouette import ABOVE, SIDE, Piece, silhouettes

__all__ = ["robot_figure"]

_WIDEST, _TALLEST, _NARROWEST = 2.95, 5.2, 2.45  # [in] of panels
_LEFT, _BETWEEN, _RIGHT, _LEGEND = 0.50, 0.62, 0.12, 0.30  # [in] beside panels; below them
_BESIDE, _ABOVE, _BELOW = 0.74, 0.26, 0.52  # [in] around a robot, for dimensions
_NUMBERS = 0.24  # [in] for the numbers of a vertical axis
_AWAY, _BEYOND = 0.20, 0.05  # [in] from the robot to a dimension line; from there to the end of its extension lines
_SHORT = 0.45  # [in] a dimension in which no words go beside the line
_BODY, _EDGE, _WHEEL = "#EFEFEF", "#A6A6A6", "#5B6066"
_TYRE, _CASTER = FOLLOWERS[0], FOLLOWERS[1]
_QUARTERS = Path.make_compound_path(Path.wedge(0, 90), Path.wedge(180, 270))


class _Scale(NamedTuple):
    """How robot and paper belong together: inches of a metre, and the corners of the robot in a panel [m]."""

    inches: float
    low: Array
    high: Array

    def metres(self, inches: float) -> float:
        """Returns what a length on paper is beside the robot."""
        return inches / self.inches

    def frame(self, axes: Axes, left: float, bottom: float, width: float) -> None:
        """Gives a panel its place [in] and its limits, both axes with the same steps."""
        height = float(self.high[1] - self.low[1]) * self.inches + _ABOVE + _BELOW
        box, middle = Box(left, bottom, width, height), float(self.low[0] + self.high[0]) / 2
        place_panel(axes, box)
        axes.set_xlim(middle - self.metres(width / 2), middle + self.metres(width / 2))
        axes.set_ylim(self.low[1] - self.metres(_BELOW), self.high[1] + self.metres(_ABOVE))
        step = float(np.diff(MaxNLocator(5).tick_values(0.0, self.metres(width)))[0])
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(MultipleLocator(step))
            axis.set_major_formatter(Numbers())
        axes.set_xlabel("ahead of the axle [m]")
        place_labels(axes, box, _NUMBERS)


@column_styled
def robot_figure(reading: Reading) -> Figure:
    """Returns the picture of a robot from above and from the side.

    Both are to one scale, in metres from the floor below the axle's middle: axle, forward, where tyres and casters
    touch the floor, centre of mass, wheel separation and radius.
    """
    drive, views = reading.model, silhouettes(reading, ABOVE, SIDE)
    corners = [_extent(pieces, drive) for pieces in views]
    wide, tall = (max(float(high[k] - low[k]) for low, high in corners) for k in (0, 1))
    inches = min((_WIDEST - 2 * _BESIDE) / wide, (_TALLEST - _ABOVE - _BELOW) / tall)
    panel, below = max(wide * inches + 2 * _BESIDE, _NARROWEST), _LEGEND + axis_room()
    height = below + tall * inches + _ABOVE + _BELOW + title_room()
    figure = Figure(figsize=(_LEFT + _BETWEEN + _RIGHT + 2 * panel, height))
    for place, (pieces, (low, high)) in enumerate(zip(views, corners, strict=True)):
        axes, scale = figure.add_subplot(1, 2, place + 1), _Scale(inches, low, high)
        scale.frame(axes, _LEFT + place * (panel + _BETWEEN), below, panel)
        panel_title(axes, "ab"[place], ("from above", "from the side")[place])
        _draw_body(axes, pieces)
        (_mark_above, _mark_side)[place](axes, drive, scale)
    _write_legend(figure)
    return figure


def _extent(pieces: list[Piece], drive: DiffDrive) -> tuple[Array, Array]:
    """Returns the lower and the upper corner of what is drawn [m]."""
    points = np.vstack([piece.corners for piece in pieces] + [np.zeros((1, 2)), [[drive.com[0], 0.0]]])
    return points.min(axis=0), points.max(axis=0)


def _draw_body(axes: Axes, pieces: list[Piece]) -> None:
    """Draws the outlines, with a darker line around all of them."""
    corners = [piece.corners for piece in pieces]
    faces = [_WHEEL if piece.moves else _BODY for piece in pieces]
    axes.add_collection(PolyCollection(corners, facecolors="none", edgecolors="#6E6E6E", linewidths=1.4, zorder=2))
    axes.add_collection(PolyCollection(corners, facecolors=faces, edgecolors=_EDGE, linewidths=0.35, zorder=2.1))
    below = [piece.corners for piece in pieces if piece.moves]
    hidden: Any = {"facecolors": (_WHEEL, 0.25), "edgecolors": (_WHEEL, 0.9), "linewidths": 0.4}
    axes.add_collection(PolyCollection(below, zorder=2.2, **hidden))


def _mark_above(axes: Axes, drive: DiffDrive, scale: _Scale) -> None:
    """Draws axle, forward, contacts, centre of mass and wheel separation as seen from above."""
    b, out = drive.half_separation, scale.metres(0.14)
    axes.set_ylabel("to the left [m]")
    axes.plot([0, 0], [-b - out, b + out], **_AXLE)
    _draw_forward(axes, 0.0, scale)
    axes.plot([0, 0], [b, -b], **_CONTACT, color=_TYRE)
    axes.plot(*np.reshape(drive.casters, (-1, 2)).T, **_CONTACT, color=_CASTER)
    _draw_com(axes, drive.com[0], drive.com[1])
    _dimension(axes, scale, "left", (-b, b), 0.0, quantity(2 * b, "m"))
    if drive.casters:
        x, y = max(drive.casters, key=lambda place: abs(place[0]))
        _dimension(axes, scale, "below", (min(x, 0.0), max(x, 0.0)), (y, -b), quantity(abs(x), "m"))


def _mark_side(axes: Axes, drive: DiffDrive, scale: _Scale) -> None:
    """Draws floor, axle, forward, contacts, centre of mass and radius as seen from the right."""
    r, height = drive.wheel_radius, drive.com[2]
    axes.set_ylabel("above the floor [m]")
    axes.axhline(0.0, color="#666666", linewidth=0.9, zorder=1.9)
    _draw_forward(axes, r, scale)
    axes.plot([0], [r], "+", color=INK, markersize=8, markeredgewidth=0.8, zorder=5)
    axes.plot([0], [0], **_CONTACT, color=_TYRE)
    axes.plot([x for x, _ in drive.casters], [0.0] * len(drive.casters), **_CONTACT, color=_CASTER)
    _draw_com(axes, drive.com[0], height)
    _dimension(axes, scale, "left", (0.0, r), 0.0, quantity(r, "m"))
    _dimension(axes, scale, "right", (0.0, height), drive.com[0], quantity(height, "m"))


_AXLE: Any = {"color": INK, "linewidth": 0.8, "linestyle": (0, (8, 2, 1.5, 2)), "zorder": 4}
_CONTACT: Any = {
    "linestyle": "none",
    "marker": "o",
    "markersize": 4.5,
    "markeredgecolor": PAPER,
    "markeredgewidth": 0.6,
    "zorder": 6,
}
_COM: Any = {"linestyle": "none", "markersize": 7.5, "markeredgecolor": INK, "markeredgewidth": 0.7}


def _draw_forward(axes: Axes, height: float, scale: _Scale) -> None:
    """Draws which way is ahead: from the axle to just beyond the robot."""
    end = max(float(scale.high[0]), 0.0) + scale.metres(0.85 * _AWAY)
    look: Any = {"arrowstyle": "-|>", "color": ROOT, "linewidth": 1.4, "mutation_scale": 10, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (end, height), (0.0, height), arrowprops=look, zorder=5)


def _draw_com(axes: Axes, x: float, y: float) -> None:
    """Draws the sign of a centre of mass: a disc of which two quarters are black."""
    for marker in _com_markers():
        axes.plot([x], [y], zorder=7, **marker)


def _com_markers() -> tuple[dict[str, Any], dict[str, Any]]:
    return {**_COM, "marker": "o", "markerfacecolor": PAPER}, {**_COM, "marker": _QUARTERS, "markerfacecolor": INK}


def _dimension(axes: Axes, scale: _Scale, side: str, ends: tuple[float, float], start: Any, text: str) -> None:
    """Draws a dimension beside a robot: two extension lines from what is measured, and a line with arrows.

    Args:
        axes: where to draw.
        scale: of the panel.
        side: of the robot on which the dimension stands.
        ends: of what is measured, along the dimension [m].
        start: where the extension lines begin, across it [m]; one for both ends, or one for each.
        text: what is written.
    """
    sign = {"left": -1, "below": -1, "right": 1}[side]
    across = int(side == "below")
    edge = float((scale.low if sign < 0 else scale.high)[across])
    line = edge + sign * scale.metres(_AWAY)
    begins = np.broadcast_to(start, 2)
    for end, begin in zip(ends, begins, strict=True):
        reach = [(begin, end), (line + sign * scale.metres(_BEYOND), end)]
        points = np.array(reach)[:, ::-1] if across else np.array(reach)
        axes.plot(*points.T, color=INK, linewidth=0.35, zorder=4)
    a, b = ((end, line) if across else (line, end) for end in ends)
    short = (ends[1] - ends[0]) * scale.inches < _SHORT
    look: Any = {
        "arrowstyle": "<|-|>",
        "color": INK,
        "linewidth": 0.6,
        "mutation_scale": 4 if short else 6,
        "shrinkA": 0,
        "shrinkB": 0,
    }
    axes.annotate("", a, b, arrowprops=look, zorder=5)
    middle, off = sum(ends) / 2, line + sign * scale.metres(0.05)
    place = (middle, off) if across else (off, middle)
    align = (
        {"ha": "center", "va": "top"}
        if across
        else {"ha": "right" if sign < 0 else "left", "va": "center", "rotation": 0 if short else 90}
    )
    axes.text(
        *place,
        text,
        fontsize=6.5,
        color=INK,
        zorder=6,
        bbox={"facecolor": (PAPER, 0.8), "edgecolor": "none", "pad": 0.6},
        **align,
    )


def _write_legend(figure: Figure) -> None:
    white, quarters = (Line2D([], [], **marker) for marker in _com_markers())
    handles: list[Any] = [
        Line2D([], [], color=ROOT, linewidth=1.4, marker=">", markevery=[1], markersize=4.5),
        Line2D([], [], **_AXLE),
        Line2D([], [], **_CONTACT, color=_TYRE),
        Line2D([], [], **_CONTACT, color=_CASTER),
        (white, quarters),
    ]
    names = ["forward", "axle", "tyres on the floor", "casters on the floor", "centre of mass"]
    figure.legend(
        handles, names, loc="lower center", ncols=5, borderaxespad=0.2, handler_map={tuple: HandlerTuple(ndivide=1)}
    )
