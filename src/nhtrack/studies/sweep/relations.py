"""Figures of a sweep with several metrics in each: all over all axes, two against each other, and their indices."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nhtrack.colours import FOLLOWERS, INK, ROOT
from nhtrack.plots.style import plain, styled
from nhtrack.presentation.numbers import counted, grouped
from nhtrack.studies.sweep.front import pareto_rows
from nhtrack.studies.sweep.look import dots_of, head, is_logarithmic, lay_axis, title_of
from nhtrack.studies.sweep.result import SweepResults

_CELL = (1.75, 1.25)  # [in] of a panel of the matrix
_MATRIX_DOTS = 60_000  # in all of its panels
_DOT = 7.0  # largest size of a dot in the matrix
_APART = 60.0  # [px] between runs of a front whose numbers are written
_BAR = 0.36  # height of a bar, of 1 that an axis has


@styled
def sweep_matrix(results: SweepResults, metrics: list[str]) -> Figure:
    """Returns the matrix of metrics over axes, every run a dot.

    Args:
        results: of a sweep.
        metrics: columns of its table, one a row of the matrix.
    """
    varied, completed = results.varied, results.completed
    rows, columns = len(metrics), len(varied)
    figure = Figure(figsize=(1.1 + _CELL[0] * columns, 0.7 + _CELL[1] * rows))
    panels = figure.subplots(rows, columns, squeeze=False, sharex="col", sharey="row")
    most = max(300, _MATRIX_DOTS // (rows * columns))
    for metric, line in zip(metrics, panels, strict=True):
        known = completed.dropna(subset=[metric])
        shown, size, look = dots_of(known, most)
        for key, axes in zip(varied, line, strict=True):
            place = lay_axis(axes, results.sweep, key, most=2)
            axes.scatter(place(shown[key]), shown[metric], min(size, _DOT), **look)
        if is_logarithmic(known[metric].to_numpy(dtype=float)):
            line[0].set_yscale("log")
        line[0].set_ylabel(plain(title_of(metric).replace(" [", "\n[")), fontsize=7.5)
    for key, axes in zip(varied, panels[-1], strict=True):
        axes.set_xlabel(plain(key), fontsize=8)
    figure.align_ylabels(list(panels[:, 0]))
    head(figure, "metrics over axes")
    return figure


@styled
def sweep_front(results: SweepResults, one: str, other: str) -> Figure:
    """Returns two metrics of every run, and the front of those that none beats in both, with numbers of some runs.

    Args:
        results: of a sweep.
        one: a column of its table, the smaller the better.
        other: likewise.
    """
    known = results.completed.dropna(subset=[one, other])
    front = known.iloc[pareto_rows(known[one].to_numpy(dtype=float), known[other].to_numpy(dtype=float))]
    figure = Figure(figsize=(5.2, 3.9))
    axes = figure.subplots()
    shown, size, look = dots_of(known)
    axes.scatter(shown[one], shown[other], size, **look)
    axes.step(front[one], front[other], where="post", color=ROOT, linewidth=1.3)
    axes.plot(front[one], front[other], linestyle="", marker="o", markersize=4, color=ROOT)
    for name, scale, write in ((one, axes.set_xscale, axes.set_xlabel), (other, axes.set_yscale, axes.set_ylabel)):
        if is_logarithmic(known[name].to_numpy(dtype=float)):
            scale("log")
        write(plain(title_of(name)))
    _name_some(axes, front, one, other)
    head(figure, f"front of {counted(len(front), 'run')} of {grouped(len(known))}")
    return figure


def _name_some(axes: Axes, front: pd.DataFrame, one: str, other: str) -> None:
    """Writes the numbers of runs of a front, of those that stand too near to each other only the first."""
    axes.autoscale_view()  # else it is put off until the figure is drawn
    places = axes.transData.transform(front[[one, other]].to_numpy(dtype=float))
    last = np.full(2, -np.inf)
    for run, at, place in zip(front["run"], front[[one, other]].to_numpy(), places, strict=True):
        if np.abs(place - last).max() > _APART:
            axes.annotate(f"run {run}", at, (5, 4), textcoords="offset points", fontsize=7, color=INK)
            last = place


@styled
def sweep_indices(indices: pd.DataFrame) -> Figure:
    """Returns the Sobol indices of every metric, first and total, with their 95 % intervals.

    Args:
        indices: see `nhtrack.studies.sweep.indices.sobol_indices`.
    """
    groups = list(indices.groupby("metric", sort=False))
    columns = min(3, len(groups))
    rows, axes_each = math.ceil(len(groups) / columns), len(groups[0][1])
    figure = Figure(figsize=(max(4.6, 1.6 + 2.2 * columns), 0.9 + rows * (0.75 + 0.34 * axes_each)))
    panels = figure.subplots(rows, columns, squeeze=False, sharey=True, sharex=True)
    for axes in panels.flat[len(groups) :]:
        axes.remove()
    for (metric, part), axes in zip(groups, panels.flat, strict=False):
        places = np.arange(len(part))
        for name, shift, colour in (("S1", -0.5, FOLLOWERS[0]), ("ST", 0.5, FOLLOWERS[3])):
            bars = {"xerr": part[f"{name}_conf"], "error_kw": {"elinewidth": 0.9, "ecolor": INK}}
            axes.barh(places + _BAR * shift, part[name], _BAR, color=colour, label=_KINDS[name], **bars)
        axes.set_title(plain(str(metric).replace("_", " ")), fontsize=8.5)
        axes.set_yticks(places, [plain(key) for key in part["axis"]])
        axes.grid(axis="y", visible=False)
    panels[0, 0].invert_yaxis()
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside lower right", ncols=2)
    head(figure, "shares of the variance, with 95 % intervals")
    return figure


_KINDS = {"S1": "of the axis by itself", "ST": "with all that it does together with others"}
