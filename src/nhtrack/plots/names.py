"""Names written where the curves are that they belong to, none upon another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke

__all__ = ["Path", "name_ends", "name_paths", "spread"]

_SIZE = 8.5  # [pt] of letters
_WIDE, _HIGH = 0.62, 1.25  # width of a letter on average, and height of a line, over the size of letters
_BESIDE = 5.0  # [pt] from a path to its name
_STEP = 0.085  # of a panel's height, from one name beside it to the next
_SPACING = 4.0  # [pt] between the points of a path that are looked at
_TRIED = 240  # places tried for each name
_FAR = 40.0  # [pt] from other paths: further is no better
_HIT, _OVERLAP, _OUTSIDE = 4.0, 500.0, 1000.0  # [pt] of distance that it is worth to keep clear of a point, a name, ...


class Path(NamedTuple):
    """Lines that share a name.

    Attributes:
        points: shape (t, k, 2) for k lines; NaN leaves a gap.
        colour: of the name.
    """

    points: np.ndarray
    colour: str


def name_paths(axes: Axes, paths: Mapping[str, Path]) -> None:
    """Writes each name beside one of its lines, where it is far from other lines and covers as little as may be.

    Args:
        axes: with limits and layout as they stay.
        paths: by their names.
    """
    points = {name: _pixels(axes, path.points) for name, path in paths.items()}
    everything = np.concatenate(list(points.values()))
    frame = axes.get_window_extent()
    taken: list[np.ndarray] = []
    for name, (_, colour) in paths.items():
        others = np.concatenate([each for other, each in points.items() if other != name])
        own = points[name][:: max(1, len(points[name]) // _TRIED)]
        if not len(own):
            continue
        boxes = _boxes(own, len(name), axes)
        score = np.minimum(np.sqrt(_squared_distances(own, others).min(axis=1)), _FAR * _dots(axes))[:, None]
        score = score - _HIT * _dots(axes) * _inside(everything, boxes)
        score -= _OVERLAP * sum(_touches(boxes, other) for other in taken)
        beyond = (boxes[..., 0] < [frame.x0, frame.y0]) | (boxes[..., 1] > [frame.x1, frame.y1])
        score -= _OUTSIDE * beyond.any(axis=-1)
        best = np.unravel_index(int(score.argmax()), score.shape)
        taken.append(boxes[best])
        x, y = map(float, axes.transData.inverted().transform(boxes[best].mean(axis=-1)))
        text = axes.text(x, y, name, ha="center", va="center", fontsize=_SIZE, color=colour, zorder=6)
        text.set_path_effects([withStroke(linewidth=2.5, foreground="white")])


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
    """Returns boxes of a name beside places (m, 2) on four sides, shape (m, 4, 2, 2): x and y, from and to [pixels]."""
    size = np.array([_WIDE * letters, _HIGH]) * _SIZE * _dots(axes)
    sides = np.array([[1, 1], [-1, 1], [1, -1], [-1, -1]])
    middles = places[:, None] + sides * (size / 2 + _BESIDE * _dots(axes) * np.array([1.0, 0.4]))
    return np.stack([middles - size / 2, middles + size / 2], axis=-1)


def _squared_distances(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.asarray(((one[:, None] - other[None]) ** 2).sum(axis=-1))


def _inside(points: np.ndarray, boxes: np.ndarray) -> np.ndarray:
    """Returns how many points lie in each box, (p, 2) and (m, 4, 2, 2) -> (m, 4)."""
    low, high = boxes[:, :, None, :, 0], boxes[:, :, None, :, 1]
    return np.asarray(((low < points) & (points < high)).all(axis=-1).sum(axis=-1))


def _touches(boxes: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Returns which boxes (m, 4, 2, 2) overlap another one (2, 2), shape (m, 4)."""
    return np.asarray(((boxes[..., 0] < other[:, 1]) & (other[:, 0] < boxes[..., 1])).all(axis=-1))


def name_ends(axes: Axes, names: Sequence[str], colours: Sequence[str], ends: np.ndarray) -> None:
    """Writes names beside a panel with a logarithmic axis, as high as their curves end, but not upon each other.

    Args:
        axes: with its limits as they stay.
        names: one for each curve.
        colours: of the names.
        ends: where the curves end; what is below or above the axis is named at its edge.
    """
    low, high = np.log(axes.get_ylim())
    starts = (np.clip(np.log(ends), low, high) - low) / (high - low)
    for name, colour, start, place in zip(names, colours, starts, spread(starts, _STEP), strict=True):
        axes.plot((1.003, 1.018), (start, place), lw=0.8, transform=axes.transAxes, clip_on=False, color=colour)
        axes.text(1.022, place, name, va="center", fontsize=_SIZE, transform=axes.transAxes, color=colour)


def spread(places: np.ndarray, step: float) -> np.ndarray:
    """Returns places from 0 to 1 moved apart to at least `step`, in the same order, each as little as may be.

    Places that come too near are moved as one block, which stands around their mean (pool adjacent violators).
    """
    order = np.argsort(places, kind="stable")
    blocks: list[tuple[float, int]] = []  # where the lowest of so many would stand, if it were for their mean
    for place in places[order]:
        block = (float(place), 1)
        while blocks and _lowest(blocks[-1], step) + step * blocks[-1][1] > _lowest(block, step):
            (below, fewer), (above, more) = blocks.pop(), block
            block = ((below * fewer + (above - step * fewer) * more) / (fewer + more), fewer + more)
        blocks.append(block)
    result = np.empty(len(places))
    result[order] = np.concatenate([_lowest(block, step) + step * np.arange(block[1]) for block in blocks])
    return result


def _lowest(block: tuple[float, int], step: float) -> float:
    """Returns where the lowest of a block stands: all of it within 0 to 1, where there is the room."""
    place, count = block
    return float(np.clip(place, 0.0, max(0.0, 1.0 - step * (count - 1))))
