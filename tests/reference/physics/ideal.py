"""The ideal integrator (paper eq. 3), as arrays: kept as second implementation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import numpy as np

from nhtrack.arrays import Array
from nhtrack.errors import SimulationDiverged
from nhtrack.ground import Ground
from nhtrack.robots.diff_drive import DiffDrive
from reference.physics.state import State

Motion: TypeAlias = tuple[Array, Array, Array]  # poses, body twists and accelerations

# Gauss-Legendre nodes over a control period. Twelve are exact to rounding while a robot turns
# less than pi per period; with eight, 4e-9 of the path is lost at pi.
_NODES, _WEIGHTS = (array for array in np.polynomial.legendre.leggauss(12))
_NODES, _WEIGHTS = (_NODES + 1) / 2, _WEIGHTS / 2


def propagate(g: Array, xi: Array, u: Array, dt: float) -> tuple[Array, Array]:
    """Returns poses and twists after dt under constant accelerations, the flow of the paper's system (eq. 3)."""
    v, omega = xi[..., 0], xi[..., 2]
    u_x, u_theta = u[..., 0], u[..., 1]
    s = dt * _NODES
    turned = omega[..., None] * s + 0.5 * u_theta[..., None] * s**2
    weighted_speed = (v[..., None] + u_x[..., None] * s) * (dt * _WEIGHTS)
    ahead = (weighted_speed * np.cos(turned)).sum(axis=-1)
    aside = (weighted_speed * np.sin(turned)).sum(axis=-1)
    cosine, sine = np.cos(g[..., 2]), np.sin(g[..., 2])
    g_next = np.stack(
        [
            g[..., 0] + cosine * ahead - sine * aside,
            g[..., 1] + sine * ahead + cosine * aside,
            g[..., 2] + omega * dt + 0.5 * u_theta * dt**2,
        ],
        axis=-1,
    )
    xi_next = np.stack([v + u_x * dt, np.zeros_like(v), omega + u_theta * dt], axis=-1)
    return g_next, xi_next


class IdealSimulation:
    """Robots that obey the ideal model; what the wheels would do comes from the reduced model."""

    def __init__(self, names: tuple[str, ...], drive: DiffDrive, dt: float, ground: Ground | None = None) -> None:
        self.names, self.drive, self.dt, self.ground = names, drive, dt, ground or Ground()

    def reset(self, state: State) -> State:
        """Places the robots; see `Simulation.reset`."""
        require_rolling(state)
        self._state = State(state.t, np.array(state.g), np.array(state.xi))
        self._u, self._before = np.zeros((*self._state.g.shape[:-1], 2)), self._state
        self._start, self._periods = state.t, 0
        return self._copy()

    def step(self, u: Array) -> State:
        """Advances one period by the exact flow; see `Simulation.step`."""
        self._u, self._before = np.array(u, dtype=float), self._state
        require_finite_command(self._u, self.names, self._state.t)
        g, xi = propagate(self._state.g, self._state.xi, self._u, self.dt)
        self._periods += 1
        self._state = State(self._start + self._periods * self.dt, g, xi)
        require_finite(self._state, self.names)
        return self._copy()

    def telemetry(self) -> Mapping[str, Array]:
        """Returns what wheels would have to do for the motion at the end of the period; see `Simulation.telemetry`."""
        v, omega = self._state.xi[..., 0], self._state.xi[..., 2]
        motion, gravity = (v, omega, self._u[..., 0], self._u[..., 1]), self.ground.gravity_at(self._state.g[..., 2])
        torque = self.drive.wheel_torques(*motion, gravity)
        speed = self.drive.wheel_speeds(v, omega)
        start, end = ((state.g, state.xi, self._u) for state in (self._before, self._state))
        predicted = predicted_utilisation(self.drive, self.ground, start, end)
        return {
            "wheel_torque": torque,
            "wheel_torque_demand": torque.copy(),
            "torque_saturation": 1.0 * (self.drive.motor.saturate(torque, speed) != torque),
            "wheel_speed": speed,
            "wheel_load": self.drive.wheel_loads(*motion, gravity),
            "longitudinal_slip": np.zeros_like(torque),
            "lateral_slip": np.zeros_like(v),
            "friction_utilisation": predicted,
            "friction_utilisation_predicted": predicted.copy(),
            "tilt": np.zeros_like(v),
        }

    def _copy(self) -> State:
        return State(self._state.t, self._state.g.copy(), self._state.xi.copy())


def predicted_utilisation(drive: DiffDrive, ground: Ground, start: Motion, end: Motion) -> Array:
    """Returns the larger predicted utilisation of each wheel at the two ends of a period, shape (..., n, 2)."""
    ends = [
        drive.friction_utilisation(
            xi[..., 0], xi[..., 2], u[..., 0], u[..., 1],
            ground.friction_at(drive.wheel_places(g)), ground.gravity_at(g[..., 2]),
        )
        for g, xi, u in (start, end)
    ]  # fmt: skip
    return np.maximum(*ends)


def require_rolling(state: State) -> None:
    """Raises ValueError for a state with lateral velocity, which no wheel allows, or whose arrays do not match."""
    if state.g.shape != state.xi.shape or state.g.ndim < 2 or state.g.shape[-1] != 3:
        raise ValueError(f"state: expected g and xi of shape (..., n, 3), got {state.g.shape} and {state.xi.shape}")
    if np.any(state.xi[..., 1] != 0):
        raise ValueError("state: v_y must be zero, the robots stand on wheels")


def require_finite_command(u: Array, names: tuple[str, ...], t: float) -> None:
    """Raises SimulationDiverged naming the first robot commanded something that is not finite."""
    _require_finite("command is not finite", np.isfinite(u).all(axis=-1), names, t)


def require_finite(state: State, names: tuple[str, ...]) -> None:
    """Raises SimulationDiverged naming the first robot whose state is not finite."""
    finite = np.isfinite(state.g).all(axis=-1) & np.isfinite(state.xi).all(axis=-1)
    _require_finite("state is not finite", finite, names, state.t)


def _require_finite(reason: str, finite: Array, names: tuple[str, ...], t: float) -> None:
    if not finite.all():
        *batch, robot = np.argwhere(~finite)[0]
        raise SimulationDiverged(reason, names[robot], t, int(batch[0]) if batch else 0)
