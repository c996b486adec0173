"""Room around panels, reckoned from what is written there: nothing has to be drawn to find it.

Figures one column wide have panels of known sizes in inches. Their margins follow from the letters of numbers, labels
and names; a layout engine would draw every figure several times to find the same.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path
from matplotlib.ticker import Formatter

__all__ = [
    "EDGE",
    "Box",
    "Decades",
    "Numbers",
    "axis_room",
    "label_room",
    "line_height",
    "number_room",
    "number_width",
    "place_labels",
    "place_panel",
    "shortened",
    "text_width",
    "title_room",
]

EDGE = 0.03  # [in] between what is written and the edge of a figure
_LINE = 1.2  # height of a line over the size of its letters
_PLAIN = 4  # powers of ten from here on are written as such
_DECIMALS = 6  # at most
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


class Box(NamedTuple):
    """Where a panel stands in its figure [in]: its left and lower edge, its width and its height."""

    left: float
    bottom: float
    width: float
    height: float


def line_height(size: float) -> float:
    """Returns the height of a line of letters of a size in points [in]."""
    return _LINE * size / 72


def text_width(text: str, size: float) -> float:
    """Returns the width of a line of letters of a size in points [in]."""
    properties = FontProperties(family=mpl.rcParams["font.family"], size=size)
    return float(text_to_path.get_text_width_height_descent(text, properties, ismath=False)[0]) / 72


def number_width(axis: Axis) -> float:
    """Returns the width of the widest number that an axis has within its limits [in]."""
    places = [float(place) for place in axis.get_majorticklocs()]
    low, high = sorted(axis.get_view_interval())
    near = 1e-9 * (high - low)
    texts = axis.get_major_formatter().format_ticks(places)
    size = float(mpl.rcParams["ytick.labelsize"])
    seen = {text for place, text in zip(places, texts, strict=True) if low - near <= place <= high + near}
    return max((text_width(text, size) for text in seen), default=0.0)


def title_room() -> float:
    """Returns the height of a panel's title above it [in]."""
    return line_height(mpl.rcParams["axes.titlesize"]) + float(mpl.rcParams["axes.titlepad"]) / 72


def number_room(numbers: float) -> float:
    """Returns the width that numbers so wide take up beside a panel, and its ticks [in]."""
    return numbers + float(mpl.rcParams["ytick.major.size"] + mpl.rcParams["ytick.major.pad"]) / 72


def label_room(numbers: float) -> float:
    """Returns the width that a vertical axis takes up beside its panel, with numbers so wide [in]."""
    return _to_label(numbers) + line_height(mpl.rcParams["axes.labelsize"])


def axis_room(*, labelled: bool = True) -> float:
    """Returns the height that a horizontal axis takes up below its panel, with or without a label [in]."""
    numbers = line_height(mpl.rcParams["xtick.labelsize"])
    return label_room(numbers) if labelled else number_room(numbers)


def _to_label(numbers: float) -> float:
    """Returns how far the label of an axis is from its panel, beyond numbers of so much room [in]."""
    return number_room(numbers) + float(mpl.rcParams["axes.labelpad"]) / 72


def place_panel(axes: Axes, box: Box) -> None:
    """Puts a panel where it belongs in its figure, whose size stays."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    width, height = figure.get_size_inches()
    axes.set_position((box.left / width, box.bottom / height, box.width / width, box.height / height))


def place_labels(axes: Axes, box: Box, numbers: float) -> None:
    """Puts the labels of a panel's axes at their distances from it, whatever its numbers turn out to be.

    Args:
        axes: a panel with its labels.
        box: where it stands.
        numbers: room for the numbers of its vertical axis [in], the same in panels whose labels are to align.
    """
    axes.yaxis.set_label_coords(-_to_label(numbers) / box.width, 0.5)
    axes.xaxis.set_label_coords(0.5, -_to_label(line_height(mpl.rcParams["xtick.labelsize"])) / box.height)


def shortened(text: str, size: float, room: float) -> str:
    """Returns a text that is no wider than the room [in], with an ellipsis where letters had to go."""
    kept = text
    while len(kept) > 2 and text_width(kept, size) > room:
        kept = f"{kept[:-2]}…"
    return kept


def _power(exponent: int) -> str:
    """Returns a power of ten, in letters that need no formula."""
    return f"10{str(exponent).translate(_SUPERSCRIPTS)}"


class Decades(Formatter):
    """The numbers of a logarithmic axis: powers of ten."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Returns a power of ten as text."""
        return _power(round(float(np.log10(x)))) if x > 0 else ""


class Numbers(Formatter):
    """The numbers of a linear axis, with as many decimals as its steps ask for.

    Very large and very small ones have their power of ten with them: at the axis' end it would run into the title.
    """

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Returns a single number as text."""
        return self.format_ticks([x])[0]

    def format_ticks(self, values: Iterable[float]) -> list[str]:
        """Returns the numbers of an axis as texts."""
        places = np.array(list(values), dtype=float)
        largest = float(np.abs(places).max(initial=0.0))
        order = math.floor(math.log10(largest)) if largest else 0
        power = order if abs(order) >= _PLAIN else 0
        scaled = places / 10.0**power
        near = 1e-3 * float(np.diff(np.sort(scaled)).min(initial=10.0))
        rounded = (scaled.round(decimals) for decimals in range(_DECIMALS))
        misses = (float(np.abs(scaled - each).max(initial=0.0)) for each in rounded)
        decimals = next((decimals for decimals, miss in enumerate(misses) if miss <= near), _DECIMALS)
        unit = f"\N{MULTIPLICATION SIGN}{_power(power)}" if power else ""
        texts = [f"{value + 0.0:.{decimals}f}".replace("-", "\N{MINUS SIGN}") for value in scaled.round(decimals)]
        return [f"{text}{unit}" if value else "0" if unit else text for value, text in zip(places, texts, strict=True)]
