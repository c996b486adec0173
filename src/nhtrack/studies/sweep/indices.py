"""Sobol indices of a sweep: which share of a metric's variance comes from which of its axes."""

from __future__ import annotations

import warnings

import numpy as np
import pandas as pd

from nhtrack.config.sweep import Sweep, group_size
from nhtrack.studies.sweep.result import SweepResults

_FEWEST = 8  # groups from which indices are reckoned
_RESAMPLES, _FEWEST_RESAMPLES, _RESAMPLED = 100, 20, 3e6  # of the groups, for the intervals; groups of all of them
NEED = "Sobol indices need sample: {method: saltelli, count: ...}"


def sobol_indices(results: SweepResults) -> pd.DataFrame:
    """Returns the Sobol indices of each metric, a row for every axis, with the half widths of their 95 % intervals.

    The first index S1 is the share of a metric's variance that an axis brings by itself, the total one ST the share
    that is gone with it; the variance is over the axes' distributions, one with values having each equally often. Of
    repetitions it is the mean that counts. Groups of points in which a run has no value are left out (`left_out`).

    Columns: metric, axis, S1, S1_conf, ST, ST_conf, groups, left_out. None where the sample is not `saltelli`, fewer
    than eight groups are left, or a metric is constant.
    """
    sweep, rows = results.sweep, list[dict[str, object]]()
    if sweep.sample is not None and sweep.sample.method == "saltelli":
        runs = results.runs.set_index("run").reindex(np.arange(sweep.runs))
        for metric in results.metrics:
            rows += _indices_of(sweep, metric, runs[metric].to_numpy(dtype=float))
    return pd.DataFrame(rows, columns=["metric", "axis", "S1", "S1_conf", "ST", "ST_conf", "groups", "left_out"])


def _indices_of(sweep: Sweep, metric: str, values: np.ndarray) -> list[dict[str, object]]:
    """Returns the rows of a metric, whose values are in order of the runs."""
    assert sweep.sample is not None
    axes = len(sweep.axes)
    groups = values.reshape(sweep.points, sweep.repeats).mean(axis=1).reshape(-1, group_size("saltelli", axes))
    whole = groups[np.isfinite(groups).all(axis=1)]
    if len(whole) < _FEWEST or np.ptp(whole) <= 1e-12 * np.abs(whole).max():
        return []
    from SALib.analyze.sobol import analyze  # only here: it takes a second to import

    cube = {"num_vars": axes, "names": [*sweep.axes], "bounds": [[0.0, 1.0]] * axes}
    resamples = int(min(_RESAMPLES, max(_FEWEST_RESAMPLES, _RESAMPLED // len(whole))))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of resamples in which all values are the same
        found = analyze(cube, whole.reshape(-1), calc_second_order=False, num_resamples=resamples, seed=1)
    told = {"metric": metric, "groups": len(groups), "left_out": len(groups) - len(whole)}
    names = ("S1", "S1_conf", "ST", "ST_conf")
    return [
        {**told, "axis": axis, **{name: float(found[name][place]) for name in names}}
        for place, axis in enumerate(sweep.axes)
    ]
