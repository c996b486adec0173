"""Figures of a sweep: a map over two axes, curves over one, and every axis by itself."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from nhtrack.colours import FOLLOWERS, INK
from nhtrack.config.grid import Range
from nhtrack.config.sweep import LogUniform, Spread, Sweep
from nhtrack.plots.files import save_figure
from nhtrack.plots.style import plain, styled
from nhtrack.studies.sweep.result import SweepResults
from nhtrack.studies.sweep.screen import figure_text, unit_of

_MAP = "viridis"  # read by colour-blind eyes, and in a grey print
_WIDE = 3.2  # decades from which on colours and axes are logarithmic: else the small values are all one
_PANEL = (2.5, 2.1)  # [in] of a panel
_DOTS = 20_000  # runs drawn; of more, every so many
_MOST_TICKS = 9


@styled
def save_sweep_figures(results: SweepResults, folder: Path, *, pdf: bool = False) -> list[Path]:
    """Writes a figure of every metric: `map_<metric>` where two axes are combined, else `axes_<metric>`."""
    written = []
    varied = [key for key in results.sweep.axes if results.runs[key].nunique() > 1]
    for metric in results.metrics:
        if results.completed[metric].notna().any() and varied:
            name, figure = _figure(results, metric, varied)
            written += save_figure(figure, folder / name, pdf=pdf, title=f"{results.sweep.name}: {metric}")
    return written


def _figure(results: SweepResults, metric: str, varied: list[str]) -> tuple[str, Figure]:
    slug = re.sub(r"[^a-z0-9]+", "_", metric.lower()).strip("_")
    if results.sweep.sample is None and len(varied) == 2:
        return f"map_{slug}", sweep_map(results, metric, *varied)
    return f"axes_{slug}", sweep_axes(results, metric, varied)


@styled
def sweep_map(results: SweepResults, metric: str, up: str, across: str) -> Figure:
    """Returns a metric over two axes, medians of the repetitions; grey where no run completed.

    Args:
        results: of a sweep that combines all values.
        metric: a column of its table.
        up: the axis that is drawn upwards.
        across: the other.
    """
    sweep = results.sweep
    table = results.completed.pivot_table(metric, up, across, "median", sort=False)
    table = table.reindex(index=list(sweep.labels(up)), columns=list(sweep.labels(across)))
    rows, columns = table.shape
    figure = Figure(figsize=(min(9.0, max(4.2, 2.4 + 0.42 * columns)), min(8.0, max(2.8, 1.4 + 0.34 * rows))))
    axes = figure.subplots()
    axes.set_facecolor("#DADADA")
    values = np.ma.masked_invalid(table.to_numpy(dtype=float))
    norm = _norm(values)
    axes.pcolormesh(values, cmap=_MAP, norm=norm, rasterized=True)
    if rows * columns <= 150:
        _write_values(axes, values, norm, unit_of(metric))
    axes.set_xticks(*_ticks(table.columns))
    axes.set_yticks(*_ticks(table.index))
    axes.set_xlabel(plain(across))
    axes.set_ylabel(plain(up))
    axes.tick_params(length=0)
    axes.grid(False)
    for spine in axes.spines.values():
        spine.set_visible(False)
    bar = figure.colorbar(ScalarMappable(norm, _MAP), ax=axes, aspect=22, pad=0.02)
    bar.outline.set_linewidth(0.0)
    bar.ax.grid(False)
    figure.suptitle(plain(_title(metric)), x=0.01, ha="left", fontsize=10.5, fontweight="bold", color=INK)
    return figure


@styled
def sweep_axes(results: SweepResults, metric: str, varied: list[str]) -> Figure:
    """Returns a metric over each axis by itself: every run a dot, and the median by value, or of twelfths of the runs.

    Args:
        results: of a sweep.
        metric: a column of its table.
        varied: axes that have more than one value.
    """
    columns = 2 if len(varied) == 4 else min(3, len(varied))
    rows = math.ceil(len(varied) / columns)
    figure = Figure(figsize=(max(4.2, 0.9 + _PANEL[0] * columns), 0.7 + _PANEL[1] * rows))
    panels = figure.subplots(rows, columns, squeeze=False, sharey=True)
    known = results.completed.dropna(subset=[metric])
    shown = known.iloc[:: max(1, -(-len(known) // _DOTS))]
    logarithmic = isinstance(_norm(known[metric].to_numpy(dtype=float)), LogNorm)
    for axes in panels.flat[len(varied) :]:
        axes.remove()
    for key, axes in zip(varied, panels.flat, strict=False):
        _draw_axis(axes, results.sweep, key, known, shown, metric)
        if logarithmic:
            axes.set_yscale("log")
    figure.suptitle(plain(_title(metric)), x=0.01, ha="left", fontsize=10.5, fontweight="bold", color=INK)
    return figure


def _draw_axis(axes: Axes, sweep: Sweep, key: str, known: pd.DataFrame, shown: pd.DataFrame, metric: str) -> None:
    """Draws a metric over one axis."""
    axis, size = sweep.axes[key], 14.0 if len(shown) < 200 else 5.0 if len(shown) < 3000 else 2.0
    look: dict[str, Any] = {"color": FOLLOWERS[0], "linewidths": 0, "rasterized": True}
    look |= {"alpha": 0.35 if len(shown) < 3000 else 0.15}
    axes.set_xlabel(plain(key))
    if isinstance(known[key].iloc[0], str):
        places = {label: i for i, label in enumerate(sweep.labels(key))}
        spread = np.random.default_rng(0).uniform(-0.12, 0.12, len(shown))  # so that dots do not hide each other
        axes.scatter(shown[key].map(places) + spread, shown[metric], size, **look)
        axes.set_xlim(-0.5, len(places) - 0.5)
        medians = known.groupby(known[key].map(places))[metric].median()
        names = [plain(str(label)) for label in places]
        axes.set_xticks(range(len(places)), names, rotation=30 if len(places) > 3 else 0)
    else:
        axes.scatter(shown[key], shown[metric], size, **look)
        of = pd.qcut(known[key], 12, duplicates="drop") if isinstance(axis, Spread) else known[key]
        groups = known.groupby(of, observed=True)
        medians = pd.Series(groups[metric].median().to_numpy(), index=groups[key].median().to_numpy())
        if isinstance(axis, LogUniform) or (isinstance(axis, Range) and axis.log):
            axes.set_xscale("log")
            axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axes.xaxis.set_minor_formatter(NullFormatter())
    ordered = not isinstance(known[key].iloc[0], str)
    line = {"linestyle": "-", "marker": "o", "markersize": 3} if ordered else {"linestyle": "", "marker": "_"}
    axes.plot(medians.index, medians.to_numpy(), color=INK, linewidth=1.4, **({"markersize": 22} | line))


def _norm(values: np.ndarray) -> Normalize:
    """Returns the scale of colours or heights: logarithmic where values differ by more than decades."""
    known = np.ma.compressed(np.ma.masked_invalid(values))
    low, high = float(known.min()), float(known.max())
    if low > 0 and math.log10(high / low) > _WIDE:
        return LogNorm(low, high)
    return Normalize(low, high if high > low else low + 1.0)


def _write_values(axes: Axes, values: np.ma.MaskedArray, norm: Normalize, unit: str) -> None:
    for (row, column), value in np.ndenumerate(values):
        if value is not np.ma.masked:
            dark = float(norm(value)) < 0.55
            axes.text(
                column + 0.5, row + 0.5, figure_text(float(value), unit), ha="center", va="center", fontsize=6.5,
                color="white" if dark else "black",
            )  # fmt: skip


def _ticks(labels: pd.Index) -> tuple[np.ndarray, list[str]]:
    """Returns places and texts of ticks, few enough to be read."""
    every = max(1, -(-len(labels) // _MOST_TICKS)) if len(labels) > 2 * _MOST_TICKS else 1
    chosen = np.arange(0, len(labels), every)
    return chosen + 0.5, [plain(f"{labels[i]:.4g}" if isinstance(labels[i], float) else str(labels[i])) for i in chosen]


def _title(metric: str) -> str:
    unit = unit_of(metric)
    return metric.replace("_", " ") + (f" [{unit}]" if unit else "")
