"""A run as far as it can be drawn: of a large recording the rows that hold the extremes, read a block at a time."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from nhtrack.analysis.metrics import mean_loads
from nhtrack.arrays import row_blocks
from nhtrack.presentation.shown import CROWD
from nhtrack.recording import Recording
from nhtrack.recording.reading import LARGE

__all__ = ["even_rows", "extreme_rows", "thinned"]

_DRAWN = 300_000  # rows of all robots together that are drawn of a large recording
_BLOCK = 2**25  # bytes that are read at a time
_PLACES = ("pose", "ideal_pose", "leader_pose", "touch", "qpos", "time")  # without peaks to be kept


def thinned(recording: Recording, at: np.ndarray | None = None) -> Recording:
    """Returns a recording whose curves look the same, in memory: itself, unless it is large.

    Of a large one there are rows evenly spread, and those in which a variable of some robot, or of the crowd, is
    smallest or largest of its stretch; `rows` says how many the run has. Wheel loads are means (`mean_loads`).

    Args:
        recording: the run.
        at: times [s] before and after which rows must be kept.
    """
    if recording.dataset.nbytes <= LARGE:
        return recording
    time, most = recording.time, _DRAWN // len(recording.robots)
    after = np.searchsorted(time, np.empty(0) if at is None else at).clip(1, len(time) - 1)
    wanted = np.unique(np.concatenate([after - 1, after]))
    parts = list(_parts(recording, wanted, most / len(time)))
    dataset = recording.dataset.drop_dims("time")
    found = {
        name: (variable.dims, np.concatenate([part[str(name)] for part in parts]), variable.attrs)
        for name, variable in recording.dataset.variables.items()
        if "time" in variable.dims
    }
    return Recording(dataset.assign(found).assign_attrs(rows=len(time)))


def _parts(recording: Recording, wanted: np.ndarray, share: float) -> Iterator[dict[str, np.ndarray]]:
    """Yields the rows that are kept, block by block, by the names of variables."""
    dataset, time = recording.dataset, recording.time
    names = [str(name) for name, variable in dataset.variables.items() if "time" in variable.dims]
    for part in row_blocks(len(time), dataset.nbytes, _BLOCK):
        values = {name: dataset[name][part].values for name in names}
        if "wheel_load" in values:
            values["wheel_load"] = mean_loads(recording, part)
        count, most = part.stop - part.start, int(share * (part.stop - part.start))
        peaks = extreme_rows(_curves(values), most // 2)
        inside = wanted[(wanted >= part.start) & (wanted < part.stop)] - part.start
        rows = np.unique(np.concatenate([even_rows(count, max(most // 2, 2)), peaks, inside]))
        yield {name: each[rows] for name, each in values.items()}


def _curves(values: dict[str, np.ndarray]) -> np.ndarray:
    """Returns the largest magnitudes of every variable of each robot, or of a crowd, shape (t, curves)."""
    sizes = [
        np.abs(each).reshape(*each.shape[:2], -1).max(axis=-1) for name, each in values.items() if name not in _PLACES
    ]
    if sizes[0].shape[1] - 1 > CROWD:
        sizes = [np.fmax.reduce(each, axis=1, keepdims=True) for each in sizes]
    return np.concatenate(sizes, axis=1)


def even_rows(count: int, most: int) -> np.ndarray:
    """Returns at most `most` rows of `count`, evenly spread, the first and the last among them."""
    if count <= most:
        return np.arange(count)
    return np.unique(np.linspace(0, count - 1, most).round().astype(np.intp))


def extreme_rows(values: np.ndarray, most: int) -> np.ndarray:
    """Returns the rows in which curves have the extremes of their stretch, so that no peak is lost.

    The rows are cut into stretches of equal length; of each, every curve's smallest and largest value stay, and so do
    the first row, the last row and the rows where values begin or cease to be known.

    Args:
        values: one column a curve, shape (t, k); NaN where a value is not known.
        most: rows to stay below, apart from where values begin or cease to be known.

    Returns:
        Rows in ascending order, all of them where there are no more than `most`.
    """
    count, curves = values.shape
    if count <= most:
        return np.arange(count)
    stretches = max(1, (most - 2) // (2 * curves))
    kept = [0, count - 1]
    for rows in np.array_split(np.arange(count), stretches):
        part = values[rows]
        kept += (rows[0] + np.where(np.isnan(part), np.inf, part).argmin(axis=0)).tolist()
        kept += (rows[0] + np.where(np.isnan(part), -np.inf, part).argmax(axis=0)).tolist()
    turns = np.flatnonzero(np.diff(np.isnan(values).any(axis=1)))
    return np.unique(np.concatenate([kept, turns, turns + 1])).astype(np.intp)
