"""Letters, inks and numbers of what is written over pictures."""

from __future__ import annotations

import math
from pathlib import Path

import matplotlib as mpl
from PIL import ImageFont

__all__ = ["GREY", "INK", "PAPER", "font", "running_length"]

PAPER, INK, GREY = (250, 250, 252, 205), (26, 26, 26), (105, 108, 115)


def font(pixels: float, *, bold: bool = False) -> ImageFont.FreeTypeFont:
    """Returns the figures' typeface, which matplotlib brings along."""
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(mpl.get_data_path()) / "fonts" / "ttf" / name), max(round(pixels), 8))


def running_length(metres: float) -> str:
    """Returns a distance with a unit that suits it; figures of constant width, so that they can be read running."""
    if math.isnan(metres):
        return "unknown"
    if metres >= 1e4:
        return f"{metres:.0e} m"
    if metres >= 1.0:
        return f"{metres:5.2f} m"
    if metres >= 0.001:
        return f"{100 * metres:5.1f} cm" if metres >= 0.01 else f"{1000 * metres:5.2f} mm"
    return f"{1e6 * metres:5.1f} µm" if metres >= 1e-8 else "  0.0 µm"
