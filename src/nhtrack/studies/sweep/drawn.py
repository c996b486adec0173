"""What the page of a sweep draws: of all runs maps and quantiles, and those runs that can be chosen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd

from nhtrack.arrays import Array
from nhtrack.config.changes import value_text
from nhtrack.config.sweep import Spread, Sweep
from nhtrack.presentation.thinned import even_rows
from nhtrack.report.downsample import numbers
from nhtrack.studies.sweep.front import all_fronts
from nhtrack.studies.sweep.look import goes_by_factors, is_logarithmic
from nhtrack.studies.sweep.result import SweepResults

DIGITS = 5  # significant digits of what is drawn
MOST_RUNS_SHOWN = 20_000
MOST_NUMBERS = 300_000  # of all runs that are shown together: three megabytes
_MOST_OF_A_FRONT = 300
_CELL_NUMBERS = 250_000  # of all maps together
_CELLS, _BINS = 100, 24  # of a map along an axis with values, along one that is drawn; at most
_QUANTILES = (0.05, 0.5, 0.95)


@dataclass(frozen=True)
class Drawn:
    """What the page's scripts draw, and how much of the sweep it is.

    Attributes:
        data: ready for JSON.
        shown: how many runs can be chosen.
        grouped: whether cells of maps are of several values of an axis.
    """

    data: dict[str, Any]
    shown: int
    grouped: bool


def drawn(results: SweepResults) -> Drawn:
    """Returns what the page of a sweep draws."""
    completed, metrics = results.completed.reset_index(drop=True), results.known
    fronts = dict(all_fronts(completed, metrics))
    rows = shown_rows(completed, metrics, list(fronts.values()), len(results.sweep.axes))
    shown, most = completed.iloc[rows], _cells_of(len(metrics), len(results.varied))
    maps = [_map(results.sweep, completed, metrics, pair, most) for pair in combinations(results.varied, 2)]
    for each in maps:
        each["runs"] = each["runs"][rows].tolist()
    data = {
        "axes": [_axis(results.sweep, key, varied=key in results.varied) for key in results.sweep.axes],
        "metrics": [_metric(completed, name) for name in metrics],
        "completed": len(completed),
        "rows": _rows(results.sweep, shown, metrics),
        "maps": maps,
        "curves": [_curves(results.sweep, completed, metrics, key) for key in results.sweep.axes],
        "fronts": [_front(rows, metrics, pair, front) for pair, front in fronts.items()],
        "pairs": [[metrics.index(name) for name in pair] for pair in results.sweep.pareto if {*pair} <= {*metrics}],
    }
    return Drawn(data, len(shown), any(each.pop("grouped") for each in maps))


def shown_rows(completed: pd.DataFrame, metrics: Sequence[str], fronts: Sequence[Array], axes: int) -> Array:
    """Returns the rows of runs that can be chosen, all of them where they are few enough.

    Of more there are the smallest and the largest of each metric, the fronts of each pair of them, and a random sample.
    """
    most = min(MOST_RUNS_SHOWN, MOST_NUMBERS // max(1, axes + len(metrics)))
    if len(completed) <= most:
        return np.arange(len(completed))
    values = {name: completed[name].to_numpy(dtype=float) for name in metrics}
    wanted = [place(each) for each in values.values() for place in (np.nanargmin, np.nanargmax)]
    for front in fronts:
        wanted += front[even_rows(len(front), _MOST_OF_A_FRONT)].tolist()
    first = np.unique(wanted).astype(np.intp)
    rest = np.setdiff1d(np.arange(len(completed)), first)
    room = max(0, most - len(first))
    return np.sort(np.concatenate([first, np.random.default_rng(0).choice(rest, min(room, len(rest)), replace=False)]))


def _axis(sweep: Sweep, key: str, *, varied: bool) -> dict[str, Any]:
    """Returns an axis: of one with values what they are called, and what a command has for them."""
    values, labels = sweep.values(key), sweep.labels(key) if sweep.values(key) else ()
    named = bool(labels) and isinstance(labels[0], str)
    return {
        "key": key,
        "factors": goes_by_factors(sweep, key),
        "varied": varied,
        "names": list(labels) if named else None,
        "values": None if named or not labels else [float(label) for label in labels],
        "texts": [value_text(value) for value in values] or None,
    }


def _metric(completed: pd.DataFrame, name: str) -> dict[str, Any]:
    from nhtrack.studies.sweep.screen import unit_of

    values = completed[name].to_numpy(dtype=float)
    return {"name": name, "unit": unit_of(name).replace("^2", "²"), "factors": is_logarithmic(values)}


def _rows(sweep: Sweep, shown: pd.DataFrame, metrics: Sequence[str]) -> dict[str, Any]:
    """Returns runs that can be chosen: numbers as they are drawn, values drawn at random as texts with all digits."""
    axes = [
        [value_text(float(value)) for value in shown[key]]
        if isinstance(axis, Spread)
        else places_of(sweep, key, shown[key]).tolist()
        for key, axis in sweep.axes.items()
    ]
    return {
        "run": shown["run"].tolist(),
        "seed": shown["seed"].tolist() if sweep.repeats > 1 else None,
        "axes": axes,
        "metrics": [numbers(shown[name].to_numpy(dtype=float), DIGITS) for name in metrics],
    }


def _front(rows: Array, metrics: Sequence[str], pair: tuple[str, str], front: Array) -> dict[str, Any]:
    """Returns a front: its two metrics, where its runs are among those that can be chosen, and how many it has."""
    places = np.searchsorted(rows, front).clip(0, len(rows) - 1)
    held = places[rows[places] == front]
    return {"metrics": [metrics.index(name) for name in pair], "rows": held.tolist(), "of": len(front)}


def places_of(sweep: Sweep, key: str, column: pd.Series) -> Array:
    """Returns the places among the values of an axis that a column of the table has."""
    return np.asarray(pd.Index(list(sweep.labels(key))).get_indexer(column.to_numpy()))


# Maps and curves of all runs ------------------------------------------------------------------------------------------


def _cells_of(metrics: int, axes: int) -> int:
    """Returns how many cells a map has along an axis, at most."""
    maps = max(1, metrics * axes * (axes - 1) // 2)
    return int(np.clip(np.sqrt(_CELL_NUMBERS / maps), 8, _CELLS))


def _map(
    sweep: Sweep, completed: pd.DataFrame, metrics: Sequence[str], pair: tuple[str, str], most: int
) -> dict[str, Any]:
    """Returns the medians of every metric over two axes, shape (rows, columns) each, and the cell of every run."""
    (up, rows, rows_grouped), (across, columns, columns_grouped) = (
        _cells(sweep, key, completed[key], most) for key in pair
    )
    cell = up * len(columns) + across
    medians = completed[list(metrics)].groupby(cell).median().reindex(range(len(rows) * len(columns)))
    shape = (len(rows), len(columns))
    return {
        "axes": [list(sweep.axes).index(key) for key in pair],
        "rows": rows,
        "columns": columns,
        "values": [numbers(medians[name].to_numpy(dtype=float).reshape(shape), DIGITS) for name in metrics],
        "runs": cell,
        "grouped": rows_grouped or columns_grouped,
    }


def _cells(sweep: Sweep, key: str, column: pd.Series, most: int) -> tuple[Array, list[str], bool]:
    """Returns in which cell of an axis each run is, what cells are called, and whether they are of several values."""
    if not isinstance(sweep.axes[key], Spread):
        labels = sweep.labels(key)
        together = -(-len(labels) // most)
        names = [_short(label) for label in labels]
        called = [
            names[i] if together == 1 else f"{names[i]} to {names[min(i + together, len(names)) - 1]}"
            for i in range(0, len(names), together)
        ]
        return places_of(sweep, key, column) // together, called, together > 1
    values = column.to_numpy(dtype=float)
    scaled = np.log(values) if goes_by_factors(sweep, key) else values
    count = min(_BINS, most)
    edges = np.linspace(scaled.min(), scaled.max(), count + 1)
    middles = (edges[1:] + edges[:-1]) / 2
    called = [_short(float(value)) for value in (np.exp(middles) if goes_by_factors(sweep, key) else middles)]
    return np.digitize(scaled, edges[1:-1]), called, True


def _curves(sweep: Sweep, completed: pd.DataFrame, metrics: Sequence[str], key: str) -> dict[str, Any]:
    """Returns quantiles of every metric over an axis, at its values or in cells of as many runs each."""
    if isinstance(sweep.axes[key], Spread):
        places = completed[key].to_numpy(dtype=float)
        cells = np.asarray(pd.qcut(places, min(_BINS, max(1, len(places) // 8)), labels=False, duplicates="drop"))
    else:
        cells = places_of(sweep, key, completed[key])
        places = cells if isinstance(sweep.labels(key)[0], str) else completed[key].to_numpy(dtype=float)
    found = completed[list(metrics)].groupby(cells).quantile(list(_QUANTILES)).unstack()
    at = pd.Series(places).groupby(cells).median()
    keep = even_rows(len(at), _CELLS)
    return {
        "x": numbers(at.to_numpy(dtype=float)[keep], DIGITS),
        "metrics": [
            [numbers(found[name, quantile].to_numpy(dtype=float)[keep], DIGITS) for quantile in _QUANTILES]
            for name in metrics
        ],
    }


def _short(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else value_text(value)
