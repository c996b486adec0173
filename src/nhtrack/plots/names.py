"""Names written where the curves are that they belong to, none upon another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from nhtrack.colours import letter_colour
from nhtrack.plots.margins import EDGE, shortened, text_width
from nhtrack.plots.style import plain
from nhtrack.presentation.spread import spread

__all__ = ["Path", "ends_room", "name_ends", "name_paths", "spread"]

_WIDE, _HIGH = 0.62, 1.25  # width of a letter on average, and height of a line, over the size of letters
_BESIDE = 5.0  # [pt] from a path to its name
_END, _TICK = 1.022, (1.003, 1.018)  # where a name begins beside a panel and the line to it runs, over its width
_LONGEST = 1.8  # [in] of names beside a panel; longer ones are cut
# Where a name may be, seen from its path: to the right or left, above or below, near or a line or two further off.
_SIDES = np.array([[x, y] for y in (1.0, -1.0, 3.0, -3.0) for x in (1.0, -1.0)])
_APART = 30.0  # [pt] of distance that it is worth to be near
_AIR = 1.5  # [pt] between a name and lines
_SPACING = 4.0  # [pt] between the points of a path that are looked at
_TRIED = 240  # places tried for each name
_FAR = 40.0  # [pt] from other paths: further is no better
# [pt] of distance that it is worth to keep clear of a point, of a name, and of the frame.
_HIT, _OVERLAP, _OUTSIDE = 10.0, 1e5, 1e6


class Path(NamedTuple):
    """Lines that share a name.

    Attributes:
        points: shape (t, k, 2) for k lines; NaN leaves a gap.
        colour: of the name.
        tied: whether a thin line goes from the name to the lines.
    """

    points: np.ndarray
    colour: str
    tied: bool = False


def name_paths(axes: Axes, paths: Mapping[str, Path], nameless: Sequence[np.ndarray] = ()) -> None:
    """Writes each name beside one of its lines, where it is far from other lines and covers as little as may be.

    Args:
        axes: with limits and layout as they stay.
        paths: by their names.
        nameless: more lines to keep off, each of shape (t, k, 2).
    """
    points = {name: _pixels(axes, path.points) for name, path in paths.items()}
    more = np.concatenate([np.empty((0, 2)), *(_pixels(axes, lines) for lines in nameless)])
    everything = np.concatenate([*points.values(), more])
    frame = axes.get_window_extent()
    taken: list[np.ndarray] = []
    for name in sorted(paths, key=len, reverse=True):  # the longest have the fewest places where they fit
        colour = letter_colour(paths[name].colour)
        others = np.concatenate([*(each for other, each in points.items() if other != name), more])
        own = points[name][:: max(1, len(points[name]) // _TRIED)]
        if not len(own):
            continue
        boxes = _boxes(own, len(name), axes)
        score = np.minimum(np.sqrt(_squared_distances(own, others).min(axis=1)), _FAR * _dots(axes))[:, None]
        score = score - _HIT * _dots(axes) * _inside(everything, boxes, _AIR * _dots(axes))
        score -= _OVERLAP * sum(_touches(boxes, other) for other in taken)
        beyond = (boxes[..., 0] < [frame.x0, frame.y0]) | (boxes[..., 1] > [frame.x1, frame.y1])
        score -= _OUTSIDE * beyond.any(axis=-1) + _APART * _dots(axes) * (np.abs(_SIDES[:, 1]) > 1.0)
        best = np.unravel_index(int(score.argmax()), score.shape)
        taken.append(boxes[best])
        x, y = map(float, axes.transData.inverted().transform(boxes[best].mean(axis=-1)))
        text = axes.text(x, y, plain(name), ha="center", va="center", fontsize=_size(), color=colour, zorder=6)
        text.set_path_effects([withStroke(linewidth=2.5, foreground="white")])
        if paths[name].tied:
            _tie(axes, boxes[best], own, colour)


def _tie(axes: Axes, box: np.ndarray, points: np.ndarray, colour: str) -> None:
    """Draws a line from a name's box (2, 2) to the nearest of points (m, 2) in the panel, both in pixels."""
    frame = axes.get_window_extent()
    seen = points[((points >= frame.min) & (points <= frame.max)).all(axis=1)]
    if not len(seen):
        return
    edges = np.clip(seen, box[:, 0], box[:, 1])
    nearest = int(np.hypot(*(seen - edges).T).argmin())
    ends = axes.transData.inverted().transform(np.stack([edges[nearest], seen[nearest]]))
    axes.add_artist(Line2D(*ends.T, color=colour, linewidth=0.5, zorder=5.9))


