"""Numbers that say how a run went, read from its recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any, NamedTuple

import numpy as np

from nhtrack.analysis.event import Event, first_touch
from nhtrack.analysis.events import find_events
from nhtrack.analysis.spells import averaged
from nhtrack.arrays import row_blocks
from nhtrack.recording import Recording
from nhtrack.settling import SettlingLimits, first_late_row, settling_limits, settling_rows

LOAD_SPAN = 0.1  # [s] over which loads are means: those of wheels that begin to slide are thrown about for some steps
_FEW = 100  # robots, up to which all pairs are looked at


class Separation(NamedTuple):
    """The closest two robots came: distance [m], their names, and when [s]."""

    distance: float
    robots: tuple[str, str]
    time: float


def position_error(recording: Recording) -> np.ndarray:
    """Returns the distance of every robot from what it tracks [m], shape (time, robot); NaN for the root."""
    error = recording["error"].values
    return np.asarray(np.hypot(error[..., 0], error[..., 1]))


def heading_error(recording: Recording) -> np.ndarray:
    """Returns the relative heading of every robot to what it tracks, in [-pi, pi] [rad], shape (time, robot)."""
    return np.asarray(recording["error"].values[..., 2])


def position_gap(recording: Recording) -> np.ndarray:
    """Returns the distance of every robot from its ideal twin at the same time [m], shape (time, robot)."""
    gap = recording["pose"].values - recording["ideal_pose"].values
    return np.asarray(np.hypot(gap[..., 0], gap[..., 1]))


def heading_gap(recording: Recording) -> np.ndarray:
    """Returns the heading of every robot minus its ideal twin's, whole turns included [rad], shape (time, robot)."""
    return np.asarray(recording["pose"].values[..., 2] - recording["ideal_pose"].values[..., 2])


def of_largest_magnitude(values: np.ndarray) -> np.ndarray:
    """Returns, of two wheels, the value of larger magnitude with its sign, shape (..., 2) -> (...)."""
    left, right = values[..., 0], values[..., 1]
    return np.where(np.abs(left) >= np.abs(right), left, right)


def mean_loads(recording: Recording, rows: slice = slice(None)) -> np.ndarray:
    """Returns the wheel loads of rows, means over `LOAD_SPAN` [N], shape (k, robot, 2)."""
    load, time = recording["wheel_load"], recording.time
    first, last, _ = rows.indices(len(time))
    if recording.rows > len(time):  # thinned: they are means already
        return np.asarray(load[rows].values)
    before = int(np.searchsorted(time, time[first] - LOAD_SPAN)) if first else 0
    return averaged(load[before:last].values, time[before:last], LOAD_SPAN)[first - before :]


def late_rows(recording: Recording) -> slice:
    """Returns the rows of the last 15 % of the time."""
    return slice(first_late_row(recording.time), None)


def limits_of(recording: Recording) -> SettlingLimits:
    """Returns within which errors a follower of a run has settled; see `nhtrack.settling`."""
    return settling_limits(recording.length_scale)


def settling_times(recording: Recording) -> np.ndarray:
    """Returns when each robot settled [s], shape (robot,); NaN for those that did not, and for the root.

    What settled means: `nhtrack.settling`.
    """
    rows = settling_rows(limits_of(recording), position_error(recording), heading_error(recording))
    return np.append(recording.time, np.nan)[np.where(rows <= first_late_row(recording.time), rows, -1)]


def smallest_separation(recording: Recording) -> Separation | None:
    """Returns the closest any two robots came, or None for a single robot."""
    pose, robots = recording["pose"], recording.robots
    if len(robots) < 2:
        return None
    find = _nearest_of_few if len(robots) <= _FEW else _nearest_of_many
    found = []
    for part in row_blocks(len(pose), pose.nbytes):
        distance, row, first, second = find(pose[part].values[..., :2])
        found.append((distance, part.start + row, first, second))
    distance, row, first, second = min(found)
    return Separation(distance, (robots[first], robots[second]), float(recording.time[row]))


def _nearest_of_few(positions: np.ndarray) -> tuple[float, int, int, int]:
    """Returns the least distance between two robots, its row, and which they are; positions of shape (t, n, 2)."""
    found = []  # of every robot and those after it
    for first in range(positions.shape[1] - 1):
        apart = np.sqrt(((positions[:, first + 1 :] - positions[:, first : first + 1]) ** 2).sum(axis=-1))
        row, after = map(int, np.unravel_index(apart.argmin(), apart.shape))
        found.append((float(apart[row, after]), row, first, first + 1 + after))
    return min(found)


def _nearest_of_many(positions: np.ndarray) -> tuple[float, int, int, int]:
    """Returns what `_nearest_of_few` does, in O(t n log n)."""
    from scipy.spatial import KDTree  # only here: it takes longer to import than few robots to compare

    nearest: tuple[float, int, int, int] = (np.inf, 0, 0, 1)
    for row, places in enumerate(positions):
        apart, who = KDTree(places).query(places, k=2)
        one = int(apart[:, 1].argmin())
        first, second = sorted((one, int(who[one][who[one] != one][0])))
        nearest = min(nearest, (float(apart[one, 1]), row, first, second))
    return nearest


