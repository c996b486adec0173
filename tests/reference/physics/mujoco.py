"""Robots on MuJoCo wheel contacts, driven by wheel torques: array form, kept as second implementation.

MuJoCo's semi-implicit step is read as a leapfrog (docs/fidelity.md): positions live at the times t_k = k h, velocities
half a step earlier. Planar vectors are complex numbers, forward + i lateral. The friction force of a tyre comes from
its contact sensor.
"""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np
from mujoco import batch as mujoco_batch

from nhtrack.arrays import Array
from nhtrack.errors import SimulationDiverged
from nhtrack.ground import Ground
from nhtrack.robots.diff_drive import Motor
from nhtrack.robots.diff_drive.model import utilisation
from reference.physics.contact import FrictionRow
from reference.physics.ideal import (
    predicted_utilisation,
    propagate,
    require_finite,
    require_finite_command,
    require_rolling,
)
from reference.physics.scene import Scene
from reference.physics.state import State

# A robot leaning this far has tipped: its wheels no longer roll on their treads.
TIPPED = np.radians(30.0)
# Share of the friction limit from which a wheel counts as sliding within a physics step.
_SLIDING = 1 - 1e-6


class MujocoSimulation:
    """n robots on wheels that only friction holds; arrays have a first axis of length 1."""

    def __init__(self, scene: Scene, dt: float) -> None:
        self.scene, self.drive, self.dt = scene, scene.drive, dt
        self.names, self.ground = scene.spec.robots, scene.spec.ground
        self._h = scene.spec.timestep
        self.substeps = round(dt / self._h)
        if self.substeps < 1 or abs(self.substeps * self._h - dt) > 1e-9 * dt:
            raise ValueError(f"dt: {dt:g} s is not a whole number of physics steps of {self._h:g} s")
        scene.model.flg_surfacevel = scene.spec.rate_correction
        self._engine = mujoco_batch.Batch(scene.model, 1, 1)
        self._warnings, self._sensors = self._engine.warning, self._engine.bind("sensordata")
        self._surface = self._engine.expand("geom_surfacevel") if scene.spec.rate_correction else None
        self._row = FrictionRow.of(scene.model, int(scene.addresses.tyres[0, 0]))
        self._friction = self._engine.expand("geom_friction") if self.ground.patches else None
        self._known_ground = self.ground if scene.spec.compensation == "actual" else Ground()
        self._read_losses()
        self._bodies = slice(1, None) if scene.spec.virtual_root else slice(None)
        self._planar = scene.plant.levelled
        self._bind()

    def _read_losses(self) -> None:
        """Reads what friction at the wheel joints does in a step; see docs/fidelity.md."""
        model, drive, h, dofs = self.scene.model, self.drive, self._h, self.scene.addresses.wheel_qvel[0]
        self._damping, self._dry = (np.array(each) for each in (drive.losses.damping, drive.losses.dry_friction))
        self._mobility = h / (drive.wheel_inertia + h / 2 * self._damping)
        self._lag = self._mobility * drive.motor.stall_torque / drive.motor.no_load_speed
        stiffness = model.dof_solimp[dofs, 0] / (1 - model.dof_solimp[dofs, 0]) / model.dof_invweight0[dofs]  # 1/R
        time = np.maximum(model.dof_solref[dofs, 0], 2 * h)
        self._speed_row, self._rate_row = 2 * stiffness / (model.dof_solimp[dofs, 1] * time), stiffness
        rolling = np.array([[1.0, -drive.half_separation], [1.0, drive.half_separation]]) / drive.wheel_radius
        felt = drive.mass_matrix + rolling.T * (h / 2 * self._damping) @ rolling
        self._gain = np.linalg.solve(felt, rolling.T).T

    def _losses(self, speed: Array, rate: Array) -> Array:
        """Returns the torques of friction at the wheel joints in a step in which wheels accelerate as told."""
        dry = np.minimum(np.maximum(self._rate_row * rate + self._speed_row * speed, -self._dry), self._dry)
        return np.asarray(self._damping * (speed + self._h / 2 * rate) + dry)

    def _bind(self) -> None:
        """Takes live views of the engine's state, shape (b, p, ...) for the p robots with a body."""
        qpos, qvel = self._engine.bind("qpos"), self._engine.bind("qvel")
        robots = (len(qpos), len(self.scene.spec.bodies), -1)
        self._qpos, self._qvel, self._ctrl = qpos, qvel, self._engine.bind("ctrl")
        # Every robot is a copy of one model, its base first, so its coordinates are one block.
        self._q, velocities = qpos.reshape(robots), qvel.reshape(robots)
        self._plane_velocity = velocities[..., :2].view(complex)[..., 0]
        self._yaw_rate = velocities[..., 3 if self._planar else 5]

    def reset(self, state: State) -> State:
        """Places the robots level on the floor, rolling without slip at their twists; see `Simulation.reset`."""
        require_rolling(state)
        self._start, self._periods = state.t, 0
        self._g, self._xi = (np.array(array[None], dtype=float) for array in (state.g, state.xi))
        g, xi = self._g[:, self._bodies], self._xi[:, self._bodies]
        self._engine.reset(stage=mujoco.mjtStage.mjSTAGE_NONE)
        self._qpos[:] = self.scene.qpos_of(g, np.zeros((*g.shape[:-1], 2)))
        earlier = g - self._h / 2 * xi * np.array([0, 0, 1])
        self._qvel[:] = self.scene.qvel_of(earlier, xi)
        self._place_marker()
        self._g_before, self._xi_before = self._g.copy(), self._xi.copy()
        self._velocity, self._omega = xi[..., 0] + 0j, xi[..., 2].copy()
        self._velocity_before, self._omega_before = self._velocity, self._omega
        self._u, self._u_root = np.zeros((*g.shape[:-1], 2)), np.zeros((len(g), 1, 2))
        self._u_straddling = self._u
        self._terms = np.zeros((*g.shape[:-1], 6))  # of DiffDrive.ground_map
        self._friction_now = np.full(self._u.shape, self.ground.friction)
        self._clear_log(np.nan)  # before the first step nothing is known of forces
        return self._state()

    def step(self, u: Array) -> State:
        """Drives the robots through one control period; see `Simulation.step`."""
        command = np.array(u[None], dtype=float)
        require_finite_command(command, self.names, self.time)
        u, self._u_root = command[:, self._bodies], command[:, :1]
        self._clear_log()
        self._u_straddling = (self._u + u) / 2  # the first step begins half a step before the command
        self._physics_step(0, self._u_straddling)
        for k in range(1, self.substeps):
            self._physics_step(k, u)
        self._u, self._periods = u, self._periods + 1
        self._read_state()
        self._move_root()
        state = self._state()
        self._require_upright(state)
        return state

    @property
    def qpos(self) -> Array:
        """MuJoCo's configuration now, shape (nq,)."""
        return np.asarray(self._qpos[0].copy())

    @property
    def time(self) -> float:
        """Time on the robots' clock [s]."""
        return self._start + self._periods * self.dt

    def telemetry(self) -> Mapping[str, Array]:
        """Returns what the wheels did in the last period; see `Simulation.telemetry`."""
        drive, bodies = self.drive, self._bodies
        wheel_speed = self._qvel[:, self.scene.addresses.wheel_qvel]
        start = (self._g_before[:, bodies], self._xi_before[:, bodies], self._u_straddling)
        end = (self._g[:, bodies], self._xi[:, bodies], self._u)
        force = -self._sensor_log[:, :, self.scene.addresses.forces]  # of the floor on the tyres, world frame
        used = utilisation(np.hypot(force[..., 0], force[..., 1]), self._friction_log * np.maximum(force[..., 2], 0))
        rolling = drive.wheel_speeds(self._velocity.real, self._omega)
        return self._with_root({
            "wheel_torque": self._torque_log.mean(axis=0),
            "wheel_torque_demand": _largest(self._demand_log),
            "torque_saturation": (np.abs(self._demand_log - self._torque_log) > 0).mean(axis=0),
            "wheel_speed": wheel_speed,
            "wheel_load": np.ascontiguousarray(force[..., 2]).mean(axis=0),  # summed alike in a batch and alone
            "longitudinal_slip": drive.wheel_radius * (rolling - wheel_speed * self.scene.radius_factors),
            "lateral_slip": self._velocity.imag,
            "friction_utilisation": used.max(axis=0),
            "friction_utilisation_predicted": predicted_utilisation(self.scene.plant, self.ground, start, end),
            "tilt": self._tilt(),
        })  # fmt: skip

    # One physics step -------------------------------------------------------------------------------------------------

    def _physics_step(self, k: int, u: Array) -> None:
        """Steps once and reads the new velocities.

        The axle midpoint's velocity turns from half a step before t_k to half a step after. Seen in the heading of t_k,
        in which MuJoCo takes masses and contacts, it goes from v e^(-i h omega/2) to v_after e^(i h omega_after/2). The
        difference of the two over h is the acceleration that torques are for and that contacts have to bring about.

        Args:
            k: number of the step in its period.
            u: mean of the commanded accelerations over [t_k - h/2, t_k + h/2], which this step gives, shape (b, p, 2).
        """
        at, h, v, omega = self.scene.addresses, self._h, self._velocity.real, self._omega
        before = v * np.exp(-0.5j * h * omega)
        acceleration = (self._velocity_after(u) - before) / h
        self._terms[..., 0] = acceleration.real
        self._terms[..., 1] = u[..., 1]
        self._terms[..., 2] = omega * omega  # MuJoCo takes the centripetal force from its own velocities
        self._terms[..., 3] = acceleration.imag
        self._terms[..., 4], self._terms[..., 5], _ = self._known_ground.gravity_at(self._yaw())
        speed, sliding = self._qvel[:, at.wheel_qvel], self._sliding()
        demand = self._terms @ self.drive.torque_map
        demand = demand + self._losses(speed, self.drive.wheel_speeds(u[..., 0], u[..., 1]))
        lost = self._damping * speed + self._dry * np.sign(speed)  # from the speed that a sliding wheel will have
        torque = saturated(self.drive.motor, demand, speed - sliding * self._mobility * lost, self._lag * sliding)
        self._ctrl[:, at.motors] = torque
        if self._surface is not None:
            self._surface[:, at.tyres, 1] = self._rate_correction(before, u + (torque - demand) @ self._gain)
        self._lay_ground(k)
        self._engine.step()
        self._demand_log[k], self._torque_log[k], self._sensor_log[k] = demand, torque, self._sensors
        self._read_velocity()

    def _rate_correction(self, before: Array, u: Array) -> Array:
        """Returns the tyres' surface velocity along the axle with which wheels roll through a step, shape (b, p, 1)."""
        after, side_force = self._velocity_after(u), self._terms @ self.drive.ground_map[:, 1]
        return self._row.surface_velocity(before.imag, after.imag, side_force / 2)[..., None]

    def _velocity_after(self, u: Array) -> Array:
        """Returns the velocity after a step at the accelerations u, in the heading of t_k, shape (b, p), complex."""
        h = self._h
        return (self._velocity.real + h * u[..., 0]) * np.exp(0.5j * h * (self._omega + h * u[..., 1]))

    def _lay_ground(self, k: int) -> None:
        """Gives each tyre the friction of the place where it stands."""
        if self._friction is not None:
            pose = np.stack([self._q[..., 0], self._q[..., 1], self._yaw()], axis=-1)
            self._friction_now = self.ground.friction_at(self.drive.wheel_places(pose))
            self._friction[:, self.scene.addresses.tyres, 0] = self._friction_now
        self._friction_log[k] = self._friction_now

    def _sliding(self) -> Array:
        """Returns which wheels slid in the last step or were off the floor, shape (b, p, 2)."""
        force = self._sensors[:, self.scene.addresses.forces]
        friction, load = np.hypot(force[..., 0], force[..., 1]), -force[..., 2]
        return np.asarray(friction >= _SLIDING * self._friction_now * load)

    def _read_velocity(self) -> None:
        """Resolves the velocities in the headings of their own time, half a step before the positions'."""
        self._velocity_before, self._omega_before = self._velocity, self._omega
        self._omega = self._yaw_rate.copy()
        self._velocity = self._plane_velocity * np.exp(-1j * (self._yaw() - self._h / 2 * self._omega))

    def _yaw(self) -> Array:
        """Heading, on a free base the swing-twist rotation about the vertical on [-2 pi, 2 pi] [rad], shape (b, p)."""
        if self._planar:
            return self._q[..., 3].copy()
        return 2 * np.arctan2(self._q[..., 6], self._q[..., 3])

    def _read_state(self) -> None:
        """Unwraps headings and carries velocities to the positions' time by the acceleration measured last."""
        velocity = self._velocity + (self._velocity - self._velocity_before) / 2
        omega = self._omega + (self._omega - self._omega_before) / 2
        expected = self._g[:, self._bodies, 2] + self.dt * omega
        yaw = self._yaw()
        heading = yaw + 2 * np.pi * np.round((expected - yaw) / (2 * np.pi))
        self._g_before, self._xi_before = self._g.copy(), self._xi.copy()
        self._g[:, self._bodies] = np.stack([self._q[..., 0], self._q[..., 1], heading], axis=-1)
        self._xi[:, self._bodies] = np.stack([velocity.real, velocity.imag, omega], axis=-1)

    # A virtual root follows its input exactly -------------------------------------------------------------------------

    def _move_root(self) -> None:
        if self.scene.marker is not None:
            self._g[:, :1], self._xi[:, :1] = propagate(self._g[:, :1], self._xi[:, :1], self._u_root, self.dt)
            self._place_marker()

    def _place_marker(self) -> None:
        if self.scene.marker is not None:
            theta = self._g[:, 0, 2]
            position, quaternion = self._engine.bind("mocap_pos"), self._engine.bind("mocap_quat")
            position[:, self.scene.marker, :2] = self._g[:, 0, :2]
            quaternion[:, self.scene.marker, 0] = np.cos(theta / 2)
            quaternion[:, self.scene.marker, 3] = np.sin(theta / 2)

    def _with_root(self, telemetry: dict[str, Array]) -> dict[str, Array]:
        """Adds the row of a root that has no wheels, NaN, and takes off the first axis."""
        if self.scene.marker is not None:
            telemetry = {
                name: np.concatenate([np.full_like(values[:, :1], np.nan), values], axis=1)
                for name, values in telemetry.items()
            }
        return {name: values[0] for name, values in telemetry.items()}

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
        """Angle between the robots' vertical axes and the floor's normal [rad], shape (b, p)."""
        if self._planar:
            return np.zeros(self._q.shape[:-1])
        return 2 * np.arcsin(np.minimum(np.hypot(self._q[..., 4], self._q[..., 5]), 1))

    def _clear_log(self, value: float = 0.0) -> None:
        shape = (self.substeps, *self._u.shape)
        self._demand_log, self._torque_log = np.full(shape, value), np.full(shape, value)
        self._sensor_log = np.full((self.substeps, *self._sensors.shape), value)
        self._friction_log = np.full(shape, value)

    def _state(self) -> State:
        return State(self.time, self._g[0].copy(), self._xi[0].copy())


def saturated(motor: Motor, torque: Array, wheel_speed: Array, lag: Array) -> Array:
    """Returns the torque that a motor gives, see `Motor.saturate`."""
    line, most = wheel_speed / motor.no_load_speed, motor.torque_limit
    upper, lower = motor.stall_torque * (1 - line) / (1 + lag), -motor.stall_torque * (1 + line) / (1 + lag)
    torque = np.maximum(torque, np.minimum(np.maximum(lower, -most), most))
    return np.minimum(torque, np.minimum(np.maximum(upper, -most), most))


def _largest(log: Array) -> Array:
    """Returns the entries of largest magnitude along the first axis, signs kept."""
    at = np.abs(log).argmax(axis=0)
    return np.asarray(np.take_along_axis(log, at[None], axis=0)[0])
