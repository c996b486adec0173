"""Records what a run on wheels writes into MuJoCo at every physics step, and replays it into bare `mj_step`."""

from __future__ import annotations

import time
from typing import Any

import mujoco
import numpy as np

from nhtrack.compiled import call_2, compiled_loop, float64_at, put_float64
from nhtrack.experiment.followers import Tracking
from nhtrack.experiment.loop import rollout
from nhtrack.laws import Law, law_named
from nhtrack.network import Network
from nhtrack.simulation import engine
from nhtrack.simulation.motion import Motion, Place, Wheels
from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.scene import SceneSpec, stepped_scene
from nhtrack.simulation.sliding import step_physics
from nhtrack.simulation.state import State
from nhtrack.simulation.unit import drive_unit, load_unit, read_unit, store_unit

PERIOD = 0.01  # [s]
LAWS: dict[str, dict[str, Any]] = {
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
        return len(self.log.rows) * self.n

    def closed_loop(self) -> float:
        """Runs all that `nhtrack run` does in its periods; returns the processor time [s]."""
        begin = time.thread_time()
        self.run = rollout(self.simulation, self.law, self.network, self.inputs, self.start, self.tracking)
        return time.thread_time() - begin

    def bare(self) -> float:
        """Replays the same steps into `mj_step`, unit by unit; returns the processor time [s]."""
        simulation, log, spent = self.simulation, self.log, 0.0
        model, data, place = simulation._models[0], simulation._datas[0], simulation.places[0]
        k, rows = len(simulation.scene.spec.bodies), np.ascontiguousarray(log.rows[:, 0])
        for first in range(0, self.n, k):
            mujoco.mj_resetData(model, data)
            data.qpos = log.qpos[0, first : first + k].ravel()
            data.qvel = log.qvel[0, first : first + k].ravel()
            begin = time.thread_time()
            _replay(simulation.wheels, place, rows, first)
            spent += time.thread_time() - begin
            end = log.end[0, first : first + k].ravel()
            assert np.abs(data.qpos - end).max() < 1e-9, "the replay is not the run"
        return spent

    def _record(self) -> Log:
        self.closed_loop()
        assert self.run.failure is None, self.run.failure
        return Log(self.simulation, self.start, self.run.variables["input"][:-1, None])


class Log:
    """What is written into MuJoCo at every physics step of a run: torques, surface velocities, friction.

    Args:
        simulation: whose; it is left at the end of the run.
        start: the state to begin with.
        inputs: accelerations of all robots, shape (periods, b, n, 2).
    """

    def __init__(self, simulation: MujocoSimulation, start: State, inputs: np.ndarray) -> None:
        simulation.reset(start)
        motion, steps = simulation.motion, simulation.substeps
        self.qpos, self.qvel = motion.qpos.copy(), motion.qvel.copy()
        self.rows = np.zeros((len(inputs) * steps, *motion.qpos.shape[:2], 2, 3))
        for k, u in enumerate(np.ascontiguousarray(inputs)):
            period = self.rows[k * steps : (k + 1) * steps]
            _record_period(simulation.wheels, simulation.places[0], motion, u, period)
        self.end = motion.qpos.copy()


@compiled_loop
def _record_period(wheels: Wheels, place: Place, motion: Motion, u: np.ndarray, log: np.ndarray) -> None:
    """Does what `engine.step_simulation` does, and writes down what it gives MuJoCo."""
    count = wheels.tyres.shape[0]
    for b in range(motion.qpos.shape[0]):
        engine.begin(motion, b, u[b])
        for unit in range(motion.qpos.shape[1] // count):
            load_unit(wheels, place, motion, b, unit)
            for step in range(wheels.substeps):
                drive_unit(wheels, place, motion, b, unit, step == 0)
                for i in range(count):
                    robot = unit * count + i
                    for w in range(2):
                        log[step, b, robot, w, 0] = float64_at(place.ctrl + 8 * wheels.motors[i, w])
                        log[step, b, robot, w, 1] = float64_at(place.surface + 48 * wheels.tyres[i, w] + 8)
                        log[step, b, robot, w, 2] = motion.friction[b, robot, w]
                step_physics(wheels, place, motion, b, unit * count)
                read_unit(wheels, place, motion, b, unit)
            store_unit(wheels, place, motion, b, unit)
        engine.finish(wheels, motion, b)


@compiled_loop
def _replay(wheels: Wheels, place: Place, log: np.ndarray, first: int) -> None:
    """Writes what was written down and steps, nothing else; log of shape (steps, robots, 2, 3)."""
    for s in range(log.shape[0]):
        for i in range(wheels.tyres.shape[0]):
            for w in range(2):
                put_float64(place.ctrl + 8 * wheels.motors[i, w], log[s, first + i, w, 0])
                put_float64(place.surface + 48 * wheels.tyres[i, w] + 8, log[s, first + i, w, 1])
                put_float64(place.friction + 24 * wheels.tyres[i, w], log[s, first + i, w, 2])
        call_2(place.step, place.model, place.data)


def least(case: Case, spells: int) -> tuple[float, float]:
    """Returns the least processor time of bare MuJoCo and of the closed loop, taken in turn [s]."""
    bare, closed = zip(*((case.bare(), case.closed_loop()) for _ in range(spells)), strict=True)
    return min(bare), min(closed)
