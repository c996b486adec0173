"""Metrics of runs side by side, as a run's summary has them, of the worst robot of each."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from nhtrack.arrays import Array
from nhtrack.config.grid import words_of
from nhtrack.references import ReferenceInputError, value_of
from nhtrack.studies.sweep.batch import Figures


def _worst(figures: Figures, values: Array, *, bodies: bool = False) -> Array:
    """Returns the largest value of the followers of each run, or of all robots with wheels, shape (b, n) -> (b,)."""
    return np.asarray(values[:, figures.bodies if bodies else 1 :].max(axis=1))


def metrics_of(figures: Figures) -> Mapping[str, Array]:
    """Returns the metrics of `nhtrack.config.sweep.METRICS` of runs side by side, shape (b,); unknown ones NaN."""
    held, periods, lost = figures.statistics, figures.periods, figures.lost
    settled = (held.settled[:, 1:] <= figures.late) & ~lost[:, None]
    rms = np.sqrt(held.gap_2 / (periods + 1))
    known = {
        "initial_position_error": _worst(figures, held.first[..., 0]),
        "final_position_error": _worst(figures, held.last[..., 0]),
        "final_heading_error": _worst(figures, held.last[..., 1]),
        "late_position_error": _worst(figures, held.late[..., 0]),
        "late_heading_error": _worst(figures, held.late[..., 1]),
        "path_length": _worst(figures, held.path, bodies=True),
        "peak_utilisation": _worst(figures, held.utilisation, bodies=True),
        "peak_lateral_slip": _worst(figures, held.slip, bodies=True),
        "torque_saturation_share": _worst(figures, held.saturated, bodies=True) / (periods + 1),
        "effort_x": _worst(figures, np.sqrt(held.effort[..., 0] / periods)),
        "effort_theta": _worst(figures, np.sqrt(held.effort[..., 1] / periods)),
        "switches": _worst(figures, held.switches).astype(float),
    }
    gaps = {
        "gap_position_rms": _worst(figures, rms[..., 0], bodies=True),
        "gap_position_max": _worst(figures, held.gap[..., 0], bodies=True),
        "gap_heading_rms": _worst(figures, rms[..., 1], bodies=True),
        "gap_heading_max": _worst(figures, held.gap[..., 1], bodies=True),
    }
    last = held.settled[:, 1:].max(axis=1) * figures.dt
    return {
        "settled": settled.mean(axis=1),
        "settling_time": np.where(settled.all(axis=1), last, np.nan),
        **{name: np.where(lost, np.nan, values) for name, values in known.items()},
        **{name: np.where(lost | ~figures.twins, np.nan, values) for name, values in gaps.items()},
    }


def expression_value(formula: str, metrics: Mapping[str, float]) -> float:
    """Returns the value of a formula of metrics; NaN where one in it is not known, or it has none."""
    used = {name: metrics[name] for name in words_of(formula) if name in metrics}
    if not all(map(np.isfinite, used.values())):
        return np.nan
    try:
        return value_of(formula, used)
    except ReferenceInputError:
        return np.nan
