"""The open-loop motion of the tests, and short names for what drives a simulation without a law."""

from __future__ import annotations

import numpy as np

from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.scene import SceneSpec, make_scene
from nhtrack.simulation.state import State
from nhtrack.studies.fidelity.motion import AT_REST, PoseError, Run, difference, integrate, middles, open_loop_error
from nhtrack.studies.fidelity.motion import drive_open_loop as drive
from nhtrack.studies.fidelity.motion import state_of as state

__all__ = [
    "AT_REST", "PoseError", "Run", "difference", "drive", "integrate", "make_simulation", "middles", "state", "weaving",
    "weaving_error",
]  # fmt: skip


def weaving(t: np.ndarray) -> np.ndarray:
    """Accelerations (u_x, u_theta) fit for nh_mini, shape (..., 2).

    From rest and for 10 s: speeds to 0.38 m/s and 2.5 rad/s, a net turn of 10.4 rad.
    """
    return np.stack([0.3 * np.cos(0.8 * t), 0.9 * np.cos(1.3 * t) + 0.8 * np.sin(0.7 * t)], axis=-1)


def make_simulation(
    spec: SceneSpec, dt: float | None = None, batch: tuple[int, ...] = ()
) -> MujocoSimulation:
    """Returns the MuJoCo simulation of a spec, its control period one physics step unless told otherwise."""
    return MujocoSimulation(make_scene(spec), dt or spec.timestep, batch)


def weaving_error(
    simulation: MujocoSimulation, duration: float = 10.0, start: State = AT_REST
) -> PoseError:
    """Returns how far a simulation strays from the ideal robot under the weaving input."""
    return open_loop_error(simulation, weaving, duration, start)
