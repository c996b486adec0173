"""Writes the wedges of scenarios/stress: formation64, six levels below its leader, and formation1000, 26 levels.

    python docs/_generate/generate_formation64.py

Row k of a wedge has 3 k robots and stands k depths behind the leader, in gaps of the row before it; of the last row,
as many as are left stand in its middle. A robot in a gap has the two robots beside the gap as parents and stands
straight behind the virtual leader between them; the two at either end of a row have the last robot of the row before.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parents[2] / "scenarios" / "stress"

DEPTH, GAP = 0.4, 0.32  # [m] between rows, and between the robots of a row


@dataclass(frozen=True)
class Wedge:
    """A wedge and the texts around its list of followers.

    Attributes:
        robots: how many, the leader among them.
        lag: how much farther apart the rows start [m].
        scatter: how far each start is moved, at most [m, m, rad].
        turn: largest yaw acceleration of the leader [rad/s^2].
        seed: of the starts.
        header: what comes before the followers.
        footer: what comes after them.
    """

    robots: int
    lag: float
    scatter: tuple[float, float, float]
    turn: float
    seed: int
    header: str
    footer: str


ROWS = """\
# Row k has 3 k robots, {depth} m behind the row before it and {gap} m apart. A robot behind a gap tracks
# the virtual leader between the two robots beside the gap; the two at either end of a row track the last
# robot of the row before."""

LEADER = """
leader:
  name: r0
  start: {{pose: [0, 0, 0]}}
  input:
    u_x:
      - {{until: 4, value: 0.075}}                 # to 0.3 m/s
      - {{value: 0}}
    u_theta: "{turn}*where(t < 20, 1, -1)*sin(2*pi*t/20)"

followers:
"""

LAW = """
virtual_leader: convex
formation: printed

# Gains from a search on the ideal model. k is far below 2 (1 + ke/kp) and the dead zone is wide on purpose:
# what a robot's steering does is fed forward to those behind it, and with gains above the bound the limit
# cycle of each level shakes the next one harder, until the last levels are lost. With these a place is kept
# to within the dead zone.
law: {name: published, variant: published, kp: 0.94, kd: 2.2, ke: 0.33, k: 0.18, dead_zone: {length: 0.045}}
"""

FORMATION64 = Wedge(
    robots=64,
    lag=0.2,
    scatter=(0.06, 0.04, 0.2),
    turn=0.006,
    seed=64,
    header="""\
# A wedge of 64 robots: one leader and six levels of followers, most of them with two parents.
#
"""
    + ROWS
    + """ The wedge starts drawn out, every row {lag} m too far behind the one before, and
# every robot up to {x} m, {y} m and {theta} rad from there; it closes up while it drives. Robots touch each
# other here, as they would.
#
# Written by docs/_generate/generate_formation64.py; change that and run it again.

name: formation64
description: "A wedge of 64 robots, six levels deep, on a winding road"

duration: 40.0                                   # [s]; no similarity: metres and seconds
physics: {{robot_contact: true}}
control_rate: 100                                # [Hz]
"""
    + LEADER,
    footer=LAW,
)

FORMATION1000 = Wedge(
    robots=1000,
    lag=0.0,
    scatter=(0.03, 0.03, 0.1),
    turn=0.002,
    seed=1000,
    header="""\
# A wedge of 1000 robots: one leader and 26 levels of followers, most of them with two parents.
#
"""
    + ROWS
    + """ Of the last row only the middle is there. Every robot starts up to {x} m, {y} m
# and {theta} rad from its place. Robots do not touch each other here: each is stepped alone.
#
# Written by docs/_generate/generate_formation64.py; change that and run it again.

name: formation1000
description: "A wedge of 1000 robots, 26 levels deep, sets off"

duration: 10.0                                   # [s]; no similarity: metres and seconds
physics: {{timestep: 0.002}}
control_rate: 50                                 # [Hz]
"""
    + LEADER,
    footer="""
virtual_leader: convex
formation: printed

# What a robot does about its error is fed forward to those behind it: with the gains of formation64, which has
# six levels, the last of 26 would be asked for three times what its wheels can do. With these a robot follows
# in step with those ahead and mends its place slowly.
law: {name: published, variant: published, kp: 0.1, kd: 0.7, ke: 0.02, k: 0.05, dead_zone: {length: 0.045}}
""",
)

WEDGES = {"formation64": FORMATION64, "formation1000": FORMATION1000}


def rows(robots: int) -> Iterator[tuple[int, int]]:
    """Yields how many places each row behind the leader has, and how many of them are taken, in its middle."""
    left, places = robots - 1, 3
    while left > 0:
        yield places, min(left, places)
        left, places = left - places, places + 3


def followers(wedge: Wedge) -> Iterator[tuple[int, list[int], tuple[float, float], tuple[float, float]]]:
    """Yields every follower's number, its parents, its offset from what it tracks [m], and where it starts [m]."""
    before = [0]
    for k, (places, taken) in enumerate(rows(wedge.robots), start=1):
        first, skipped = before[-1] + 1, (places - taken) // 2
        for j in range(skipped, skipped + taken):
            y = GAP * ((places - 1) / 2 - j)
            beside = j - 1.5 + 0.5 * (k == 1)  # in the row before, counted in robots
            low, high = (int(np.clip(round(beside + side), 0, len(before) - 1)) for side in (-0.5, 0.5))
            parents = sorted({before[low], before[high]})
            across = np.mean([GAP * ((len(before) - 1) / 2 - before.index(parent)) for parent in parents])
            offset = (-DEPTH, float(round(y - across, 9)) + 0.0)
            yield first + j - skipped, parents, offset, (-k * (DEPTH + wedge.lag), y)
        before = list(range(first, first + taken))


def line(robot: int, parents: list[int], offset: tuple[float, float], start: np.ndarray) -> str:
    """Returns a follower as a line of YAML."""
    tracked = ", ".join(f"r{parent}" for parent in parents)
    pose = ", ".join(f"{value:.3f}" for value in start)
    return (
        f"  - {{name: r{robot}, parents: [{tracked}], offset: [{offset[0]:g}, {offset[1]:g}], "
        f"start: {{pose: [{pose}]}}}}\n"
    )


def scenario(wedge: Wedge = FORMATION64) -> str:
    """Returns the scenario file of a wedge."""
    random = np.random.default_rng(wedge.seed)
    lines = []
    for robot, parents, offset, start in followers(wedge):
        scatter = random.uniform(-1, 1, 3) * wedge.scatter
        lines.append(line(robot, parents, offset, np.array([*start, 0.0]) + scatter))
    x, y, theta = wedge.scatter
    header = wedge.header.format(depth=DEPTH, gap=GAP, lag=wedge.lag, turn=wedge.turn, x=x, y=y, theta=theta)
    return header + "".join(lines) + wedge.footer


def main() -> None:
    """Writes the scenarios."""
    FOLDER.mkdir(exist_ok=True)
    for name, wedge in WEDGES.items():
        (FOLDER / f"{name}.yaml").write_text(scenario(wedge), encoding="utf-8")


if __name__ == "__main__":
    main()
