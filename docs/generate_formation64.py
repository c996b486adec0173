"""Writes scenarios/stress/formation64.yaml: a wedge of 64 robots, six levels below its leader.

    python docs/generate_formation64.py

Row k of the wedge has 3 k robots and stands k depths behind the leader, in gaps of the row before it. A robot in a gap
has the two robots beside the gap as parents and stands straight behind the virtual leader between them; the two at
either end of a row have the last robot of the row before.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

FILE = Path(__file__).resolve().parents[1] / "scenarios" / "stress" / "formation64.yaml"

LEVELS = 6
DEPTH, GAP = 0.4, 0.32  # [m] between rows, and between the robots of a row
LAG = 0.2  # [m] how much farther apart the rows start
SCATTER = (0.06, 0.04, 0.2)  # [m, m, rad] how far each start is moved, at most
SEED = 64

HEADER = """\
# A wedge of 64 robots: one leader and six levels of followers, most of them with two parents.
#
# Row k has 3 k robots, {depth} m behind the row before it and {gap} m apart. A robot behind a gap tracks
# the virtual leader between the two robots beside the gap; the two at either end of a row track the last
# robot of the row before. The wedge starts drawn out, every row {lag} m too far behind the one before, and
# every robot up to {x} m, {y} m and {theta} rad from there; it closes up while it drives. Robots touch each
# other here, as they would.
#
# Written by docs/generate_formation64.py; change that and run it again.

name: formation64
description: "A wedge of 64 robots, six levels deep, on a winding road"

duration: 40.0                                   # [s]; no similarity: metres and seconds
physics: {{robot_contact: true}}
control_rate: 100                                # [Hz]

leader:
  name: r0
  start: {{pose: [0, 0, 0]}}
  input:
    u_x:
      - {{until: 4, value: 0.075}}                 # to 0.3 m/s
      - {{value: 0}}
    u_theta: "0.006*where(t < 20, 1, -1)*sin(2*pi*t/20)"

followers:
"""

FOOTER = """
virtual_leader: convex
formation: printed

# Gains from a search on the ideal model. k is far below 2 (1 + ke/kp) and the dead zone is wide on purpose:
# what a robot's steering does is fed forward to those behind it, and with gains above the bound the limit
# cycle of each level shakes the next one harder, until the last levels are lost. With these a place is kept
# to within the dead zone.
law: {name: published, variant: published, kp: 0.94, kd: 2.2, ke: 0.33, k: 0.18, dead_zone: {length: 0.045}}
"""


def followers() -> Iterator[tuple[int, list[int], tuple[float, float], tuple[float, float]]]:
    """Yields every follower's number, its parents, its offset from what it tracks [m], and where it starts [m]."""
    rows = [[0]]
    for k in range(1, LEVELS + 1):
        before, first = rows[-1], rows[-1][-1] + 1
        rows.append(list(range(first, first + 3 * k)))
        for j, robot in enumerate(rows[-1]):
            y = GAP * ((3 * k - 1) / 2 - j)
            beside = j - 1.5 + 0.5 * (k == 1)  # in the row before, counted in robots
            low, high = (int(np.clip(round(beside + side), 0, len(before) - 1)) for side in (-0.5, 0.5))
            parents = sorted({before[low], before[high]})
            across = np.mean([GAP * ((len(before) - 1) / 2 - before.index(parent)) for parent in parents])
            yield robot, parents, (-DEPTH, float(round(y - across, 9)) + 0.0), (-k * (DEPTH + LAG), y)


def line(robot: int, parents: list[int], offset: tuple[float, float], start: np.ndarray) -> str:
    """Returns a follower as a line of YAML."""
    tracked = ", ".join(f"r{parent}" for parent in parents)
    pose = ", ".join(f"{value:.3f}" for value in start)
    return (
        f"  - {{name: r{robot}, parents: [{tracked}], offset: [{offset[0]:g}, {offset[1]:g}], "
        f"start: {{pose: [{pose}]}}}}\n"
    )


def scenario() -> str:
    """Returns the scenario file."""
    random = np.random.default_rng(SEED)
    lines = []
    for robot, parents, offset, start in followers():
        scatter = random.uniform(-1, 1, 3) * SCATTER
        lines.append(line(robot, parents, offset, np.array([*start, 0.0]) + scatter))
    x, y, theta = SCATTER
    header = HEADER.format(depth=DEPTH, gap=GAP, lag=LAG, x=x, y=y, theta=theta)
    return header + "".join(lines) + FOOTER


def main() -> None:
    """Writes the scenario."""
    FILE.parent.mkdir(exist_ok=True)
    FILE.write_text(scenario(), encoding="utf-8")


if __name__ == "__main__":
    main()