def _dots(axes: Axes) -> float:
    """Returns pixels in a point."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    return float(figure.dpi / 72)


def _pixels(axes: Axes, points: np.ndarray) -> np.ndarray:
    """Returns points (m, 2) evenly along lines (t, k, 2), in pixels."""
    parts = []
    for line in np.moveaxis(points, 1, 0):
        drawn = axes.transData.transform(line[np.isfinite(line).all(axis=-1)])
        length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(drawn, axis=0).T))])
        marks = np.arange(0.0, length[-1] + 1e-9, _SPACING * _dots(axes))
        parts.append(np.stack([np.interp(marks, length, drawn[:, side]) for side in (0, 1)], axis=-1))
    return np.concatenate(parts)


def _boxes(places: np.ndarray, letters: int, axes: Axes) -> np.ndarray:
    """Returns boxes of a name beside places (m, 2), shape (m, sides, 2, 2): x and y, from and to [pixels]."""
    size = np.array([_WIDE * letters, _HIGH]) * _size() * _dots(axes)
    middles = places[:, None] + _SIDES * (size / 2 + _BESIDE * _dots(axes) * np.array([1.0, 0.4]))
    return np.stack([middles - size / 2, middles + size / 2], axis=-1)


def _squared_distances(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.asarray(sum((one[:, None, side] - other[:, side]) ** 2 for side in (0, 1)))


def _inside(points: np.ndarray, boxes: np.ndarray, margin: float) -> np.ndarray:
    """Returns how many points (p, 2) lie in boxes (m, sides, 2, 2) or less than a margin beside, shape (m, sides)."""
    low, high = boxes[..., None, 0] - margin, boxes[..., None, 1] + margin
    x, y = ((low[:, :, side] < points[:, side]) & (points[:, side] < high[:, :, side]) for side in (0, 1))
    return np.asarray(np.count_nonzero(x & y, axis=-1))


def _touches(boxes: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Returns which boxes (m, sides, 2, 2) overlap another one (2, 2), shape (m, sides)."""
    return np.asarray(((boxes[..., 0] < other[:, 1]) & (other[:, 0] < boxes[..., 1])).all(axis=-1))


def ends_room(names: Sequence[str], width: float) -> float:
    """Returns the room that names beside a panel need [in].

    Args:
        names: of all curves.
        width: of the panel and this room together [in].
    """
    longest = max((text_width(name, _size()) for name in names), default=0.0)
    return width - (width - min(longest, _LONGEST) - EDGE) / _END


def name_ends(axes: Axes, names: Sequence[str], colours: Sequence[str], ends: np.ndarray) -> None:
    """Writes names beside a panel, as high as their curves end, but not upon each other.

    Args:
        axes: with its limits and its layout as they stay.
        names: one for each curve.
        colours: of the names.
        ends: where the curves end; what is below or above the axis is named at its edge.
    """
    drawn = axes.transData.transform(np.stack([np.full(len(ends), axes.get_xlim()[1]), ends], axis=-1))
    starts = np.clip(axes.transAxes.inverted().transform(drawn)[:, 1], 0.0, 1.0)
    size = _size()
    step = _HIGH * size * _dots(axes) / axes.get_window_extent().height
    for name, colour, start, place in zip(names, colours, starts, spread(starts, step), strict=True):
        look: dict[str, Any] = {"transform": axes.transAxes, "color": letter_colour(colour)}
        axes.add_artist(Line2D(_TICK, (start, place), linewidth=0.8, clip_on=False, **look))
        axes.text(_END, place, plain(shortened(name, size, _LONGEST)), va="center", fontsize=size, **look)


def _size() -> float:
    """Returns the size of the letters of names in the style that holds [pt]."""
    return float(mpl.rcParams["legend.fontsize"])
