"""Panels over time, one below the other: a curve a robot, with its name at its end.

More than `CROWD` followers are drawn as their median and their extremes, of every instant: the worst where magnitudes
are shown, the highest and the lowest where signs are. Where a short peak dwarfs the rest a panel's axis has a
knee (`nhtrack.presentation.bend`).
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FixedLocator, Formatter, LogLocator, MaxNLocator, NullLocator

from nhtrack.colours import BAND_COLOUR, INK, PAPER, robot_colour
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
from nhtrack.plots.names import ends_room, name_ends
from nhtrack.plots.style import COLUMN, panel_title, run_title, time_axes, write_note
from nhtrack.presentation.bend import bent, bent_ticks, knee_of, straightened
from nhtrack.presentation.shown import CROWD
from nhtrack.recording import Recording

__all__ = ["DASHED", "LIMIT", "LIMIT_AT", "LIMIT_TEXT", "Sheet", "zeros_as_gaps"]

DASHED: dict[str, Any] = {"linestyle": (0, (3, 1.5))}
LIMIT: dict[str, Any] = {"color": INK, "linewidth": 0.7, "linestyle": (0, (6, 3)), "zorder": 2}
# What a limit is stands at the panel's right: at a place of the panel, or, with `LIMIT_AT`, at a value.
LIMIT_TEXT: dict[str, Any] = {
    "xycoords": "axes fraction", "textcoords": "offset points", "ha": "right", "fontsize": 6.0, "color": INK,
    "path_effects": [withStroke(linewidth=2.0, foreground=PAPER)], "zorder": 5,
}  # fmt: skip
LIMIT_AT: dict[str, Any] = {"xycoords": ("axes fraction", "data")}

_PANEL = 0.84  # [in] height of a panel
_GAP = 0.08  # [in] between a panel and the title of the next
_LEFT, _RIGHT = 0.4, 0.5  # [in] beside the panels until it is known what is written there
_DECADES = 6  # log axes show at most this many: below is rounding, not tracking
_EXTREME: dict[str, Any] = {"linewidth": 0.6}
_KNEE: dict[str, Any] = {"color": "#666666", "linewidth": 0.6, "linestyle": (0, (1, 1.5)), "zorder": 1}


class _End(NamedTuple):
    """A name at the end of a curve."""

    name: str
    colour: str
    value: float


class Sheet:
    """A figure of panels over a run's time, being drawn.

    Attributes:
        figure: the figure.
        panels: one a row, from above.
    """

    def __init__(self, recording: Recording, panels: Sequence[tuple[str, str]]) -> None:
        """Begins a figure.

        Args:
            recording: the run.
            panels: title and label of the axis, with its unit, of every panel.
        """
        self.figure = Figure(figsize=(COLUMN, 1.0))
        self.panels: list[Axes] = list(self.figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0])
        self._recording = recording
        self._ends: list[list[_End]] = [[] for _ in panels]
        self._drawn: list[list[np.ndarray]] = [[] for _ in panels]
        self._knees: list[float | None] = [None for _ in panels]
        for k, (axes, (title, label)) in enumerate(zip(self.panels, panels, strict=True)):
            panel_title(axes, "abcdefgh"[k], title)
            axes.set_ylabel(label)
            axes.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 2.5, 5, 10]))
            axes.yaxis.set_major_formatter(Numbers())
        self._place(_LEFT, _RIGHT, 0.0, 0.0)  # marks of events need to know how high panels are

    def _place(self, left: float, right: float, above: float, below: float) -> list[Box]:
        """Puts the panels where they belong, some inches from the figure's edges; returns where that is."""
        title, rows = title_room(), len(self.panels)
        height = above + rows * (title + _PANEL) + (rows - 1) * _GAP + below
        self.figure.set_figheight(height)
        bottoms = [height - above - row * _GAP - (row + 1) * (title + _PANEL) for row in range(rows)]
        boxes = [Box(left, bottom, COLUMN - left - right, _PANEL) for bottom in bottoms]
        for axes, box in zip(self.panels, boxes, strict=True):
            place_panel(axes, box)
        return boxes

    def draw(
        self,
        row: int,
        values: np.ndarray,
        places: Sequence[int],
        *,
        named: bool = True,
        magnitude: bool = False,
        **line: Any,
    ) -> None:
        """Draws a curve a robot in its colour, or a crowd's followers as their median and their extremes.

        Args:
            row: of the panel.
            values: shape (t, k), one column a robot; NaN leaves a gap, and a robot of which nothing is known out.
            places: the k robots' places in the recording, 0 the root.
            named: whether names stand at the curves' ends.
            magnitude: whether zero is best, so that a crowd has a worst rather than a highest and a lowest.
            **line: properties of the curves.
        """
        robots = self._recording.robots
        crowded = len(robots) - 1 > CROWD
        together = [column for column, place in enumerate(places) if crowded and place != 0]
        ends = self._draw_crowd(row, values[:, together], magnitude, **line) if together else []
        for column, place in enumerate(places):
            known = values[np.isfinite(values[:, column]), column]
            if column in together or not known.size:
                continue
            colour, over = robot_colour(place), 3.5 if place == 0 else 3.0
            self.panels[row].plot(self._recording.time, values[:, column], color=colour, zorder=over, **line)
            ends.append(_End(robots[place], colour, float(known[-1])))
        if named:
            self._ends[row] += ends
        self._drawn[row].append(values)
        self._bend(row)

    def _bend(self, row: int) -> None:
        """Gives a panel's axis a knee where a short peak dwarfs the rest of what is drawn there."""
        knee = self._knees[row] = knee_of(np.concatenate(self._drawn[row], axis=1))
        if knee is not None:
            scale = partial(bent, knee=knee), partial(straightened, knee=knee)
            self.panels[row].set_yscale("function", functions=scale)
            self.panels[row].yaxis.set_major_formatter(_BentNumbers())

    def _draw_crowd(self, row: int, band: np.ndarray, magnitude: bool, **line: Any) -> list[_End]:
        axes, time = self.panels[row], self._recording.time
        low, high = np.fmin.reduce(band, axis=1), np.fmax.reduce(band, axis=1)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # before the first period nothing is known of any
            median = np.nanmedian(band, axis=1)
        axes.fill_between(time, median if magnitude else low, high, color=BAND_COLOUR, alpha=0.18, linewidth=0)
        axes.plot(time, median, color=BAND_COLOUR, zorder=3, **line)
        extremes = [("worst", high)] if magnitude else [("highest", high), ("lowest", low)]
        curves = [("median", median), *extremes]
        for _, curve in curves[1:]:
            axes.plot(time, curve, color=BAND_COLOUR, zorder=2.5, **line | _EXTREME)
        finite = [(name, curve[np.isfinite(curve)]) for name, curve in curves]
        return [_End(name, BAND_COLOUR, float(curve[-1])) for name, curve in finite if curve.size]

    def logarithmic(self, row: int) -> None:
        """Makes a panel's axis logarithmic, over the whole decades of its curves but what is next to nothing."""
        axes = self.panels[row]
        self._knees[row] = None
        axes.set_yscale("log")
        axes.yaxis.set_minor_locator(NullLocator())
        axes.yaxis.set_major_formatter(Decades())
        curves = [np.asarray(line.get_ydata(), dtype=float) for line in axes.lines]
        drawn = np.concatenate([np.empty(0), *curves])
        known = drawn[np.isfinite(drawn) & (drawn > 0)]
        if known.size:
            top = float(known.max())
            bottom = np.clip(float(np.quantile(known, 0.005)), top / 10**_DECADES, top / 10)
            axes.set_ylim(10 ** np.floor(np.log10(bottom)), 10 ** np.ceil(np.log10(1.05 * top)))
        axes.yaxis.set_major_locator(LogLocator(numticks=5))

    def finished(self, *notes: str) -> Figure:
        """Returns the figure with its time axis, its names and a note of sentences below."""
        time_axes(np.array(self.panels)[:, None], self._recording)
        followers = len(self._recording.robots) - 1
        crowd = [f"Of the {followers} followers: median and extremes at every instant."] if followers > CROWD else []
        above = run_title(self.figure, self._recording) or EDGE
        below = write_note(self.figure, self._recording, *notes, *crowd, *self._draw_knees()) + axis_room()
        numbers = max(number_width(axes.yaxis) for axes in self.panels)
        left = EDGE + label_room(numbers)
        right = ends_room([end.name for ends in self._ends for end in ends], COLUMN - left)
        for axes, box in zip(self.panels, self._place(left, right, above, below), strict=True):
            place_labels(axes, box, numbers)
        for axes, ends in zip(self.panels, self._ends, strict=True):
            if ends:
                names, colours, values = zip(*ends, strict=True)
                name_ends(axes, names, colours, np.array(values))
        return self.figure


    def _draw_knees(self) -> list[str]:
        """Draws where axes bend, with their numbers; returns what to say of it."""
        for axes, knee in zip(self.panels, self._knees, strict=True):
            if knee is not None:
                low, high = axes.get_ylim()
                axes.yaxis.set_major_locator(FixedLocator(bent_ticks(low, high, knee)))
                for side in (-knee, knee):
                    if low < side < high:
                        axes.axhline(side, **_KNEE)
        return ["Logarithmic beyond the dotted lines."] if any(self._knees) else []


class _BentNumbers(Formatter):
    """The numbers of an axis with a knee: each with the decimals it needs itself."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Returns a single number as text."""
        return f"{x:g}".replace("-", "\N{MINUS SIGN}") if x == 0 or 1e-3 <= abs(x) < 1e4 else Numbers()(x)

    def format_ticks(self, values: Iterable[float]) -> list[str]:
        """Returns the numbers of an axis as texts."""
        return [self(value) for value in values]


def zeros_as_gaps(values: np.ndarray) -> np.ndarray:
    """Returns values with zeros as gaps, which a logarithm has no place for."""
    return np.where(values > 0, values, np.nan)
