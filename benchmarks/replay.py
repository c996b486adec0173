"""Records what a run on wheels writes into MuJoCo at every physics step, and replays it into bare `mj_step`."""

from __future__ import annotations

import time

import mujoco
import numpy as np
from numba import njit

from nhtrack.compiled import call_2, doubles
from nhtrack.experiment.followers import Tracking
from nhtrack.experiment.loop import rollout
from nhtrack.laws import Law, law_named
from nhtrack.network import Network
from nhtrack.simulation import engine
from nhtrack.simulation.mujoco import MujocoSimulation, stepped_scene
from nhtrack.simulation.scene import SceneSpec
from nhtrack.simulation.state import State

PERIOD = 0.01  # [s]
LAWS = {
    "universal": {"k1": 16.0, "k2": 8.0, "k3": 6.0, "c": 0.5, "field_speed": 0.3},
    "published": {"kp": 1.0, "kd": 2.5, "ke": 0.5, "k": 5.0},
}


class Case:
    """A leader that weaves and n - 1 followers in a square formation around it."""

    def __init__(self, n: int, law: str, seconds: float, step: float = 0.001, *, contact: bool = False) -> None:
        names = ("leader", *(f"f{i}" for i in range(1, n)))
        self.n, self.spec = n, SceneSpec(names, timestep=step, robot_contact=contact)
        self.law: Law = law_named(law)(**LAWS[law])
        self.network = Network.from_parents({"leader": ()} | {name: ("leader",) for name in names[1:]})
        places = 0.5 * np.stack(np.divmod(np.arange(n), int(np.ceil(np.sqrt(n)))), axis=-1)
        g = np.zeros((n, 3))
        g[:, :2], g[1:, 2] = places, 0.1
        g[1:, :2] += 0.05
        self.start, self.tracking = State(0.0, g, np.zeros((n, 3))), Tracking(offsets=places)
        t = (np.arange(round(seconds / PERIOD)) + 0.5) * PERIOD
        self.inputs = np.stack([np.where(t < 2, 0.1, 0.0), 0.3 * np.cos(1.3 * t)], axis=-1)
        self.simulation = MujocoSimulation(stepped_scene(self.spec), PERIOD, spec=self.spec)
        self.log = self._record()

    @property
    def robot_steps(self) -> int:
        return len(self.log) * self.n

    def closed_loop(self) -> float:
        """Runs all that `nhtrack run` does in its periods; returns the processor time [s]."""
        begin = time.thread_time()
        self.run = rollout(self.simulation, self.law, self.network, self.inputs, self.start, self.tracking)
        return time.thread_time() - begin

    def bare(self) -> float:
        """Replays the same steps into `mj_step`, unit by unit; returns the processor time [s]."""
        simulation, spent = self.simulation, 0.0
        model, data, place = simulation._models[0], simulation._datas[0], simulation.places[0]
        k = len(simulation.scene.spec.bodies)
        for first in range(0, self.n, k):
            mujoco.mj_resetData(model, data)
            data.qpos = self._qpos[first : first + k].ravel()
            data.qvel = self._qvel[first : first + k].ravel()
            begin = time.thread_time()
            _replay(simulation.wheels, place, self.log, first)
            spent += time.thread_time() - begin
            end = self._end[first : first + k].ravel()
            assert np.abs(data.qpos - end).max() < 1e-9, "the replay is not the run"
        return spent

    def _record(self) -> np.ndarray:
        self.closed_loop()
        assert self.run.failure is None, self.run.failure
        simulation, u = self.simulation, np.ascontiguousarray(self.run.variables["input"][:-1])
        simulation.reset(self.start)
        self._qpos, self._qvel = simulation.motion.qpos[0].copy(), simulation.motion.qvel[0].copy()
        log = np.zeros((len(u) * simulation.substeps, self.n, 6))
        for k, period in enumerate(np.split(log, len(u))):
            _record_period(simulation.wheels, simulation.places[0], simulation.motion, u[k], period)
        self._end = simulation.motion.qpos[0].copy()
        return log


@njit
def _record_period(wheels, place, motion, u, log):  # type: ignore[no-untyped-def]
    """Does what `engine.step_simulation` does, and writes down what it gives MuJoCo."""
    engine.begin(motion, 0, u)
    k, q, v = wheels.tyres.shape[0], motion.qpos.shape[2], motion.qvel.shape[2]
    qpos, qvel = doubles(place.qpos, k * q).reshape((k, q)), doubles(place.qvel, k * v).reshape((k, v))
    warm = doubles(place.warmstart, k * v).reshape((k, v))
    for first in range(0, motion.qpos.shape[1], k):
        for i in range(k):
            engine.copy(qpos[i], motion.qpos[0, first + i])
            engine.copy(qvel[i], motion.qvel[0, first + i])
            engine.copy(warm[i], motion.warmstart[0, first + i])
        for s in range(wheels.substeps):
            for i in range(k):
                engine._drive(wheels, place, motion, 0, first + i, i, s == 0, qpos[i], qvel[i])
                for w in range(2):
                    log[s, first + i, w] = doubles(place.ctrl + 8 * wheels.motors[i, w], 1)[0]
                    log[s, first + i, 2 + w] = doubles(place.surface + 48 * wheels.tyres[i, w], 2)[1]
                    log[s, first + i, 4 + w] = motion.friction[0, first + i, w]
            call_2(place.step, place.model, place.data)
            engine._read_forces(wheels, place, motion.force[0], first)
            for i in range(k):
                engine._note_forces(wheels, motion, 0, first + i)
                engine._read_velocity(wheels, motion, 0, first + i, qpos[i], qvel[i])
        for i in range(k):
            engine.copy(motion.qpos[0, first + i], qpos[i])
            engine.copy(motion.qvel[0, first + i], qvel[i])
            engine.copy(motion.warmstart[0, first + i], warm[i])
    engine.finish(wheels, motion, 0)


@njit
def _replay(wheels, place, log, first):  # type: ignore[no-untyped-def]
    """Writes what was written down and steps, nothing else."""
    for s in range(log.shape[0]):
        for i in range(wheels.tyres.shape[0]):
            for w in range(2):
                doubles(place.ctrl + 8 * wheels.motors[i, w], 1)[0] = log[s, first + i, w]
                doubles(place.surface + 48 * wheels.tyres[i, w], 2)[1] = log[s, first + i, 2 + w]
                doubles(place.friction + 24 * wheels.tyres[i, w], 1)[0] = log[s, first + i, 4 + w]
        call_2(place.step, place.model, place.data)


def least(case: Case, spells: int) -> tuple[float, float]:
    """Returns the least processor time of bare MuJoCo and of the closed loop, taken in turn [s]."""
    bare, closed = zip(*((case.bare(), case.closed_loop()) for _ in range(spells)), strict=True)
    return min(bare), min(closed)
