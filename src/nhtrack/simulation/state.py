"""What a simulation is: the state it carries and the contract it keeps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, Protocol

import numpy as np

from nhtrack.arrays import Array


class State(NamedTuple):
    """Kinematic state of n robots; `...` is the batch shape, () or (b,).

    Attributes:
        t: time on the robot's clock [s].
        g: poses (x [m], y [m], theta [rad], unwrapped) in the world frame, shape (..., n, 3).
        xi: body twists (v_x [m/s], v_y [m/s], omega [rad/s]), shape (..., n, 3).
    """

    t: float
    g: Array
    xi: Array


class Driven(NamedTuple):
    """What open-loop inputs made of robots: at the start and at the end of every period.

    Attributes:
        t: times [s], shape (k + 1,).
        g: poses, shape (k + 1, ..., n, 3).
        xi: twists, shape (k + 1, ..., n, 3).
        telemetry: of each period, shape (k, ..., n, components), by the names of `nhtrack.recording.VARIABLES`.
    """

    t: Array
    g: Array
    xi: Array
    telemetry: Mapping[str, Array]


class Simulation(Protocol):
    """Moves robots by commanded accelerations, one control period at a time.

    Attributes:
        dt: control period [s].
        names: the robots' names, root first.
    """

    dt: float
    names: tuple[str, ...]

    def reset(self, state: State) -> State:
        """Places the robots and returns the state as the simulation holds it; `v_y` must be zero."""
        ...

    def step(self, u: Array) -> State:
        """Holds the accelerations u = (u_x [m/s^2], u_theta [rad/s^2]), shape (..., n, 2), for one period.

        Returns:
            The state at the end of the period, in arrays the caller may keep.

        Raises:
            SimulationDiverged: a state is not finite, a robot tipped over, or the engine warned.
        """
        ...

    def drive_by(self, u: Array) -> Driven:
        """Holds accelerations known beforehand, shape (k, ..., n, 2), each for one period, as `step` would.

        Raises:
            SimulationDiverged: see `step`.
        """
        ...

    def telemetry(self) -> Mapping[str, Array]:
        """Returns what the wheels did in the last period, by the names of `nhtrack.recording.VARIABLES`."""
        ...


def require_rolling(state: State) -> None:
    """Raises ValueError for a state with lateral velocity, which no wheel allows, or whose arrays do not match."""
    if state.g.shape != state.xi.shape or state.g.ndim < 2 or state.g.shape[-1] != 3:
        raise ValueError(f"state: expected g and xi of shape (..., n, 3), got {state.g.shape} and {state.xi.shape}")
    if np.any(state.xi[..., 1] != 0):
        raise ValueError("state: v_y must be zero, the robots stand on wheels")
