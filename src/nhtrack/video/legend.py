"""What the signs in the picture mean, at its foot."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np
from PIL import Image, ImageDraw

from nhtrack.colours import GRIP, ICE, ROOT, TOUCH
from nhtrack.ground import Ground
from nhtrack.video.bodies import utilisation_colour
from nhtrack.video.timeline import Timeline
from nhtrack.video.typography import GREY, INK, PAPER, font

__all__ = ["draw_legend"]

_RUBBER = np.array([0.06, 0.06, 0.06])
_Sign = tuple[Callable[[ImageDraw.ImageDraw, float, float, float], None], float, str]


def draw_legend(
    timeline: Timeline, unit: float, room: float = math.inf, ground: Ground | None = None
) -> Image.Image:
    """Returns the legend of a film.

    Args:
        timeline: the film.
        unit: pixels per pixel of a picture of 480 lines.
        room: width that it may have; signs that do not fit go on in another line [pixels].
        ground: what robots drive on.
    """
    letters, pad, height = font(11 * unit), 6 * unit, 20 * unit
    lines: list[list[tuple[float, _Sign]]] = [[]]
    left = pad
    for each in signs_of(timeline, ground):
        width = (each[1] + 5) * unit + letters.getlength(each[2])
        if lines[-1] and left + width + pad > room:
            lines.append([])
            left = pad
        lines[-1].append((left, each))
        left += width + 14 * unit
    widest = max(left + (sign[1] + 5) * unit + letters.getlength(sign[2]) for line in lines for left, sign in line)
    panel = Image.new("RGBA", (round(widest + pad), round(height * len(lines))), PAPER)
    draw = ImageDraw.Draw(panel)
    for row, line in enumerate(lines):
        for left, (sign, width, text) in line:
            middle = (row + 0.5) * height
            sign(draw, left, middle, unit)
            draw.text((left + (width + 5) * unit, middle), text, font=letters, fill=INK, anchor="lm")
    return panel


def signs_of(timeline: Timeline, ground: Ground | None = None) -> list[_Sign]:
    """Returns how each sign of a film is drawn, its width [pixels at 480 lines], and what it means."""
    signs: list[_Sign] = [(partial(_patch, colour=ROOT), 12, "leader")]
    if timeline.twin is not None:
        signs.append((_ring, 12, "ideal twin"))
    if timeline.slot is not None and np.isfinite(timeline.slot).any():
        signs.append((_slot, 15, "place to take"))
    if timeline.utilisation is not None:
        signs.append((_ramp, 46, "friction used, 0 to 100 %"))
    if timeline.skids:
        signs.append((_skid, 18, "wheel slid"))
    if timeline.touches:
        signs.append((_cross, 10, "robots touched"))
    known = ground or Ground()
    for friction in sorted({patch.friction for patch in known.patches}):
        colour = ICE if friction < known.friction else GRIP
        signs.append((partial(_patch, colour=colour), 12, f"friction {friction:g}"))
    return signs


def _patch(draw: ImageDraw.ImageDraw, left: float, middle: float, unit: float, *, colour: str) -> None:
    draw.ellipse((left, middle - 6 * unit, left + 12 * unit, middle + 6 * unit), fill=colour, outline=GREY)


def _cross(draw: ImageDraw.ImageDraw, left: float, middle: float, unit: float) -> None:
    for way in (-5 * unit, 5 * unit):
        draw.line((left, middle - way, left + 10 * unit, middle + way), fill=TOUCH, width=round(2.5 * unit))


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
