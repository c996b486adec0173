"""Figures of a sweep: a map over two axes, curves over one, and every axis by itself."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from nhtrack.colours import INK
from nhtrack.config.sweep import Spread, Sweep
from nhtrack.files.names import file_names
from nhtrack.plots.files import save_figure
from nhtrack.plots.style import plain, styled
from nhtrack.studies.sweep.indices import sobol_indices
from nhtrack.studies.sweep.look import (
    MAP,
    dots_of,
    goes_by_factors,
    head,
    is_logarithmic,
    lay_axis,
    norm_of,
    ticks_of,
    title_of,
)
from nhtrack.studies.sweep.relations import sweep_front, sweep_indices, sweep_matrix
from nhtrack.studies.sweep.result import SweepResults
from nhtrack.studies.sweep.screen import figure_text, unit_of

_PANEL = (2.5, 2.1)  # [in] of a panel
_WRITTEN = 150  # cells of a map in which numbers are written


@styled
def save_sweep_figures(results: SweepResults, folder: Path, *, pdf: bool = False) -> list[Path]:
    """Writes the figures of a sweep.

    Of every metric `map_<metric>` where two axes are combined, else `axes_<metric>`; `matrix`, all metrics over all
    axes; `front_<metric>_<metric>` of every pair of `pareto`; `indices`, where the sample is one for Sobol indices.
    """
    written = []
    for name, figure in _figures(results):
        written += save_figure(figure, folder / name, pdf=pdf, title=f"{results.sweep.name}: {name.replace('_', ' ')}")
    return written


def _figures(results: SweepResults) -> Iterator[tuple[str, Figure]]:
    """Yields the figures with their names; one is drawn while none before it is still held."""
    sweep, varied = results.sweep, results.varied
    known = results.known
    if not varied or not known:
        return
    stems = file_names(results.metrics)
    for metric in known:
        yield f"{'map' if results.mapped else 'axes'}_{stems[metric]}", figure_of(results, metric)
    differing = [metric for metric in known if results.completed[metric].nunique() > 1]
    if len(varied) > 1 and len(differing) > 1:
        yield "matrix", sweep_matrix(results, differing)
    for one, other in sweep.pareto:
        if results.completed[[one, other]].notna().all(axis=1).any():
            yield f"front_{stems[one]}_{stems[other]}", sweep_front(results, one, other)
    indices = sobol_indices(results)
    if len(indices):
        yield "indices", sweep_indices(indices)


def figure_of(results: SweepResults, metric: str) -> Figure:
    """Returns the figure of a metric: maps where two or three axes are combined, else it over each axis by itself."""
    if results.mapped:
        return sweep_map(results, metric, *results.mapped)
    return sweep_axes(results, metric, results.varied)


@styled
def sweep_map(results: SweepResults, metric: str, up: str, across: str, aside: str | None = None) -> Figure:
    """Returns a metric over two axes, medians of the repetitions; grey where no run completed.

    Args:
        results: of a sweep that combines all values.
        metric: a column of its table.
        up: the axis that is drawn upwards.
        across: the other.
        aside: an axis of whose values each has a panel.
    """
    sweep, completed = results.sweep, results.completed
    panels: dict[Any, pd.DataFrame] = {"": completed}
    if aside is not None:
        panels = {label: completed[completed[aside] == label] for label in sweep.labels(aside)}
    rows, columns = len(sweep.labels(up)), len(sweep.labels(across))
    width, height = min(7.0, 0.8 + 0.42 * columns), min(8.0, max(2.8, 1.4 + 0.34 * rows))
    figure = Figure(figsize=(max(4.2, 1.6 + width * len(panels)), height))
    norm = norm_of(completed[metric].to_numpy(dtype=float))
    drawn = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    for axes, (label, part) in zip(drawn, panels.items(), strict=True):
        table = part.pivot_table(metric, up, across, "median", sort=False)
        table = table.reindex(index=list(sweep.labels(up)), columns=list(sweep.labels(across)))
        _draw_map(axes, sweep, table, norm, metric)
        axes.set_xlabel(plain(across))
        axes.set_title("" if aside is None else plain(f"{aside}: {label}"), fontsize=8.5)
    drawn[0].set_ylabel(plain(up))
    bar = figure.colorbar(ScalarMappable(norm, MAP), ax=list(drawn), aspect=22, pad=0.02)
    bar.outline.set_linewidth(0.0)
    bar.ax.grid(False)
    head(figure, title_of(metric))
    return figure


def _draw_map(axes: Axes, sweep: Sweep, table: pd.DataFrame, norm: Normalize, metric: str) -> None:
    """Draws the values of a metric over two axes of a sweep, in cells."""
    up, across = str(table.index.name), str(table.columns.name)
    axes.set_facecolor("#DADADA")
    values = np.ma.masked_invalid(table.to_numpy(dtype=float))
    axes.pcolormesh(values, cmap=MAP, norm=norm, rasterized=True)
    if values.size <= _WRITTEN:
        _write_values(axes, values, norm, unit_of(metric))
    axes.set_xticks(*ticks_of(table.columns, factors=goes_by_factors(sweep, across)))
    axes.set_yticks(*ticks_of(table.index, factors=goes_by_factors(sweep, up)))
    axes.tick_params(length=0)
    axes.grid(False)
    for spine in axes.spines.values():
        spine.set_visible(False)


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
    for axes in panels.flat[len(varied) :]:
        axes.remove()
    for key, axes in zip(varied, panels.flat, strict=False):
        _draw_axis(axes, results.sweep, key, known, metric)
        if is_logarithmic(known[metric].to_numpy(dtype=float)):
            axes.set_yscale("log")
    head(figure, title_of(metric))
    return figure


def _draw_axis(axes: Axes, sweep: Sweep, key: str, known: pd.DataFrame, metric: str) -> None:
    """Draws a metric over one axis."""
    place, (shown, size, look) = lay_axis(axes, sweep, key), dots_of(known)
    axes.set_xlabel(plain(key))
    named = isinstance(known[key].iloc[0], str)
    spread = np.random.default_rng(0).uniform(-0.12, 0.12, len(shown)) if named else 0.0  # dots hide each other less
    axes.scatter(place(shown[key]) + spread, shown[metric], size, **look)
    of = pd.qcut(known[key], 12, duplicates="drop") if isinstance(sweep.axes[key], Spread) else place(known[key])
    groups = known.assign(place=place(known[key])).groupby(of, observed=True)
    medians = groups[["place", metric]].median()
    line: dict[str, Any] = {"linestyle": "-", "marker": "o", "markersize": 3}
    line = {"linestyle": "", "marker": "_", "markersize": 22} if named else line
    axes.plot(medians["place"], medians[metric].to_numpy(), color=INK, linewidth=1.4, **line)


def _write_values(axes: Axes, values: np.ma.MaskedArray, norm: Normalize, unit: str) -> None:
    for (row, column), value in np.ndenumerate(values):
        if value is not np.ma.masked:
            dark = float(norm(value)) < 0.55
            axes.text(
                column + 0.5, row + 0.5, figure_text(float(value), unit), ha="center", va="center", fontsize=6.5,
                color="white" if dark else "black",
            )  # fmt: skip
