"""What a tuning wants: figures of many closed loops at once, and the cost that weighs them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np

from nhtrack.analysis.motion import motion_of
from nhtrack.analysis.speedup import largest_factors
from nhtrack.arrays import Array
from nhtrack.errors import NhtrackError, did_you_mean
from nhtrack.experiment.loop import Rollout
from nhtrack.ground import Ground
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.settling import SettlingLimits, first_late_row, settling_rows

# One unit of cost: what a good run leaves. Position errors are shares of the leader's path.
_POSITION, _HEADING, _SETTLING, _UTILISATION = 0.01, 0.1, 0.1, 0.1
_STEEPNESS = 100.0  # every per cent of a time scale too small costs one unit


class ObjectiveError(NhtrackError):
    """An objective that cannot be understood."""


class Figures(NamedTuple):
    """How closed loops went, worst robot each, arrays of shape (b,).

    Attributes:
        late_position: largest position error over the last 15 % of the run, as a share of the leader's path, or of
            the largest starting distance where that is longer [1].
        late_heading: largest heading error over the same time [rad].
        settling: when the last follower settled, as a share of the run; 1 where one never does [1].
        utilisation: peak predicted friction utilisation; infinite where a wheel would lift [1].
        pace: smallest time scale that fits over the one there is, with the friction margin; above 1 it does not fit.
    """

    late_position: Array
    late_heading: Array
    settling: Array
    utilisation: Array
    pace: Array

    def of(self, run: int) -> RunFigures:
        """Returns the figures of one of the runs."""
        return RunFigures(*(float(values[run]) for values in self))


class RunFigures(NamedTuple):
    """How one closed loop went; see `Figures`."""

    late_position: float
    late_heading: float
    settling: float
    utilisation: float
    pace: float


def figures_of(
    run: Rollout, limits: SettlingLimits, bodies: list[int], drive: DiffDrive, ground: Ground, margin: float
) -> Figures:
    """Returns the figures of a batch of runs on the ideal model.

    Args:
        run: with a batch shape (b,).
        limits: within which a follower has settled.
        bodies: indices of the robots that have wheels.
        drive: their reduced model.
        ground: what they stand on.
        margin: share of its friction that may be used.
    """
    error = run.variables["error"][:, :, 1:]
    distance, heading = np.hypot(error[..., 0], error[..., 1]), np.abs(error[..., 2])
    steps = np.diff(run.variables["pose"][:, :, 0, :2], axis=0)
    path = np.hypot(steps[..., 0], steps[..., 1]).cumsum(axis=0)[-1]  # in order, however many go side by side
    late, rows = first_late_row(run.time), settling_rows(limits, distance, heading)
    settled = np.where(rows <= late, rows / len(distance), 1.0)
    utilisation, pace = np.zeros(len(path)), np.zeros(len(path))
    for robot in bodies:  # one at a time: these are the largest arrays of a search
        motion = motion_of(run, robot)
        used = drive.predicted_utilisation(ground, motion.g, *motion.rates)
        utilisation = np.maximum(utilisation, used.max(axis=(0, -1)))
        with np.errstate(divide="ignore"):
            pace = np.maximum(pace, 1 / largest_factors(motion, drive, ground.scaled(margin)).min(axis=(0, 1, -1)))
    return Figures(
        distance[late:].max(axis=(0, 2)) / np.maximum(path, distance[0].max(axis=-1)),
        heading[late:].max(axis=(0, 2)),
        settled.max(axis=-1),
        utilisation,
        pace,
    )


@dataclass(frozen=True)
class Objective:
    """Weights of what is wanted; the cost is their sum, and the penalties of what cannot be driven.

    Attributes:
        late: of the late errors, in per cent of the leader's path and tenths of a radian.
        settling: of the settling time, in tenths of the run.
        utilisation: of the peak predicted friction utilisation, in tenths.

    Raises:
        ObjectiveError: a weight below zero or not finite, or no weight at all.
    """

    late: float = 0.0
    settling: float = 0.0
    utilisation: float = 0.0

    def __post_init__(self) -> None:
        weights = self.weights.values()
        if not all(np.isfinite(weight) and weight >= 0 for weight in weights) or not any(weights):
            raise ObjectiveError(f"objective: expected weights of at least 0, one above it, got {self.weights}")

    @property
    def weights(self) -> Mapping[str, float]:
        """Weights by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @classmethod
    def parse(cls, text: str) -> Objective:
        """Returns the objective of a text such as `late` or `late=1,settling=0.5`.

        Raises:
            ObjectiveError: a name that is not known, or a weight that is not a number.
        """
        names = [field.name for field in fields(cls)]
        weights: dict[str, float] = {}
        for part in text.split(","):
            name, equals, weight = (piece.strip() for piece in part.partition("="))
            if name not in names:
                raise ObjectiveError(f"no objective {name!r}; {did_you_mean(name, names)}")
            try:
                weights[name] = float(weight) if equals else 1.0
            except ValueError:
                raise ObjectiveError(f"objective {name}: expected a number as its weight, got {weight!r}") from None
        return cls(**weights)

    def __str__(self) -> str:
        used = {name: weight for name, weight in self.weights.items() if weight}
        if list(used.values()) == [1.0]:
            return next(iter(used))
        return ",".join(f"{name}={weight:g}" for name, weight in used.items())

    def cost(self, figures: Figures) -> Array:
        """Returns the cost of figures, shape (b,); infinite for runs that diverge and where no time scale would fit."""
        cost = _STEEPNESS * np.maximum(0, figures.pace - 1)
        terms = {
            "late": figures.late_position / _POSITION + figures.late_heading / _HEADING,
            "settling": figures.settling / _SETTLING,
            "utilisation": figures.utilisation / _UTILISATION,
        }
        for name, weight in self.weights.items():
            if weight:
                cost = cost + weight * terms[name]
        return np.where(np.isnan(cost), np.inf, cost)
