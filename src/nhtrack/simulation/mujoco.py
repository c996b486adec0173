"""Robots on MuJoCo wheel contacts, driven by wheel torques.

MuJoCo's semi-implicit step is a leapfrog: positions live at the times t_k = k h, velocities half a step earlier, at
t_k - h/2. This module keeps to that reading and is second order in h because of it:

- the torque of a physics step is the mean of the commanded torque over [t_k - h/2, t_k + h/2]: in the first step of a
  control period the mean of the old command and the new, from rest half of the first command;
- a velocity is resolved in the heading of its own time, t_k - h/2, and carried to t_k by half a step's acceleration;
- a robot placed with a twist is given the velocity it would have had half a step earlier at that constant twist.

The compensation runs every physics step, as a wheel's torque controller would; the command changes every control
period. The period itself is compiled: `nhtrack.simulation.engine`.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import mujoco
import numpy as np

from nhtrack.arrays import Array
from nhtrack.errors import SimulationDiverged
from nhtrack.simulation import columns, engine, memory
from nhtrack.simulation.faults import failure_in, reach_of
from nhtrack.simulation.motion import Motion, Place
from nhtrack.simulation.scene import Scene
from nhtrack.simulation.spec import SceneSpec
from nhtrack.simulation.state import Driven, State, require_rolling
from nhtrack.simulation.touch import NOTED, SLOTS
from nhtrack.simulation.track import Track, driven, make_track
from nhtrack.simulation.wheels import make_wheels


class MujocoSimulation:
    """n robots, or a batch of such scenes, on wheels that only friction holds.

    Args:
        scene: the compiled scene, of all robots or of one of them.
        dt: control period [s], a whole number of physics steps.
        batch: () for one scene, (b,) for b of them side by side.
        threads: threads that step the batch, or the robots of one scene that cannot touch each other.
        spec: of all robots, where the scene is of a single one; robots that cannot touch each other are stepped as
            models of one robot each.
        keep_going: let a simulation of the batch that diverges stand still where it was, so that the others can go on;
            else it raises SimulationDiverged.
        size: of the scenario [m]; see `nhtrack.simulation.faults`.

    Raises:
        ValueError: dt is not a whole number of physics steps, or robots that can touch each other come without a scene
            of all of them.
    """

    def __init__(
        self,
        scene: Scene,
        dt: float,
        batch: tuple[int, ...] = (),
        threads: int = 1,
        *,
        spec: SceneSpec | None = None,
        keep_going: bool = False,
        size: float = 1.0,
    ) -> None:
        self._size = size
        self.scene, self.spec, self.drive, self.dt, self.batch = scene, spec or scene.spec, scene.drive, dt, batch
        self.names, self.ground, self.keep_going = self.spec.robots, self.spec.ground, keep_going
        step = self.spec.timestep
        if round(dt / step) < 1 or abs(round(dt / step) * step - dt) > 1e-9 * dt:
            raise ValueError(f"dt: {dt:g} s is not a whole number of physics steps of {step:g} s")
        if len(self.spec.bodies) > len(scene.spec.bodies) and self.spec.robot_contact:
            raise ValueError("robots that can touch each other need a scene of all of them")
        self.wheels = make_wheels(scene, self.spec, dt)
        self._threads = max(1, min(threads, batch[0] if batch else self.units))
        self._models = [_stepped(scene.model, self.spec) for _ in range(self._threads)]
        self._datas = [mujoco.MjData(model) for model in self._models]
        self.places = [_place(model, data) for model, data in zip(self._models, self._datas, strict=True)]
        self.motion = self._still(batch[0] if batch else 1)

    @property
    def measured(self) -> bool:
        """Whether there is telemetry."""
        return True

    @property
    def units(self) -> int:
        """Models that one simulation steps: one for each robot, or one for all where they can touch."""
        return len(self.spec.bodies) // len(self.scene.spec.bodies)

    @property
    def is_fleet(self) -> bool:
        """Whether the threads share the robots of one simulation, rather than simulations."""
        return not self.batch and len(self.places) > 1

    @property
    def substeps(self) -> int:
        """Physics steps in a control period."""
        return int(self.wheels.substeps)

    def _still(self, count: int) -> Motion:
        """Returns the state of so many simulations with nothing in it."""
        n, p = len(self.spec.robots), len(self.spec.bodies)
        k, model = len(self.scene.spec.bodies), self.scene.model
        size_q, size_v = model.nq // k, model.nv // k
        robots, bodies, wheels = (count, n), (count, p), (count, p, 2)
        can_touch = self.spec.robot_contact and p > 1
        return Motion(
            g=np.zeros((*robots, 3)),
            xi=np.zeros((*robots, 3)),
            g_before=np.zeros((*robots, 3)),
            xi_before=np.zeros((*robots, 3)),
            u=np.zeros((*robots, 2)),
            u_before=np.zeros((*robots, 2)),
            qpos=np.zeros((*bodies, size_q)),
            qvel=np.zeros((*bodies, size_v)),
            warmstart=np.zeros((*bodies, size_v)),
            unheld=np.zeros((*bodies, size_v)),
            velocity=np.zeros((*bodies, 3)),
            velocity_before=np.zeros((*bodies, 3)),
            friction=np.zeros(wheels),
            force=np.zeros((*wheels, 3)),
            contact=np.zeros(wheels, dtype=np.int64),
            sliding=np.zeros(wheels, dtype=np.bool_),
            rolled=np.zeros((*wheels, 5)),
            telemetry=np.zeros((*robots, columns.WIDTH)),
            touch=np.zeros((count, n if can_touch else 0, SLOTS, NOTED)),
            fault=np.zeros((count, 3), dtype=np.int64),
            lost=np.zeros(count, dtype=np.bool_),
            reach=np.zeros(count),
        )

    def reset(self, state: State) -> State:
        """Places the robots level on the floor, rolling without slip at their twists; see `Simulation.reset`."""
        require_rolling(state)
        self.start_time, self._periods, motion = state.t, 0, self.motion
        for values in motion:
            values[...] = 0
        motion.g[:], motion.xi[:] = self._batched(state.g), self._batched(state.xi)
        motion.g_before[:], motion.xi_before[:] = motion.g, motion.xi
        motion.touch[:] = np.nan
        motion.reach[:] = reach_of(motion.g, self._size)
        first = self.spec.first_body
        g, xi = motion.g[:, first:], motion.xi[:, first:]
        units = (-1, len(self.scene.spec.bodies), 3)
        at_rest = g.reshape(units)
        motion.qpos[:] = self.scene.qpos_of(at_rest, np.zeros((*at_rest.shape[:-1], 2))).reshape(motion.qpos.shape)
        earlier = g - self.spec.timestep / 2 * xi * np.array([0, 0, 1])
        motion.qvel[:] = self.scene.qvel_of(earlier.reshape(units), xi.reshape(units)).reshape(motion.qvel.shape)
        motion.velocity[..., 0], motion.velocity[..., 2] = xi[..., 0], xi[..., 2]
        motion.velocity_before[:] = motion.velocity
        motion.friction[:] = self.ground.friction
        engine.measure_all(self.wheels, motion)
        return self._state()

    def step(self, u: Array) -> State:
        """Drives the robots through one control period; see `Simulation.step`."""
        self._drive(np.asarray(u)[None], make_track(0, self.motion, telemetry=False))
        self._periods += 1
        failure = self.failure()
        if failure is not None:
            raise failure
        return self._state()

    def drive_by(self, u: Array) -> Driven:
        """Drives the robots by inputs known beforehand; see `Simulation.drive_by`."""
        begin, track = self._state(), make_track(len(u), self.motion, telemetry=True)
        self._drive(u, track)
        self._periods += int(track.written.min(initial=len(u)))
        failure = self.failure(self._periods + 1)
        if failure is not None:
            raise failure
        return driven(begin, self.dt, track, self.batch)

    def _drive(self, u: Array, track: Track) -> None:
        """Drives the simulations by inputs, shape (k, ..., n, 2), a share of them in every thread."""
        held = np.array(u, dtype=float, order="C").reshape(len(u), *self.motion.u.shape)
        shares = np.linspace(0, len(self.motion.g), min(self._threads, len(self.motion.g)) + 1).astype(int)
        tasks = [
            (self.wheels, place, self.motion, int(first), int(last), held, track, self.keep_going)
            for place, (first, last) in zip(self.places, pairwise(shares), strict=False)
        ]
        if len(tasks) == 1:
            engine.drive_simulations(*tasks[0])
        else:
            with ThreadPoolExecutor(len(tasks)) as pool:
                list(pool.map(lambda task: engine.drive_simulations(*task), tasks))

    def failure(self, periods: int | None = None, simulation: int | None = None) -> SimulationDiverged | None:
        """Returns why a simulation cannot go on, or None; one that may be lost is no failure.

        Args:
            periods: control periods since the reset, those stepped by `step` by default.
            simulation: which one; the first that cannot go on by default.
        """
        done = self._periods if periods is None else periods
        return failure_in(self.motion, self.names, self.start_time, self.dt, done, simulation)

    @property
    def lost(self) -> Array:
        """Which simulations have diverged and stand still, shape () or (b,)."""
        return self._unbatched(self.motion.lost).copy()

    @property
    def qpos(self) -> Array:
        """MuJoCo's configuration now, robot by robot, shape (nq,) or (b, nq)."""
        return self._unbatched(self.motion.qpos.reshape(len(self.motion.qpos), -1)).copy()

    @property
    def qvel(self) -> Array:
        """MuJoCo's velocities now, half a step before the configuration's time, shape (nv,) or (b, nv)."""
        return self._unbatched(self.motion.qvel.reshape(len(self.motion.qvel), -1)).copy()

    @property
    def contact_force(self) -> Array:
        """Forces of the floor on the tyres in the last physics step [N], world frame, shape (..., p, 2, 3)."""
        return self._unbatched(self.motion.force).copy()

    @property
    def time(self) -> float:
        """Time on the robots' clock [s]."""
        return self.start_time + self._periods * self.dt

    def telemetry(self) -> Mapping[str, Array]:
        """Returns what the wheels did in the last period; see `Simulation.telemetry`."""
        return columns.telemetry_of(self._unbatched(self.motion.telemetry).copy())

    def _batched(self, array: Array) -> Array:
        return np.array(array if self.batch else array[None], dtype=float)

    def _unbatched(self, array: Array) -> Array:
        return array if self.batch else array[0]

    def _state(self) -> State:
        return State(self.time, self._unbatched(self.motion.g).copy(), self._unbatched(self.motion.xi).copy())


def _stepped(model: mujoco.MjModel, spec: SceneSpec) -> mujoco.MjModel:
    """Returns the copy of a model that a thread steps, into which it writes surface velocities and friction."""
    own = copy.copy(model)
    own.flg_surfacevel = spec.rate_correction
    return own


def _place(model: mujoco.MjModel, data: mujoco.MjData) -> Place:
    address, function = memory.address_of, memory.address_in_library
    return Place(
        step=function("mj_step"),
        step_1=function("mj_step1"),
        step_2=function("mj_step2"),
        actuate=function("mj_fwdActuation"),
        accelerate=function("mj_fwdAcceleration"),
        to_rows=function("mj_mulJacVec"),
        model=model._address,
        data=data._address,
        qpos=address(data.qpos),
        qvel=address(data.qvel),
        warmstart=address(data.qacc_warmstart),
        unheld=address(data.qacc_smooth),
        scratch=address(data.qacc),
        ctrl=address(data.ctrl),
        surface=address(model.geom_surfacevel),
        friction=address(model.geom_friction),
    )
