"""What an array simulation is: the state it carries and the contract it keeps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, Protocol

from nhtrack.arrays import Array


class State(NamedTuple):
    """Kinematic state of n robots; `...` is the batch shape, () or (b,)."""

    t: float
    g: Array
    xi: Array


class Simulation(Protocol):
    """Moves robots by commanded accelerations, one control period at a time."""

    dt: float
    names: tuple[str, ...]

    def reset(self, state: State) -> State:
        """Places the robots and returns the state as the simulation holds it; `v_y` must be zero."""
        ...

    def step(self, u: Array) -> State:
        """Holds the accelerations u = (u_x [m/s^2], u_theta [rad/s^2]), shape (..., n, 2), for one period."""
        ...

    def telemetry(self) -> Mapping[str, Array]:
        """Returns what the wheels did in the last period, by the names of `nhtrack.recording.VARIABLES`."""
        ...
