"""Prints what batches on wheels achieve, against an open loop of `mujoco.batch` that is given the same.

    python benchmarks/batches.py [--simulations 1024] [--seconds 0.5]

One robot a simulation (a leader that is a marker, and its follower under `universal`), physics step 2 ms, control
period 20 ms. `open loop` is `mujoco.batch.Batch.step` with the run's own torques, surface velocities and friction
written every physics step and nothing else. Wall time; ratios are of the same run.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from mujoco import batch as mujoco_batch
from replay import LAWS, Log

from nhtrack.experiment.loop import rollout, run_loop
from nhtrack.experiment.recorder import Streaming
from nhtrack.experiment.rows import Rows
from nhtrack.laws import law_named
from nhtrack.network import Network
from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.scene import SceneSpec, stepped_scene
from nhtrack.simulation.state import State

STEP, PERIOD = 0.002, 0.02  # [s]


class Nothing(Streaming):
    """A recorder that looks away."""

    def take(self, first: int, count: int, rows: Rows) -> None:
        pass


def main() -> None:
    verbatim = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=verbatim)
    parser.add_argument("--simulations", type=int, default=1024)
    parser.add_argument("--seconds", type=float, default=0.5, help="robot seconds of every simulation")
    parser.add_argument("--spells", type=int, default=3)
    given = parser.parse_args()
    b, periods = given.simulations, round(given.seconds / PERIOD)
    names = ("leader", "follower")
    spec = SceneSpec(names, timestep=STEP, virtual_root=True)
    scene, network = stepped_scene(spec), Network.from_parents({"leader": (), "follower": ("leader",)})
    law, rng = law_named("universal")(**LAWS["universal"]), np.random.default_rng(0)
    g, xi = np.zeros((b, 2, 3)), np.zeros((b, 2, 3))
    g[:, 1] = rng.uniform(-0.5, 0.5, (b, 3))
    start, inputs = State(0.0, g, xi), np.tile([0.05, 0.1], (periods, 1))
    steps = b * periods * round(PERIOD / STEP)
    print(f"{b} simulations of {given.seconds:g} s, physics step {1e3 * STEP:g} ms")
    print("threads  open loop [robot-steps/s]  closed loop  ratio")
    speeds = {}
    for threads in (1, 2):
        simulation = MujocoSimulation(scene, PERIOD, (b,), threads, spec=spec, keep_going=True)
        engine = mujoco_batch.Batch(simulation._models[0], b, threads)
        commands = rollout(simulation, law, network, inputs, start).variables["input"][:-1]
        log = Log(simulation, start, commands)
        spells = []
        for _ in range(given.spells):
            begin = time.perf_counter()
            run_loop(simulation, law, network, inputs, start, Nothing())
            closed = time.perf_counter() - begin
            spells.append((_open_loop(engine, simulation, log), closed))
        best, closed = (min(column) for column in zip(*spells, strict=True))
        speeds[threads] = steps / closed
        print(f"{threads:7d}  {steps / best:25.0f}  {steps / closed:11.0f}  {best / closed:5.2f}", flush=True)
    print(f"two threads over one: {speeds[2] / speeds[1]:.2f}")


def _open_loop(engine: mujoco_batch.Batch, simulation: MujocoSimulation, log: Log) -> float:
    """Returns the wall time of the same steps, driven from outside [s]."""
    engine.reset()
    for name, begun in (("qpos", log.qpos), ("qvel", log.qvel)):
        engine.bind(name)[:] = begun.reshape(len(begun), -1)
    ctrl, surface, friction = engine.bind("ctrl"), engine.expand("geom_surfacevel"), engine.expand("geom_friction")
    motors, tyres = simulation.wheels.motors[0], simulation.wheels.tyres[0]
    spent = time.perf_counter()
    for step in log.rows[:, :, 0]:
        ctrl[:, motors] = step[..., 0]
        surface[:, tyres, 1] = step[..., 1]
        friction[:, tyres, 0] = step[..., 2]
        engine.step()
    spent = time.perf_counter() - spent
    gap = np.abs(engine.bind("qpos") - log.end.reshape(len(log.end), -1)).max()
    assert gap < 1e-9, f"the replay is not the run: {gap}"
    return spent


if __name__ == "__main__":
    main()
