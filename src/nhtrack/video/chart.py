"""The live plot of a split screen: errors over time, drawn up to now."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator

from nhtrack.analysis.metrics import heading_error, position_error, position_gap
from nhtrack.colours import BAND_COLOUR
from nhtrack.plots.style import plain, styled
from nhtrack.presentation.shown import CROWD
from nhtrack.recording import Recording
from nhtrack.video.timeline import Timeline

__all__ = ["Beside", "Chart", "split"]

_WIDE = 1.5  # width over height from which the plot stands beside the view, else below it
_BESIDE, _BELOW = 0.36, 0.42  # share of the picture that the plot takes
_DECADES = 6  # below the largest value that an axis shows at most
_TITLE, _NUMBERS = 12.0, 11.0  # [pixels at 480 lines] sizes of letters
_LETTER = 0.6  # width of a letter over its size
_PALE = 0.16  # opacity of what is yet to come


class Beside(NamedTuple):
    """Where the plot is in the picture: its upper left corner and its size [pixels]."""

    corner: tuple[int, int]
    size: tuple[int, int]


def split(size: tuple[int, int]) -> tuple[tuple[int, int], Beside]:
    """Returns the size of the camera's view, at the picture's upper left, and where the plot is [pixels]."""
    width, height = size
    if width / height >= _WIDE:
        view = round(width * (1 - _BESIDE)) // 2 * 2
        return (view, height), Beside((view, 0), (width - view, height))
    view = round(height * (1 - _BELOW)) // 2 * 2
    return (width, view), Beside((0, view), (width, height - view))


class Chart:
    """Position error, heading error and gap to the ideal twin; all is drawn once, pale and full.

    Args:
        recording: the run.
        timeline: the film.
        size: width and height [pixels].
        unit: pixels per pixel of a picture of 480 lines.
    """

    def __init__(self, recording: Recording, timeline: Timeline, size: tuple[int, int], unit: float = 1.0) -> None:
        self._pale, self._full, self._spans = _draw(recording, size, unit)
        duration = max(float(recording.time[-1] - recording.time[0]), 1e-12)
        self._share = (timeline.time - recording.time[0]) / duration

    def draw(self, frame: int) -> np.ndarray:
        """Returns the plot at a frame, bytes of shape (height, width, 3)."""
        picture = self._pale.copy()
        for first, last in self._spans:
            now = round(first + (last - first) * float(self._share[frame]))
            picture[:, round(first) : now + 1] = self._full[:, round(first) : now + 1]
        return picture


@styled
def _draw(
    recording: Recording, size: tuple[int, int], unit: float
) -> tuple[np.ndarray, np.ndarray, list[tuple[float, float]]]:
    """Returns the plot with all curves pale and full, and the columns of each panel's first and last time [pixels]."""
    dpi = 72 * unit  # a point is a pixel of a picture of 480 lines
    figure = Figure((size[0] / dpi, size[1] / dpi), dpi=dpi, layout="constrained")
    FigureCanvasAgg(figure)
    curves = _curves(recording)
    stacked = size[1] >= size[0]
    shape = (len(curves), 1) if stacked else (1, len(curves))
    panels = list(figure.subplots(*shape, squeeze=False).flat)
    drawn: list[Artist] = []
    for axes, (title, values) in zip(panels, curves.items(), strict=True):
        drawn += _draw_panel(axes, recording, values)
        axes.set_title(title, fontsize=_TITLE, loc="left")
        axes.tick_params(labelsize=_NUMBERS)
        axes.yaxis.set_minor_locator(NullLocator())
        if not stacked or axes is panels[-1]:
            axes.set_xlabel("time [s]", fontsize=_NUMBERS)
    _name_curves(figure, recording, size[0] / unit)
    full = _picture(figure, size)
    figure.set_layout_engine("none")  # laid out by the first drawing
    for artist in drawn:
        artist.set_alpha(_PALE * (artist.get_alpha() or 1.0))
    ends = [axes.transData.transform([(recording.time[0], 1.0), (recording.time[-1], 1.0)]) for axes in panels]
    return _picture(figure, size), full, [(float(pair[0, 0]), float(pair[1, 0])) for pair in ends]


def _name_curves(figure: Figure, recording: Recording, width: float) -> None:
    """Writes who has which colour above the panels, in as many lines as the width [pixels at 480 lines] asks for."""
    groups, colour = recording.groups, recording.scene.colour
    if groups:
        names = {name: colour(recording.robots.index(robots[0])) for name, robots in groups.items()}
    elif len(recording.robots) - 1 > CROWD:
        names = {f"median and extremes of {len(recording.robots) - 1} followers": BAND_COLOUR}
    else:
        names = {name: colour(place) for place, name in enumerate(recording.robots)}
    widest = _LETTER * _NUMBERS * max(map(len, names)) + 3 * _NUMBERS
    look: dict[str, Any] = {"handlelength": 1.2, "handletextpad": 0.4, "columnspacing": 1.0, "borderpad": 0.2}
    handles = [Line2D([], [], color=each, linewidth=2.0) for each in names.values()]
    columns = max(1, min(len(names), int(width / widest)))
    figure.legend(handles, map(plain, names), loc="outside upper left", ncols=columns, fontsize=_NUMBERS, **look)


def _picture(figure: Figure, size: tuple[int, int]) -> np.ndarray:
    figure.canvas.draw()
    return np.asarray(figure.canvas.buffer_rgba())[: size[1], : size[0], :3].copy()  # type: ignore[attr-defined]


def _curves(recording: Recording) -> dict[str, np.ndarray]:
    """Returns what the plot shows, by its title, each of shape (t, n)."""
    curves = {
        "position error [m]": position_error(recording),
        "heading error [rad]": np.abs(heading_error(recording)),
    }
    if recording.has_twin:
        curves["gap to ideal twin [m]"] = position_gap(recording)
    return curves


def _draw_panel(axes: Axes, recording: Recording, values: np.ndarray) -> list[Artist]:
    """Draws the curves of a panel, and returns them."""
    colour = recording.scene.colour
    known = np.where(np.isfinite(values) & (values > 0), values, np.nan)
    drawn = np.flatnonzero(np.isfinite(known).any(axis=0))
    axes.set_xlim(recording.time[0], recording.time[-1] if recording.time.size > 1 else recording.time[0] + 1)
    axes.xaxis.set_major_locator(MaxNLocator(3))
    if drawn.size == 0:
        return []
    artists: list[Artist] = []
    if drawn.size > CROWD:
        rows = np.isfinite(known).any(axis=1)
        low, middle, high = np.nanpercentile(known[rows][:, drawn], [0, 50, 100], axis=1)
        artists.append(axes.fill_between(recording.time[rows], low, high, color=BAND_COLOUR, alpha=0.3, linewidth=0))
        artists += axes.plot(recording.time[rows], middle, color=BAND_COLOUR, linewidth=1.0)
    for place in drawn if drawn.size <= CROWD else ():
        artists += axes.plot(recording.time, known[:, place], color=colour(int(place)), linewidth=1.0)
    top = float(np.nanmax(known))
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(numticks=5))
    axes.set_ylim(max(float(np.nanmin(known)) / 1.5, top * 10.0**-_DECADES), 1.8 * top)
    return artists
