"""How figures of a sweep look: scales, ticks, titles, and an axis of the sweep as one of a drawing."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from nhtrack.colours import FOLLOWERS, INK
from nhtrack.config.grid import Range
from nhtrack.config.sweep import LogUniform, Sweep
from nhtrack.plots.style import plain
from nhtrack.studies.sweep.screen import unit_of

MAP = "viridis"  # read by colour-blind eyes, and in a grey print
DOTS = 20_000  # runs drawn; of more, every so many
_WIDE = 3.2  # decades from which on colours and axes are logarithmic: else the small values are all one
_MOST_TICKS = 9
_FEW_VALUES = 5  # of an axis, each with a tick of its own


def norm_of(values: np.ndarray) -> Normalize:
    """Returns the scale of colours or heights: logarithmic where values differ by more than decades."""
    known = np.ma.compressed(np.ma.masked_invalid(values))
    low, high = float(known.min()), float(known.max())
    if low > 0 and math.log10(high / low) > _WIDE:
        return LogNorm(low, high)
    return Normalize(low, high if high > low else low + 1.0)


def is_logarithmic(values: np.ndarray) -> bool:
    """Returns whether values are shown on a logarithmic scale."""
    return isinstance(norm_of(values), LogNorm)


def goes_by_factors(sweep: Sweep, key: str) -> bool:
    """Returns whether an axis of a sweep is shown on a logarithmic scale."""
    axis = sweep.axes[key]
    return isinstance(axis, LogUniform) or (isinstance(axis, Range) and axis.log)


def dots_of(runs: pd.DataFrame, most: int = DOTS) -> tuple[pd.DataFrame, float, dict[str, Any]]:
    """Returns the runs that are drawn as dots, evenly by their number, the dots' size and their look."""
    shown = runs.iloc[:: max(1, -(-len(runs) // most))]
    size = 14.0 if len(shown) < 200 else 5.0 if len(shown) < 3000 else 2.0
    alpha = 0.35 if len(shown) < 3000 else 0.15
    return shown, size, {"color": FOLLOWERS[0], "linewidths": 0, "rasterized": True, "alpha": alpha}


def lay_axis(axes: Axes, sweep: Sweep, key: str, *, most: int = 3) -> Callable[[pd.Series], Any]:
    """Makes the lower axis of a drawing that of a sweep's axis; returns a function from its values to places.

    Args:
        axes: of the drawing.
        sweep: whose axis it is.
        key: the axis.
        most: names that stand level; of more, all are turned.
    """
    labels = sweep.labels(key) if sweep.values(key) else ()
    if labels and isinstance(labels[0], str):
        places = {label: i for i, label in enumerate(labels)}
        axes.set_xlim(-0.5, len(places) - 0.5)
        names = [plain(str(label)) for label in places]
        axes.set_xticks(range(len(places)), names, rotation=30 if len(places) > most else 0)
        return lambda values: values.map(places)
    if labels and isinstance(sweep.axes[key], tuple) and len(labels) <= _FEW_VALUES:
        axes.set_xticks(labels, [f"{label:.4g}" for label in labels])
        axes.margins(x=0.15)
    if goes_by_factors(sweep, key):
        axes.set_xscale("log")
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.xaxis.set_minor_formatter(NullFormatter())
    return lambda values: values


def ticks_of(labels: pd.Index, *, factors: bool = False) -> tuple[np.ndarray, list[str]]:
    """Returns places and texts of ticks at cells, few enough to be read: of many numbers that rise, at round ones.

    Args:
        labels: of the cells.
        factors: whether they go by factors.
    """
    many = len(labels) > 2 * _MOST_TICKS
    if many and labels.dtype.kind in "fi" and labels.is_monotonic_increasing:
        values, scaled = labels.to_numpy(dtype=float), np.log if factors else np.asarray
        locator = LogLocator(subs=(1.0, 2.0, 5.0)) if factors else MaxNLocator(_MOST_TICKS - 1)
        ticks = np.asarray(locator.tick_values(values[0], values[-1]))
        ticks = ticks[(ticks >= values[0]) & (ticks <= values[-1])]
        places = np.interp(scaled(ticks), scaled(values), np.arange(len(values)) + 0.5)
        return places, [plain(f"{each:.4g}") for each in ticks]
    chosen = np.arange(0, len(labels), -(-len(labels) // _MOST_TICKS) if many else 1)
    return chosen + 0.5, [plain(f"{labels[i]:.4g}" if isinstance(labels[i], float) else str(labels[i])) for i in chosen]


def title_of(metric: str) -> str:
    """Returns what a metric is called in drawings, with its unit."""
    unit = unit_of(metric).replace("^2", "²")
    return metric.replace("_", " ") + (f" [{unit}]" if unit else "")


def head(figure: Figure, text: str) -> None:
    """Writes what a figure shows above it."""
    figure.suptitle(plain(text), x=0.01, ha="left", fontsize=10.5, fontweight="bold", color=INK)
