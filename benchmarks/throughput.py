"""Prints what a robot-second costs: the simulation on wheels against bare MuJoCo, same scene, same run.

    python benchmarks/throughput.py [--seconds 2] [--robots 1 4 16 64]

`bare` is `mj_step`, called once a control period for all its physics steps, on robots that roll; `batch` is
the same through `mujoco.batch.Batch` of one, step by step; `simulation` is `MujocoSimulation.step`, which
compensates, corrects and logs every physics step; `with telemetry` reads the log each period too; `planar` is
`bare` on a planar base. Costs are relative to `bare`. Run it on an idle machine: what shares the processor
shares the figures.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import replace

import mujoco
import numpy as np
from mujoco import batch

from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.scene import Scene, SceneSpec, make_scene
from nhtrack.simulation.state import State

PERIOD = 0.01  # [s]


def rolling(n: int) -> State:
    """Returns the state of n robots on a grid, each on its own circle."""
    across = int(np.ceil(np.sqrt(n)))
    x, y = np.divmod(np.arange(n), across)
    g = np.stack([0.5 * x, 0.5 * y, 0.7 * np.arange(n)], axis=-1)
    return State(0.0, g, np.tile([0.15, 0.0, 0.8], (n, 1)))


def bare(scene: Scene, start: State, steps: int) -> Callable[[], None]:
    data = mujoco.MjData(scene.model)
    data.qpos = scene.qpos_of(start.g, np.zeros((len(start.g), 2)))
    data.qvel = scene.qvel_of(start.g, start.xi)
    return lambda: mujoco.mj_step(scene.model, data, nstep=steps)


def bare_batch(scene: Scene, start: State, steps: int) -> Callable[[], None]:
    engine = batch.Batch(scene.model, 1, 1)
    engine.bind("qpos")[:] = scene.qpos_of(start.g, np.zeros((len(start.g), 2)))
    engine.bind("qvel")[:] = scene.qvel_of(start.g, start.xi)

    def period() -> None:
        for _ in range(steps):
            engine.step()

    return period


def simulated(scene: Scene, start: State, telemetry: bool) -> Callable[[], None]:
    simulation = MujocoSimulation(scene, PERIOD)
    simulation.reset(start)
    u = np.tile([0.02, -0.05], (len(start.g), 1))

    def period() -> None:
        simulation.step(u)
        if telemetry:
            simulation.telemetry()

    return period


def cost(period: Callable[[], None], seconds: float) -> float:
    """Returns the least mean cost of a period over five spells [s]: what the machine does undisturbed."""
    period()
    best = np.inf
    for _ in range(5):
        count, begin = 0, time.perf_counter()
        while (spent := time.perf_counter() - begin) < seconds / 5:
            period()
            count += 1
        best = min(best, spent / count)
    return best


def main() -> None:
    verbatim = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=verbatim)
    parser.add_argument("--seconds", type=float, default=2.0, help="wall time for each figure")
    parser.add_argument("--robots", type=int, nargs="+", default=[1, 4, 16, 64])
    given = parser.parse_args()
    print(f"MuJoCo {mujoco.__version__}, physics step 1 ms, control period 10 ms, one thread")
    print("robots  bare [us/robot-step]  batch/bare  simulation/bare  telemetry/bare  planar/bare  robot-seconds/s")
    for n in given.robots:
        spec, start = SceneSpec(tuple(f"r{i}" for i in range(n))), rolling(n)
        scene = make_scene(spec)
        steps = round(PERIOD / scene.spec.timestep)
        plain = cost(bare(scene, start, steps), given.seconds)
        batched = cost(bare_batch(scene, start, steps), given.seconds)
        planar = cost(bare(make_scene(replace(spec, base="planar")), start, steps), given.seconds)
        alone, observed = (cost(simulated(scene, start, each), given.seconds) for each in (False, True))
        print(
            f"{n:6d}  {1e6 * plain / steps / n:20.2f}  {batched / plain:10.2f}  {alone / plain:15.2f}  "
            f"{observed / plain:14.2f}  {planar / plain:11.2f}  {n * PERIOD / observed:15.0f}"
        )


if __name__ == "__main__":
    main()
