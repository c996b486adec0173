"""Motions without a law: what drives a simulation open loop, and what an independent integrator finds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import solve_ivp

from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.scene import SceneSpec, make_scene
from nhtrack.simulation.state import Simulation, State

Signal = Callable[[np.ndarray], np.ndarray]


def weaving(t: np.ndarray) -> np.ndarray:
    """Accelerations (u_x, u_theta) of the project's open-loop figures, shape (..., 2).

    From rest and for 10 s: speeds to 0.38 m/s and 2.5 rad/s, a net turn of 10.4 rad.
    """
    return np.stack([0.3 * np.cos(0.8 * t), 0.9 * np.cos(1.3 * t) + 0.8 * np.sin(0.7 * t)], axis=-1)


def state(*robots: tuple[tuple[float, float, float], tuple[float, float]]) -> State:
    """Returns the state of robots given as (pose, (v, omega)), shape (n, 3)."""
    return State(
        0.0,
        np.array([pose for pose, _ in robots], float),
        np.array([(v, 0.0, omega) for _, (v, omega) in robots]),
    )


AT_REST = state(((0, 0, 0), (0, 0)))


@dataclass(frozen=True)
class Run:
    """What a simulation did: times (t,), poses and twists (t, ..., n, 3), telemetry after each period."""

    time: np.ndarray
    g: np.ndarray
    xi: np.ndarray
    telemetry: dict[str, np.ndarray] = field(default_factory=dict)


def drive(
    simulation: Simulation, inputs: np.ndarray, start: State = AT_REST, telemetry: tuple[str, ...] = ()
) -> Run:
    """Returns the run of held accelerations, shape (periods, ..., n, 2)."""
    states = [simulation.reset(start)]
    logs: dict[str, list[np.ndarray]] = {name: [] for name in telemetry}
    for u in inputs:
        states.append(simulation.step(u))
        if telemetry:
            seen = simulation.telemetry()
            for name, log in logs.items():
                log.append(seen[name])
    time, g, xi = (np.array(column) for column in zip(*states, strict=True))
    return Run(time, g, xi, {name: np.array(log) for name, log in logs.items()})


def middles(duration: float, dt: float) -> np.ndarray:
    """Returns the middles of the control periods [s]: a smooth input held so is followed to h^2."""
    return (np.arange(round(duration / dt)) + 0.5) * dt


def integrate(signal: Signal, time: np.ndarray, start: State = AT_REST) -> tuple[np.ndarray, np.ndarray]:
    """Returns poses and twists (t, n, 3) of the ideal robot under a smooth input, by DOP853."""

    def rate(t: float, y: np.ndarray) -> np.ndarray:
        theta, v, omega = y[2::5], y[3::5], y[4::5]
        u = np.broadcast_to(signal(np.array(t)), (len(theta), 2))
        return np.stack([v * np.cos(theta), v * np.sin(theta), omega, u[:, 0], u[:, 1]], axis=-1).ravel()

    y = np.concatenate([start.g, start.xi[:, (0, 2)]], axis=-1).ravel()
    found = solve_ivp(rate, (time[0], time[-1]), y, method="DOP853", rtol=1e-12, atol=1e-13, t_eval=time)
    columns = found.y.T.reshape(len(time), len(start.g), 5)
    lateral = np.zeros_like(columns[..., :1])
    return columns[..., :3], np.concatenate([columns[..., 3:4], lateral, columns[..., 4:]], axis=-1)


@dataclass(frozen=True)
class OpenLoopError:
    """Largest differences from the ideal robot at the same times of a run: position [m] and heading [rad]."""

    position: float
    heading: float


def make_simulation(
    spec: SceneSpec, dt: float | None = None, batch: tuple[int, ...] = ()
) -> MujocoSimulation:
    """Returns the MuJoCo simulation of a spec, its control period one physics step unless told otherwise."""
    return MujocoSimulation(make_scene(spec), dt or spec.timestep, batch)


def weaving_error(
    simulation: MujocoSimulation, duration: float = 10.0, start: State = AT_REST
) -> OpenLoopError:
    """Returns how far a simulation strays from the ideal robot under the weaving input."""
    t = middles(duration, simulation.dt)
    n = len(start.g)
    inputs = np.broadcast_to(weaving(t)[:, None], (len(t), n, 2))
    run = drive(simulation, inputs, start)
    return difference(run.g, integrate(weaving, run.time, start)[0])


def difference(g: np.ndarray, h: np.ndarray) -> OpenLoopError:
    """Returns the largest differences between two runs' poses, shape (..., 3)."""
    gap = g - h
    return OpenLoopError(float(np.hypot(gap[..., 0], gap[..., 1]).max()), float(np.abs(gap[..., 2]).max()))
