"""Figures of many runs at once, kept while they run, so that no run has to be recorded."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from nhtrack.arrays import Array
from nhtrack.control import Memory
from nhtrack.diffdrive import DiffDrive
from nhtrack.ground import Ground
from nhtrack.rollout import Period, tracking_error
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
        plant: the follower's reduced model, for runs without wheels.
        ground: what it stands on.
    """

    arrival: Arrival
    duration: float
    periods: int
    similarity: Similarity
    plant: DiffDrive
    ground: Ground


class Tally:
    """Figures of b runs; `add` takes every control period in order, `figures` gives what came of it.

    Args:
        watch: what figures are taken by.
        runs: b.
    """

    def __init__(self, watch: Watch, runs: int) -> None:
        self._watch, self._added, self._memory, self._u = watch, 0, None, np.zeros((runs, 2))
        self._late = watch.periods * (1 - watch.arrival.last / watch.duration) - 1e-6
        self._late_position, self._late_heading = np.zeros(runs), np.zeros(runs)
        self._settled = np.zeros(runs, dtype=np.intp)
        self._utilisation, self._saturated = np.zeros(runs), np.zeros(runs)
        self._effort, self._switches = np.zeros((runs, 2)), np.zeros(runs, dtype=np.intp)

    def add(self, period: Period, telemetry: Any, lost: Array) -> None:
        """Takes a control period.

        Args:
            period: as it begins.
            telemetry: of the period before, or nothing where there are no wheels.
            lost: which runs are lost, shape (b,); their figures stand still.
        """
        self._watch_errors(period)
        used, saturated = self._wheels(period, telemetry)
        self._utilisation = np.where(lost, self._utilisation, np.fmax(self._utilisation, used))
        self._saturated += np.where(lost, 0, saturated)
        if period.u is not None:
            self._u = period.u[:, _FOLLOWER]
            self._effort += np.where(lost[:, None], 0, self._u**2)
        memory = period.memories[0]
        if self._memory is not None:
            self._switches += np.where(lost, 0, _changes(self._memory, memory, len(lost)))
        self._memory, self._added = memory, self._added + 1

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

    def _watch_errors(self, period: Period) -> None:
        error = tracking_error(period)[:, _FOLLOWER]
        distance = np.hypot(error[:, 0], error[:, 1]) / self._watch.similarity.length
        heading = np.abs(error[:, 2])
        if self._added >= self._late:
            self._late_position = np.fmax(self._late_position, distance)
            self._late_heading = np.fmax(self._late_heading, heading)
        arrival = self._watch.arrival
        outside = (distance > arrival.position) | (heading > arrival.heading)
        self._settled[outside] = self._added + 1

    def _wheels(self, period: Period, telemetry: Any) -> tuple[Array, Array]:
        """Returns peak utilisation and share of saturation of the period before, predicted where there are no wheels.

        Predicted utilisation is taken as the period begins and as it ends, like `predicted_utilisation`; saturation as
        it ends.
        """
        if telemetry:
            used, saturated = (telemetry[name][:, _FOLLOWER] for name in ("friction_utilisation", "torque_saturation"))
            return used.max(axis=-1), saturated.max(axis=-1)
        plant, ground = self._watch.plant, self._watch.ground
        g, xi = period.state.g[:, _FOLLOWER], period.state.xi[:, _FOLLOWER]
        v, omega = xi[:, 0], xi[:, 2]
        friction, gravity = ground.friction_at(plant.wheel_places(g)), ground.gravity_at(g[:, 2])
        used = np.zeros(len(g))
        commands = [self._u] if self._added else []
        commands += [] if period.u is None else [period.u[:, _FOLLOWER]]
        for u in commands:
            share = plant.friction_utilisation(v, omega, u[:, 0], u[:, 1], friction, gravity)
            used = np.fmax(used, share.max(axis=-1))
        if not self._added:
            return used, used * 0
        torque = plant.wheel_torques(v, omega, self._u[:, 0], self._u[:, 1], gravity)
        held = plant.motor.saturate(torque, plant.wheel_speeds(v, omega))
        return used, (held != torque).any(axis=-1)


def _changes(before: Memory, after: Memory, runs: int) -> Array:
    """Returns how many entries of a law's memory changed in each run, shape (b,); a tuple of arrays, or one."""
    leaves = zip(*(memory if isinstance(memory, tuple) else (memory,) for memory in (before, after)), strict=True)
    changed = np.zeros(runs, dtype=np.intp)
    for old, new in leaves:
        changed += (np.asarray(old) != np.asarray(new)).reshape(runs, -1).any(axis=-1)
    return changed
