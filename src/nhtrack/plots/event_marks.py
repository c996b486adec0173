"""Events drawn into panels over time: shaded while they last, named where they last longest."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.transforms import ScaledTranslation

from nhtrack.analysis.event import Event, EventKind
from nhtrack.colours import INK, robot_colour
from nhtrack.presentation.numbers import counted
from nhtrack.presentation.shown import CROWD, Span, covered
from nhtrack.recording import Recording

__all__ = ["covered", "make_room", "mark_events"]

# The edges of a shade and the dots at the ends of a bar let the shortest event be seen.
_SHADE: dict[str, Any] = {"color": "#7A7A7A", "alpha": 0.14, "linewidth": 0.6, "zorder": 0.8}
_INSTANT: dict[str, Any] = {"color": INK, "linewidth": 1.2, "zorder": 4}
_BAR: dict[str, Any] = {"linewidth": 1.8, "marker": "o", "markersize": 1.8, "markeredgewidth": 0, "zorder": 4.5}
_BAR_STEP = 3.0  # [pt] from one robot's bar to the next
_NAME_STEP = 7.5  # [pt] from one name to the next
_MARGIN = 2.0  # [pt] from the upper edge to the first of them
_MOST_ROOM = 0.6  # of a panel's height


def mark_events(
    axes: Axes,
    recording: Recording,
    events: Sequence[Event],
    kinds: Sequence[EventKind],
    *,
    bars: bool = True,
    names: bool = True,
) -> None:
    """Shades while events of these kinds last and writes each kind's name at its longest; instants are lines.

    The shade is grey and covers the events of all robots. Bars along the upper edge, in the robots' colours, say whose
    they are; a crowd has none, and the name says of how many robots it is. Bars and names stand above the curves: where
    there are any, the axis is made longer.

    Args:
        axes: a panel over robot time.
        recording: the run.
        events: events of the run; those of other kinds are left alone.
        kinds: kinds that concern this panel, in the order of their names from above.
        bars: whether to say whose events they are.
        names: whether to say what they are.
    """
    shown = [event for event in events if event.kind in kinds]
    if not shown:
        return
    last, crowd = float(recording.time[-1]), len(recording.robots) - 1 > CROWD
    _shade(axes, shown, last)
    below = _MARGIN
    if bars and not crowd:
        below = _draw_bars(axes, shown, recording.robots, last, below)
    if names:
        for kind in kinds:
            below = _write_name(axes, [event for event in shown if event.kind == kind], last, below, crowd=crowd)
    if below > _MARGIN:
        make_room(axes, below)


def _span(event: Event, last: float) -> Span:
    """Returns start and end of an event, as far as the panel reaches."""
    return min(event.start, last), min(event.end, last)


def _shade(axes: Axes, events: Sequence[Event], last: float) -> None:
    for start, end in covered(_span(event, last) for event in events if event.start < event.end):
        axes.axvspan(start, end, **_SHADE)
    for event in events:
        if event.start == event.end:
            axes.axvline(min(event.start, last), **_INSTANT)


def _draw_bars(axes: Axes, events: Sequence[Event], robots: Sequence[str], last: float, below: float) -> float:
    """Draws a row of bars for each robot, the first some points below the upper edge; returns where to go on."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    for place, name in enumerate(robots):
        spans = [_span(event, last) for event in events if name in event.robots and event.start < event.end]
        down = axes.get_xaxis_transform() + ScaledTranslation(0.0, -below / 72, figure.dpi_scale_trans)
        for span in spans:
            axes.add_artist(Line2D(span, (1.0, 1.0), color=robot_colour(place), transform=down, **_BAR))
        below += _BAR_STEP if spans else 0.0
    return below


def _write_name(axes: Axes, events: Sequence[Event], last: float, below: float, *, crowd: bool) -> float:
    """Writes what events of one kind are at the longest, some points below the upper edge; returns where to go on.

    The name begins where an event in the left half of the panel does, and ends where one in the right half does.
    """
    if not events:
        return below
    robots = len({name for event in events for name in event.robots})
    count = f": {counted(robots, 'robot')}" if crowd else ""
    start, end = max((_span(event, last) for event in events), key=lambda span: span[1] - span[0])
    early = start + end <= last
    axes.annotate(
        f"{events[0].kind}{count}", (start if early else end, 1.0), xycoords=("data", "axes fraction"),
        xytext=(3 if early else -3, -below), textcoords="offset points", ha="left" if early else "right", va="top",
        fontsize=6.0, color=INK, zorder=5,
    )  # fmt: skip
    return below + _NAME_STEP


def make_room(axes: Axes, points: float) -> None:
    """Makes an axis longer at its upper end, so that the curves stay some points below the panel's upper edge."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    scale = axes.yaxis.get_transform()
    bottom, top = scale.transform(np.array(axes.get_ylim()))
    height = axes.get_window_extent().height * 72 / figure.dpi  # as laid out so far, a little less than in the end
    share = min(points / height, _MOST_ROOM)
    axes.set_ylim(top=float(scale.inverted().transform(bottom + (top - bottom) / (1 - share))))
