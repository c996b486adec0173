"""What the signs in the picture mean, in a line at its foot."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from PIL import Image, ImageDraw

from nhtrack.video.bodies import utilisation_colour
from nhtrack.video.timeline import Timeline
from nhtrack.video.typography import GREY, INK, PAPER, font

__all__ = ["draw_legend"]

_RUBBER = np.array([0.06, 0.06, 0.06])
_Sign = tuple[Callable[[ImageDraw.ImageDraw, float, float, float], None], float, str]


def draw_legend(timeline: Timeline, unit: float) -> Image.Image | None:
    """Returns the legend of a film, or None where nothing wants an explanation.

    Args:
        timeline: the film.
        unit: pixels per pixel of a picture of 480 lines.
    """
    signs = signs_of(timeline)
    if not signs:
        return None
    letters, pad, height = font(11 * unit), 6 * unit, 20 * unit
    widths = [sign_width * unit + 5 * unit + letters.getlength(text) for _, sign_width, text in signs]
    gaps = 14 * unit * (len(signs) - 1)
    panel = Image.new("RGBA", (round(sum(widths) + gaps + 2 * pad), round(height)), PAPER)
    draw, left = ImageDraw.Draw(panel), pad
    for (sign, sign_width, text), width in zip(signs, widths, strict=True):
        sign(draw, left, height / 2, unit)
        draw.text((left + (sign_width + 5) * unit, height / 2), text, font=letters, fill=INK, anchor="lm")
        left += width + 14 * unit
    return panel


def signs_of(timeline: Timeline) -> list[_Sign]:
    """Returns how each sign of a film is drawn, its width [pixels at 480 lines], and what it means."""
    signs: list[_Sign] = []
    if timeline.twin is not None:
        signs.append((_ring, 12, "ideal twin"))
    if timeline.slot is not None and np.isfinite(timeline.slot).any():
        signs.append((_slot, 15, "place to take"))
    if timeline.utilisation is not None:
        signs.append((_ramp, 46, "friction used, 0 to 100 %"))
    if timeline.skids:
        signs.append((_skid, 18, "wheel slid"))
    return signs


def _ring(draw: ImageDraw.ImageDraw, left: float, middle: float, unit: float) -> None:
    radius = 6 * unit
    draw.ellipse((left, middle - radius, left + 2 * radius, middle + radius), fill="white", outline=GREY)


def _slot(draw: ImageDraw.ImageDraw, left: float, middle: float, unit: float) -> None:
    corners = [(0, -5), (9, -5), (15, 0), (9, 5), (0, 5)]
    draw.polygon([(left + unit * x, middle + unit * y) for x, y in corners], outline=INK, width=round(1.5 * unit))


def _ramp(draw: ImageDraw.ImageDraw, left: float, middle: float, unit: float) -> None:
    columns = round(46 * unit)
    for column in range(columns):
        red, green, blue = (int(255 * value) for value in utilisation_colour(column / (columns - 1), _RUBBER))
        draw.line((left + column, middle - 4 * unit, left + column, middle + 4 * unit), fill=(red, green, blue))


def _skid(draw: ImageDraw.ImageDraw, left: float, middle: float, unit: float) -> None:
    for offset in (-3, 3):
        level = middle + offset * unit
        draw.line((left, level, left + 18 * unit, level), fill=(30, 30, 32), width=round(2.5 * unit))
