"""What a habit is: a change of a plain robot, and what is read differently because of it."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from nhtrack.robots.contract import Hints
from odd_robots.plain import HALF_SEPARATION, MASS, RADIUS, TORQUE

Change = Callable[[ET.Element], None]

#: Every habit by its name.
HABITS: dict[str, Habit] = {}

#: What habits are about, in the order in which a robot gets them: who writes names comes last.
GROUPS = ("tyres", "axes", "motors", "order", "losses", "casters", "world", "arms", "contacts", "origin", "heading",
          "defaults", "structure", "spelling", "names")  # fmt: skip

#: What is read of the plain robot, by the names of `numbers` in test_habits.
PLAIN: Mapping[str, Any] = {
    "wheel_radius": RADIUS,
    "half_separation": HALF_SEPARATION,
    "mass": MASS,
    "torque_limit": TORQUE,
    "no_load_speed": float("inf"),
    "com": (-0.04 / MASS, 0.0, RADIUS + 0.02 / MASS),
    "casters": ((-0.08, 0.0),),
    "damping": (0.0, 0.0),
    "frictionloss": (0.0, 0.0),
    "wheel_inertia": 4e-4,
    "lean": 0.0,  # [rad] by how much it stands nose up
}


@dataclass(frozen=True)
class Habit:
    """A habit of robots' files.

    Attributes:
        change: makes a plain robot have it.
        group: habits of one group exclude each other.
        reads: what is read differently.
        adds: bodies it adds: mass [kg] and place [m] in the chassis' frame.
        hints: what a scenario has to say with it.
        forward: what it may say to be sure, whichever way wheels turn that turn forward.
    """

    change: Change
    group: str
    reads: Mapping[str, Any] = field(default_factory=dict)
    adds: tuple[tuple[float, tuple[float, float, float]], ...] = ()
    hints: Hints = field(default_factory=Hints)
    forward: str = ""


def habit(
    group: str,
    *,
    adds: tuple[tuple[float, tuple[float, float, float]], ...] = (),
    hints: Hints | None = None,
    forward: str = "",
    **reads: Any,
) -> Callable[[Change], Change]:
    """Returns a decorator that makes a change of a robot a habit with the change's name."""

    def keep(change: Change) -> Change:
        HABITS[change.__name__] = Habit(change, group, reads, adds, hints or Hints(), forward)
        return change

    return keep


def expected(*habits: Habit) -> dict[str, Any]:
    """Returns what is read of the plain robot with some habits."""
    numbers = dict(PLAIN)
    masses = [(MASS, PLAIN["com"])]
    for each in habits:
        numbers |= each.reads
        masses += [(m, (x, y, z + RADIUS)) for m, (x, y, z) in each.adds]
    total = sum(m for m, _ in masses)
    x, y, z = (sum(m * place[k] for m, place in masses) / total for k in range(3))
    cos, sin = math.cos(numbers["lean"]), math.sin(numbers["lean"])
    high = z - RADIUS
    return numbers | {"mass": total, "com": (x * cos - high * sin, y, RADIUS + high * cos + x * sin)}
