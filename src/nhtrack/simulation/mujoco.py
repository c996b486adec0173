"""Robots on MuJoCo wheel contacts, driven by wheel torques.

MuJoCo's semi-implicit step is a leapfrog: positions live at the times t_k = k h, velocities half a step earlier, at
t_k - h/2. This module keeps to that reading and is second order in h because of it:

- the torque of a physics step is the mean of the commanded torque over [t_k - h/2, t_k + h/2]: in the first step of a
  control period the mean of the old command and the new, from rest half of the first command;
- a velocity is resolved in the heading of its own time, t_k - h/2, and carried to t_k by half a step's acceleration;
- a robot placed with a twist is given the velocity it would have had half a step earlier at that constant twist.

The compensation runs every physics step, as a wheel's torque controller would; the command changes every control
period.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import mujoco
import numpy as np
from mujoco import batch as mujoco_batch

from nhtrack.arrays import Array
from nhtrack.diffdrive.reduced_model import utilisation
from nhtrack.errors import SimulationDiverged
from nhtrack.simulation.ideal import propagate, require_finite, require_rolling
from nhtrack.simulation.scene import Scene
from nhtrack.simulation.state import State

# A robot leaning this far has tipped: its wheels no longer roll on their treads.
TIPPED = np.radians(30.0)


class _Velocity(NamedTuple):
    """Velocities at one time, shape (b, p): forward and lateral [m/s], yaw rate [rad/s]."""

    v: Array
    lateral: Array
    omega: Array


class MujocoSimulation:
    """n robots, or a batch of such scenes, on wheels that only friction holds.

    Args:
        scene: the compiled scene.
        dt: control period [s], a whole number of physics steps.
        batch: () for one scene, (b,) for b of them side by side.
        threads: threads that step the batch.

    Raises:
        ValueError: dt is not a whole number of physics steps.
    """

    def __init__(self, scene: Scene, dt: float, batch: tuple[int, ...] = (), threads: int = 1) -> None:
        self.scene, self.drive, self.dt, self.batch = scene, scene.drive, dt, batch
        self.names = scene.spec.robots
        self.substeps = round(dt / scene.spec.timestep)
        self._h = scene.spec.timestep
        if self.substeps < 1 or abs(self.substeps * self._h - dt) > 1e-9 * dt:
            raise ValueError(f"dt: {dt:g} s is not a whole number of physics steps of {self._h:g} s")
        scene.model.flg_surfacevel = scene.spec.rate_correction
        self._engine = mujoco_batch.Batch(scene.model, batch[0] if batch else 1, threads)
        self._qpos, self._qvel, self._ctrl = (self._engine.bind(name) for name in ("qpos", "qvel", "ctrl"))
        self._sensors, self._warnings = self._engine.bind("sensordata"), self._engine.warning
        self._surface = self._engine.expand("geom_surfacevel") if scene.spec.rate_correction else None
        damping = contact_damping(scene.model, int(scene.addresses.tyres[0, 0]))
        self._correction = self._h / 2 - 1 / damping
        at = scene.addresses
        self._planar = at.root_qvel[:, None] + np.array([0, 1, 5])
        self._quaternion = at.root_qpos[:, None] + np.arange(3, 7)
        self._bodies = slice(1, None) if scene.spec.virtual_root else slice(None)

    def reset(self, state: State) -> State:
        """Places the robots level on the floor, rolling without slip at their twists; see `Simulation.reset`."""
        require_rolling(state)
        self._start, self._periods = state.t, 0
        self._g, self._xi = self._batched(state.g), self._batched(state.xi)
        g, xi = self._g[:, self._bodies], self._xi[:, self._bodies]
        self._engine.reset(stage=mujoco.mjtStage.mjSTAGE_NONE)
        self._qpos[:] = self.scene.qpos_of(g, np.zeros((*g.shape[:-1], 2)))
        earlier = g - self._h / 2 * xi * np.array([0, 0, 1])
        self._qvel[:] = self.scene.qvel_of(earlier, xi)
        self._place_marker()
        self._heading = g[..., 2].copy()
        self._velocity = self._previous = _Velocity(xi[..., 0].copy(), np.zeros(g.shape[:-1]), xi[..., 2].copy())
        self._u = np.zeros((*g.shape[:-1], 2))
        self._u_root = np.zeros((len(g), 1, 2))
        self._clear_log(np.nan)  # before the first step nothing is known of forces
        return self._state()

    def step(self, u: Array) -> State:
        """Drives the robots through one control period; see `Simulation.step`."""
        command = self._batched(u)
        u, self._u_root = command[:, self._bodies], command[:, :1]
        self._clear_log()
        self._physics_step(0, before=self._u, during=(self._u + u) / 2)
        for k in range(1, self.substeps):
            self._physics_step(k, before=u, during=u)
        self._u, self._periods = u, self._periods + 1
        self._move_root()
        self._read_state()
        state = self._state()
        self._require_upright(state)
        return state

    @property
    def qpos(self) -> Array:
        """MuJoCo's configuration now, shape (nq,) or (b, nq)."""
        return self._unbatched(self._qpos).copy()

    @property
    def time(self) -> float:
        """Time on the robots' clock [s]."""
        return self._start + self._periods * self.dt

    def telemetry(self) -> Mapping[str, Array]:
        """Returns what the wheels did in the last period; see `Simulation.telemetry`."""
        at, drive = self.scene.addresses, self.drive
        speed = self._qvel[:, at.wheel_qvel]
        now = self._velocity
        rolling = drive.wheel_speeds(now.v, now.omega)
        motion = (self._xi[:, self._bodies, 0], self._xi[:, self._bodies, 2], self._u[..., 0], self._u[..., 1])
        predicted = drive.friction_utilisation(*motion, self.scene.spec.friction)
        forces = self._force_log
        return self._with_root({
            "wheel_torque": self._torque_log.mean(axis=0),
            "wheel_torque_demand": _largest(self._demand_log),
            "torque_saturation": (np.abs(self._demand_log - self._torque_log) > 0).mean(axis=0),
            "wheel_speed": speed,
            "wheel_load": -forces[-1, ..., 2],
            "longitudinal_slip": drive.wheel_radius * (rolling - speed),
            "lateral_slip": now.lateral,
            "friction_utilisation": self._utilisation(forces).max(axis=0),
            "friction_utilisation_predicted": predicted,
            "tilt": self._tilt(),
        })  # fmt: skip

    # One physics step -----------------------------------------------------------------------------------------------

    def _physics_step(self, k: int, before: Array, during: Array) -> None:
        """Steps once and reads the new velocities.

        Args:
            k: number of the step in its period.
            before: accelerations commanded over the half step up to t_k, shape (b, p, 2).
            during: their mean over [t_k - h/2, t_k + h/2], which this step gives.
        """
        last, half = self._velocity, self._h / 2
        v, omega = last.v + half * before[..., 0], last.omega + half * before[..., 1]
        u_x, u_theta = during[..., 0], during[..., 1]
        at = self.scene.addresses
        # MuJoCo takes centripetal terms from its own velocities, lateral acceleration from what the contacts make of
        # it.
        demand = self.drive.wheel_torques(v, omega, u_x, u_theta, omega_squared=last.omega * last.omega)
        torque = self.drive.motor.saturate(demand, self._qvel[:, at.wheel_qvel])
        self._ctrl[:, at.motors] = torque
        if self._surface is not None:
            self._surface[:, at.tyres, 1] = (self._correction * v * omega)[..., None]
        self._engine.step()
        self._demand_log[k], self._torque_log[k] = demand, torque
        self._force_log[k] = self._sensors[:, at.forces]
        self._read_velocity()

    def _read_velocity(self) -> None:
        """Resolves the planar velocity in the heading half a step before the positions' time."""
        w, x, y, z = np.moveaxis(self._qpos[:, self._quaternion], -1, 0)
        yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
        turn = yaw - self._heading
        self._heading = self._heading + turn - 2 * np.pi * np.round(turn / (2 * np.pi))
        v_x, v_y, omega = np.moveaxis(self._qvel[:, self._planar], -1, 0)
        middle = self._heading - self._h / 2 * omega
        c, s = np.cos(middle), np.sin(middle)
        self._previous = self._velocity
        self._velocity = _Velocity(c * v_x + s * v_y, c * v_y - s * v_x, omega)

    def _read_state(self) -> None:
        """Carries the velocities to the positions' time by the acceleration that was measured last."""
        columns = [now + (now - before) / 2 for now, before in zip(self._velocity, self._previous, strict=True)]
        at = self.scene.addresses
        pose = [self._qpos[:, at.root_qpos], self._qpos[:, at.root_qpos + 1], self._heading]
        self._g[:, self._bodies] = np.stack(pose, axis=-1)
        self._xi[:, self._bodies] = np.stack(columns, axis=-1)

    # A virtual root follows its input exactly ------------------------------------------------------------------------

    def _move_root(self) -> None:
        if self.scene.marker is not None:
            self._g[:, :1], self._xi[:, :1] = propagate(self._g[:, :1], self._xi[:, :1], self._u_root, self.dt)
            self._place_marker()

    def _place_marker(self) -> None:
        if self.scene.marker is not None:
            theta = self._g[:, 0, 2]
            position, quaternion = self._engine.bind("mocap_pos"), self._engine.bind("mocap_quat")
            position[:, self.scene.marker, :2] = self._g[:, 0, :2]
            quaternion[:, self.scene.marker] = np.stack([np.cos(theta / 2), 0 * theta, 0 * theta, np.sin(theta / 2)],
            -1)

    def _with_root(self, telemetry: dict[str, Array]) -> dict[str, Array]:
        """Adds the row of a root that has no wheels, NaN, and takes off a batch axis that was not asked for."""
        if self.scene.marker is not None:
            telemetry = {
                name: np.concatenate([np.full_like(values[:, :1], np.nan), values], axis=1)
                for name, values in telemetry.items()
            }
        return {name: self._unbatched(values) for name, values in telemetry.items()}

    # Checks and bookkeeping -------------------------------------------------------------------------------------------

    def _require_upright(self, state: State) -> None:
        """Raises SimulationDiverged for engine warnings, states that are not finite, and robots on their sides."""
        require_finite(state, self.names)
        warned = np.argwhere(self._warnings[..., 1] > 0)
        if len(warned):
            simulation, kind = warned[0]
            what = mujoco.mjtWarning(int(kind)).name.removeprefix("mjWARN_").lower()
            raise SimulationDiverged(f"MuJoCo warned of {what}", self.names[0], state.t, int(simulation))
        tipped = np.argwhere(self._tilt() > TIPPED)
        if len(tipped):
            simulation, robot = tipped[0]
            raise SimulationDiverged("tipped over", self.scene.spec.bodies[robot], state.t, int(simulation))

    def _tilt(self) -> Array:
        """Angle between the robots' vertical axes and the world's [rad], shape (b, p)."""
        _, x, y, _ = np.moveaxis(self._qpos[:, self._quaternion], -1, 0)
        return 2 * np.arcsin(np.clip(np.hypot(x, y), 0, 1))

    def _utilisation(self, forces: Array) -> Array:
        """hypot(f_long, f_lat)/(mu N) of contact forces on the tyres, shape (..., 3) -> (...)."""
        limit = self.scene.spec.friction * np.maximum(-forces[..., 2], 0)
        return utilisation(np.hypot(forces[..., 0], forces[..., 1]), limit)

    def _clear_log(self, value: float = 0.0) -> None:
        shape = (self.substeps, *self._u.shape)
        self._demand_log, self._torque_log = np.full(shape, value), np.full(shape, value)
        self._force_log = np.full((*shape, 3), value)

    def _batched(self, array: Array) -> Array:
        return np.array(array if self.batch else array[None], dtype=float)

    def _unbatched(self, array: Array) -> Array:
        return array if self.batch else array[0]

    def _state(self) -> State:
        return State(self.time, self._unbatched(self._g).copy(), self._unbatched(self._xi).copy())


def contact_damping(model: mujoco.MjModel, tyre: int) -> float:
    """Returns b = 2/(d timeconst) [1/s], the rate at which a contact of this geom gives up sliding velocity.

    From the geom's solref (timeconst) and the impedance d that solimp gives at small penetration; MuJoCo leaves the
    rate of the contact frame out of its rows, so a turning wheel without correction slides sideways at v omega / b.
    """
    timeconst = max(float(model.geom_solref[tyre, 0]), 2 * float(model.opt.timestep))
    return 2 / (float(model.geom_solimp[tyre, 1]) * timeconst)


def _largest(log: Array) -> Array:
    """Returns the entries of largest magnitude along the first axis, signs kept."""
    at = np.abs(log).argmax(axis=0)
    return np.take_along_axis(log, at[None], axis=0)[0]
