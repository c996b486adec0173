"""Letters, inks and numbers of what is written over pictures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
from PIL import ImageFont

__all__ = ["GREY", "INK", "PAPER", "font", "running_lengths"]

PAPER, INK, GREY = (250, 250, 252, 205), (26, 26, 26), (105, 108, 115)


def font(pixels: float, *, bold: bool = False) -> ImageFont.FreeTypeFont:
    """Returns the figures' typeface, which matplotlib brings along."""
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(mpl.get_data_path()) / "fonts" / "ttf" / name), max(round(pixels), 8))


def running_lengths(metres: Sequence[float]) -> list[str]:
    """Returns distances in one unit, which suits the largest; of constant width, so that they can be read running."""
    largest = max((abs(value) for value in metres if not math.isnan(value)), default=0.0)
    return ["unknown" if math.isnan(value) else _in_unit_of(largest, value) for value in metres]


def _in_unit_of(largest: float, metres: float) -> str:
    """Returns a distance in the unit, and with the decimals, that suit the largest of some."""
    if largest >= 1e4:
        return f"{metres:.0e} m"
    if largest >= 0.9995:
        return f"{metres:5.2f} m"
    if largest >= 0.001:
        decimals = 0 if largest >= 0.1 else 1 if largest >= 0.01 else 2
        return f"{1000 * metres:5.{decimals}f} mm"
    return f"{1e6 * metres:5.1f} µm"
