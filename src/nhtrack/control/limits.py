"""Limits on a robot's motion that a law keeps."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Limits:
    """A box of velocities and accelerations; `nhtrack.scenario.limits` finds the one that wheels and motors hold.

    Attributes:
        speed: largest |v| [m/s].
        yaw_rate: largest |omega| [rad/s].
        acceleration: largest |u_x| [m/s^2].
        yaw_acceleration: largest |u_theta| [rad/s^2].

    Raises:
        ValueError: a limit that is not positive.
    """

    speed: float
    yaw_rate: float
    acceleration: float
    yaw_acceleration: float

    def __post_init__(self) -> None:
        for name, limit in vars(self).items():
            if not limit > 0:
                raise ValueError(f"{name}: expected a positive limit, got {limit}")
