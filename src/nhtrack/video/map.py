"""The whole run from above, in a corner of the picture."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from PIL import Image, ImageDraw

from nhtrack import se2
from nhtrack.presentation.numbers import quantity
from nhtrack.video.timeline import Timeline
from nhtrack.video.typography import GREY, PAPER, font

__all__ = ["Map", "round_length"]

_FINE = 3  # drawn this much larger and reduced: Pillow's lines are not smooth
_DART = np.array([[0.62, 0.0], [-0.38, 0.36], [-0.20, 0.0], [-0.38, -0.36]])


class Map:
    """The whole run from above: faint paths, brighter up to now, robots as darts, and a scale bar.

    Args:
        timeline: the film.
        colour: of each robot by its place.
        width: of the map [pixels].
        tallest: height that it may have [pixels].
        unit: pixels per pixel of a picture of 480 lines.

    Attributes:
        scale: [pixels/m].
        middle: of what it shows [m], shape (2,).
    """

    def __init__(
        self, timeline: Timeline, colour: Callable[[int], str], width: int, tallest: int, unit: float
    ) -> None:
        positions = timeline.pose[..., :2]
        low, high = positions.min(axis=(0, 1)), positions.max(axis=(0, 1))
        room = np.maximum(high - low, 0.2)
        margin = min(12 * unit, width / 4, tallest / 4)
        foot = min(8 * unit, tallest / 4)  # where the scale bar stands
        self.scale = min((width - 2 * margin) / room[0], (tallest - 2 * margin - foot) / room[1])  # [pixels/m]
        self._size = (
            max(round(room[0] * self.scale + 2 * margin), width // 2),
            round(room[1] * self.scale + 2 * margin + foot),
        )
        self._centre = np.array([self._size[0], self._size[1] - foot]) / 2
        self.middle = (low + high) / 2
        self._unit, self._crowd = unit, positions.shape[1] > 8
        self._trails, self._time, self._colour = timeline.trails, timeline.time, colour
        self._faint = self._sheet()
        draw = ImageDraw.Draw(self._faint)
        for place in reversed(range(positions.shape[1])):
            self._line(draw, self._trails[place].points, colour(place) + "66", 1.2)
        self._draw_scale(draw)

    def draw(self, pose: np.ndarray, frame: int) -> Image.Image:
        """Returns the map at a frame, with poses (n, 3)."""
        sheet = self._faint.copy()
        draw = ImageDraw.Draw(sheet)
        order = list(reversed(range(len(pose))))
        for place in order:
            so_far = int(np.searchsorted(self._trails[place].time, self._time[frame], side="right"))
            way = np.vstack([self._trails[place].points[:so_far], pose[place, :2]])
            self._line(draw, way, self._colour(place), 0.8 if self._crowd and place else 1.6)
        length = (7 if self._crowd else 11) * self._unit / self.scale
        for place in sorted(order):  # followers upon the root, smaller
            size = length * (1.25 if place == 0 else 0.9)
            corners = self._pixels(se2.act(pose[place][None, :], size * _DART))
            draw.polygon(corners, fill=self._colour(place), outline="white")
        return sheet.reduce(_FINE)

    def _draw_scale(self, draw: ImageDraw.ImageDraw) -> None:
        """Draws a bar of a round length at the lower left."""
        pixels_per_metre, unit = self.scale * _FINE, self._unit * _FINE
        metres = round_length(0.3 * self._size[0] * _FINE / pixels_per_metre)
        left, level = 6 * unit, self._size[1] * _FINE - 5 * unit
        right = left + metres * pixels_per_metre
        draw.line((left, level, right, level), fill=GREY, width=max(1, round(1.2 * unit)))
        for end in (left, right):
            draw.line((end, level - 2.5 * unit, end, level + 2.5 * unit), fill=GREY, width=max(1, round(1.2 * unit)))
        draw.text((right + 4 * unit, level), quantity(metres, "m"), font=font(9 * unit), fill=GREY, anchor="lm")

    def _sheet(self) -> Image.Image:
        width, height = (_FINE * side for side in self._size)
        sheet = Image.new("RGBA", (width, height), PAPER)
        ImageDraw.Draw(sheet).rectangle((0, 0, width - 1, height - 1), outline="#B9BDC4", width=_FINE)
        return sheet

    def _pixels(self, points: np.ndarray) -> list[tuple[float, float]]:
        centred = (points - self.middle) * self.scale * _FINE
        return [(float(x), float(y)) for x, y in centred * [1, -1] + self._centre * _FINE]

    def _line(self, draw: ImageDraw.ImageDraw, points: np.ndarray, colour: str, width: float) -> None:
        draw.line(self._pixels(points), fill=colour, width=max(1, round(width * self._unit * _FINE)))


def round_length(longest: float) -> float:
    """Returns the largest of 1, 2 and 5 times a power of ten [m] that is not above `longest`."""
    power = 10.0 ** np.floor(np.log10(longest))
    return float(max(step for step in (power, 2 * power, 5 * power) if step <= longest * (1 + 1e-9)))