def summary(recording: Recording, events: Sequence[Event] | None = None) -> dict[str, Any]:
    """Returns the figures of a run as a tree of plain numbers and names, ready for JSON; unknown figures are None.

    Positions in metres, headings in radians, loads in newtons, times in seconds on the robot's clock. An infinite
    utilisation, of a wheel that carries no load, is None like any figure that is not known. *Late* means the worst over
    the last 15 % of the run, `settling_limits` are those of `nhtrack.settling`. The events are those of
    `nhtrack.analysis.events.find_events`. Gaps to ideal twins are those until `twin_compared_until`, when robots first
    touched, or to the end; smallest loads are of means over `LOAD_SPAN`.

    Args:
        recording: the run.
        events: of the run, if they are known; else they are looked for.
    """
    separation = smallest_separation(recording)
    events = find_events(recording) if events is None else events
    touched = first_touch(events)
    return {
        "name": recording.name,
        "backend": recording.backend,
        "outcome": recording.outcome,
        "duration": float(recording.time[-1]),
        "similarity": {"length": recording.length_scale, "time": recording.time_scale},
        "settling_limits": limits_of(recording)._asdict(),
        "followers": follower_figures(recording),
        "twin_compared_until": touched,
        "robots": robot_figures(recording, touched),
        "smallest_separation": None if separation is None else separation._asdict(),
        "events": [asdict(event) | {"worst": _plain(event.worst)} for event in events],
    }


def follower_figures(recording: Recording) -> dict[str, dict[str, Any]]:
    """Returns the errors of every follower by its name, and when it settled; see `summary`."""
    return {name: figures for part in recording.shares() for name, figures in _follower_figures(part).items()}


def _follower_figures(recording: Recording) -> dict[str, dict[str, Any]]:
    position, heading = position_error(recording), np.abs(heading_error(recording))
    late, settled = late_rows(recording), settling_times(recording)
    columns = {name: i for i, name in enumerate(recording.robots)}
    return {
        name: {
            "initial_position_error": _plain(position[0, columns[name]]),
            "final_position_error": _plain(position[-1, columns[name]]),
            "final_heading_error": _plain(heading[-1, columns[name]]),
            "late_position_error": _plain(position[late, columns[name]].max()),
            "late_heading_error": _plain(heading[late, columns[name]].max()),
            "settling_time": _plain(settled[columns[name]]),
        }
        for name in recording.followers
    }


def robot_figures(recording: Recording, touched: float | None = None) -> dict[str, dict[str, Any]]:
    """Returns path, gap to the twin, friction, load and torque of every robot by its name; see `summary`.

    Args:
        recording: the run.
        touched: when robots touched first [s]; ideal twins pass through, and gaps are those until then.
    """
    return {name: figures for part in recording.shares() for name, figures in _robot_figures(part, touched).items()}


def _robot_figures(recording: Recording, touched: float | None) -> dict[str, dict[str, Any]]:
    travelled = np.hypot(*np.moveaxis(np.diff(recording["pose"].values[..., :2], axis=0), -1, 0)).sum(axis=0)
    before = slice(None) if touched is None else recording.time <= touched
    position, heading = position_gap(recording)[before], np.abs(heading_gap(recording))[before]
    load = mean_loads(recording)
    columns: dict[str, np.ndarray] = {
        "path_length": travelled,
        "gap_position_rms": np.sqrt((position**2).mean(axis=0)),
        "gap_position_max": position.max(axis=0),
        "gap_heading_rms": np.sqrt((heading**2).mean(axis=0)),
        "gap_heading_max": heading.max(axis=0),
        "peak_utilisation": _peak(recording, "friction_utilisation"),
        "peak_utilisation_predicted": _peak(recording, "friction_utilisation_predicted"),
        "smallest_wheel_load": _smallest(load),
        "peak_lateral_slip": _peak(recording, "lateral_slip"),
        "torque_saturation_share": np.nan_to_num(recording["torque_saturation"].values).max(axis=-1).mean(axis=0),
    }
    return {
        name: {figure: _plain(values[i]) for figure, values in columns.items()}
        for i, name in enumerate(recording.robots)
    }


def _peak(recording: Recording, name: str) -> np.ndarray:
    """Returns the largest magnitude of a variable for every robot; NaN where it was never known."""
    values = np.abs(recording[name].values)
    known = np.where(np.isnan(values), -np.inf, values).reshape(*values.shape[:2], -1).max(axis=(0, 2))
    return np.where(np.isneginf(known), np.nan, known)


def _smallest(values: np.ndarray) -> np.ndarray:
    """Returns the smallest value of a variable for every robot; NaN where it was never known."""
    known = np.where(np.isnan(values), np.inf, values).reshape(*values.shape[:2], -1).min(axis=(0, 2))
    return np.where(np.isposinf(known), np.nan, known)


def _plain(value: float) -> float | None:
    """Returns a JSON number, or None for what JSON has no number for."""
    return float(value) if np.isfinite(value) else None


