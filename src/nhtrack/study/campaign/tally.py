"""Figures of many runs at once, kept while they run, so that no run has to be recorded."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nhtrack.arrays import Array
from nhtrack.experiment.recorder import Shape, Streaming
from nhtrack.experiment.rows import Rows, named
from nhtrack.scenario.campaign import Arrival
from nhtrack.similarity import Similarity

_FOLLOWER = 1  # its place behind the leader


class Watch(NamedTuple):
    """What figures are taken by.

    Attributes:
        arrival: the criterion, in scenario units.
        duration: of a run [scenario time].
        periods: control periods of a run.
        similarity: scenario units to the robot's.
        modes: places in the law's memory whose changes are counted.
    """

    arrival: Arrival
    duration: float
    periods: int
    similarity: Similarity
    modes: tuple[int, ...]


class Tally(Streaming):
    """Figures of b runs of a leader and a follower; a recorder that keeps no row.

    Args:
        watch: what figures are taken by.
    """

    def __init__(self, watch: Watch) -> None:
        self._watch = watch

    def begin(self, shape: Shape) -> None:
        """Sets all figures to those of no run."""
        super().begin(shape)
        runs, watch = shape.simulations, self._watch
        self._memory: Array | None = None
        self._late = watch.periods * (1 - watch.arrival.last / watch.duration) - 1e-6
        self._late_position, self._late_heading = np.zeros(runs), np.zeros(runs)
        self._settled = np.zeros(runs, dtype=np.intp)
        self._utilisation, self._saturated = np.zeros(runs), np.zeros(runs)
        self._effort, self._switches = np.zeros((runs, 2)), np.zeros(runs, dtype=np.intp)

    def take(self, first: int, rows: Rows) -> None:
        """Takes a block of rows; of a run that is lost, those before it was."""
        held = named(rows.table[:, :, _FOLLOWER].swapaxes(0, 1))
        running = ~np.isnan(held["wheel_speed"][..., 0])  # what is lost has no telemetry
        self._watch_errors(first, held["error"])
        begun = slice(1 if first == 0 else 0, None)  # telemetry is of the period before, and before the first is none
        used = np.where(running, held["friction_utilisation"].max(axis=-1), 0.0)[begun]
        self._utilisation = np.fmax(self._utilisation, used.max(axis=0, initial=0.0))
        saturated = np.where(running, held["torque_saturation"].max(axis=-1), 0.0)[begun]
        self._saturated = _summed(self._saturated, saturated)
        u = np.nan_to_num(held["input"])  # nothing is commanded at the end
        self._effort = _summed(self._effort, np.where(running[..., None], u**2, 0.0))
        self._count_switches(rows.memory[:, :, _FOLLOWER].swapaxes(0, 1)[..., list(self._watch.modes)], running)

    def figures(self, lost: Array) -> dict[str, Array]:
        """Returns the figures by the columns of `nhtrack.study.campaign.tables`, in scenario units, shape (b,)."""
        watch, step = self._watch, self._watch.duration / self._watch.periods
        near = (self._late_position <= watch.arrival.position) & (self._late_heading <= watch.arrival.heading)
        never = lost | (self._settled > watch.periods)
        effort = watch.similarity.inputs_to_scenario(np.sqrt(self._effort / watch.periods))
        return {
            "converged": near & ~lost,
            "lost": lost,
            "late_position": np.where(lost, np.nan, self._late_position),
            "late_heading": np.where(lost, np.nan, self._late_heading),
            "settling_time": np.where(never, np.nan, self._settled * step),
            "peak_utilisation": self._utilisation,
            "saturated": self._saturated / watch.periods,
            "effort_x": effort[:, 0],
            "effort_theta": effort[:, 1],
            "switches": self._switches,
        }

    def _watch_errors(self, first: int, error: Array) -> None:
        distance = np.hypot(error[..., 0], error[..., 1]) / self._watch.similarity.length
        heading = np.abs(error[..., 2])
        late = np.arange(first, first + len(error)) >= self._late
        if late.any():
            self._late_position = np.fmax(self._late_position, np.fmax.reduce(distance[late]))
            self._late_heading = np.fmax(self._late_heading, np.fmax.reduce(heading[late]))
        arrival = self._watch.arrival
        outside = (distance > arrival.position) | (heading > arrival.heading)
        last = first + len(outside) - outside[::-1].argmax(axis=0)
        self._settled = np.where(outside.any(axis=0), last, self._settled)

    def _count_switches(self, modes: Array, running: Array) -> None:
        """Counts which modes of the law changed from row to row, shape (k, b, modes)."""
        before = modes[:1] if self._memory is None else self._memory
        changed = np.diff(modes, axis=0, prepend=before) != 0
        self._switches += np.where(running[..., None], changed, False).sum(axis=(0, 2))
        self._memory = modes[-1:].copy()


def _summed(before: Array, rows: Array) -> Array:
    """Returns a sum with rows added one by one: how many come at once, a matter of time, leaves the last digits."""
    return np.add.accumulate(np.concatenate([before[None], rows]))[-1]
