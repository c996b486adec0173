"""Prints what the closed loop on wheels costs over bare `mj_step`, in turn in the same process, one thread.

    python benchmarks/closed_loop.py [--robots 1 4 16 64] [--contact 16 64 256] [--seconds 10] [--spells 5]

`bare` replays the torques, surface velocities and friction of the same run into the same compiled models; `closed loop`
is all that `nhtrack run` does in a period: virtual leaders, law, compensation, motor limits, rate correction, friction
by region, telemetry, rows of the recording. Without contact between robots each is a model of its own; `--contact` has
them in one scene. Processor time; the least of several spells.
"""

from __future__ import annotations

import argparse

import mujoco
import numpy as np
from replay import LAWS, Case, least


def main() -> None:
    verbatim = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=verbatim)
    parser.add_argument("--robots", type=int, nargs="*", default=[1, 4, 16, 64])
    parser.add_argument("--contact", type=int, nargs="*", default=[16, 64, 256])
    parser.add_argument("--seconds", type=float, default=10.0, help="length of a run of one robot, shorter for more")
    parser.add_argument("--spells", type=int, default=5)
    given = parser.parse_args()
    print(f"MuJoCo {mujoco.__version__}, physics step 1 ms, control period 10 ms, one thread")
    print("robots  scene        law        bare [us/robot-step]  closed loop  ratio")
    for n in given.robots:
        for law in LAWS:
            _print(n, "one a robot", law, given)
    costs = [_print(n, "one for all", "universal", given, contact=True) for n in given.contact]
    if len(costs) > 1:
        # Cost of a step of the whole scene over the number of robots, both as logarithms.
        slopes = np.polyfit(np.log(given.contact), np.log(np.array(costs) * np.array(given.contact)[:, None]), 1)[0]
        print(f"log-log slope of a step over robots: bare {slopes[0]:.3f}, closed loop {slopes[1]:.3f}")


def _print(n: int, scene: str, law: str, given: argparse.Namespace, *, contact: bool = False) -> tuple[float, float]:
    case = Case(n, law, max(0.3, given.seconds / n**0.5), contact=contact)
    bare, closed = (1e6 * spent / case.robot_steps for spent in least(case, given.spells))
    print(f"{n:6d}  {scene}  {law:10s} {bare:20.2f}  {closed:11.2f}  {closed / bare:5.3f}", flush=True)
    return bare, closed


if __name__ == "__main__":
    main()
