"""Prints robot-seconds per processor second beside those of the kinematic simulator IR-SIM, if it is installed.

    pip install ir-sim && python benchmarks/kinematic_peer.py [--robots 1 16 64]

Control period 20 ms, physics step 2 ms, one thread, in turn in the same process. IR-SIM moves differential-drive robots
by velocities, without a law, contacts or pictures; `on wheels` is the whole closed loop of this package under
`universal`, `ideal` the same on the integrator, `bare` MuJoCo's step alone. Ratios are to IR-SIM.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import replay
from replay import Case

from nhtrack.experiment.loop import rollout
from nhtrack.simulation.ideal import IdealSimulation

replay.PERIOD = 0.02  # [s]

WORLD = """
world: {{height: 100, width: 100, step_time: 0.02, collision_mode: unobstructed, control_mode: auto}}
robot:
  - number: {n}
    distribution: {{name: random, range_low: [1, 1, -3.14], range_high: [99, 99, 3.14]}}
    kinematics: {{name: diff}}
    shape: {{name: circle, radius: 0.1}}
    behavior: {{name: dash}}
    vel_max: [0.5, 1.0]
"""


def main() -> None:
    verbatim = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=verbatim)
    parser.add_argument("--robots", type=int, nargs="+", default=[1, 16, 64])
    parser.add_argument("--spells", type=int, default=3)
    given = parser.parse_args()
    try:
        import irsim
    except ImportError:
        print("IR-SIM is not installed (pip install ir-sim): nothing to compare with")
        return
    print("robots  IR-SIM [robot-s/s]  on wheels (ratio)  ideal (ratio)  bare mj_step (ratio)")
    for n in given.robots:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "world.yaml"
            file.write_text(WORLD.format(n=n))
            env = irsim.make(str(file), disable_all_plot=True, log_level="ERROR")
        case = Case(n, "universal", max(0.5, 8 / n**0.5), 0.002)
        spells = [(_kinematic(env, n), _wheels(case), _ideal(case), _bare(case)) for _ in range(given.spells)]
        other, wheels, ideal, bare = (max(column) for column in zip(*spells, strict=True))
        shares = "  ".join(f"{speed:8.0f} ({speed / other:5.2f})" for speed in (wheels, ideal, bare))
        print(f"{n:6d}  {other:18.0f}  {shares}", flush=True)


def _speed(n: int, seconds: float, work: Callable[[], object]) -> float:
    begin = time.thread_time()
    work()
    return n * seconds / (time.thread_time() - begin)


def _kinematic(env: object, n: int, steps: int = 100) -> float:
    return _speed(n, 0.02 * steps, lambda: [env.step() for _ in range(steps)])  # type: ignore[attr-defined]


def _wheels(case: Case) -> float:
    return case.n * len(case.inputs) * replay.PERIOD / case.closed_loop()


def _bare(case: Case) -> float:
    return case.n * len(case.inputs) * replay.PERIOD / case.bare()


def _ideal(case: Case) -> float:
    inputs = np.tile(case.inputs, (20, 1))
    simulation = IdealSimulation(case.spec.robots, None, replay.PERIOD, keep_going=True)

    def work() -> None:
        rollout(simulation, case.law, case.network, inputs, case.start, case.tracking)

    return _speed(case.n, len(inputs) * replay.PERIOD, work)


if __name__ == "__main__":
    main()
