"""Limits on a robot's motion that a law keeps; kept for the array laws."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Limits:
    """A box of velocities and accelerations; `nhtrack.experiment.limits` finds the one that wheels and motors hold."""

    speed: float
    yaw_rate: float
    acceleration: float
    yaw_acceleration: float

    def __post_init__(self) -> None:
        for name, limit in vars(self).items():
            if not limit > 0:
                raise ValueError(f"{name}: expected a positive limit, got {limit}")
