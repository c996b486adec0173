"""Robots with habits drawn at random, now and then with a fault."""

from __future__ import annotations

import random
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from nhtrack.robots.contract import Hints
from odd_robots.faults import FAULTS
from odd_robots.habit import GROUPS
from odd_robots.habits import HABITS
from odd_robots.plain import plain_robot

EVERY = 8  # every so many variants has a fault, too

# Habits that leave alone what faults change.
BESIDE_FAULTS = ("losses", "world", "defaults")


class Variant(NamedTuple):
    """A robot, what it was made of, its fault if it has one, and what a scenario has to say of it."""

    robot: ET.Element
    made_of: tuple[str, ...]
    fault: str
    hints: Hints


def variants(count: int, seed: int) -> Iterator[Variant]:
    """Yields robots of habits drawn at random, one of a group at most."""
    draw = random.Random(seed)
    for number in range(count):
        fault = draw.choice(sorted(FAULTS)) if number % EVERY == EVERY - 1 else ""
        open_to = BESIDE_FAULTS if fault else GROUPS
        picked = [draw.choice([n for n, h in HABITS.items() if h.group == g]) for g in open_to if draw.random() < 0.6]
        forward = next((HABITS[name].forward for name in picked if HABITS[name].forward), "")
        yield Variant(made(picked, *([fault] if fault else [])), tuple(picked), fault, Hints(forward=forward))


def made(habits: Sequence[str], *faults: str) -> ET.Element:
    """Returns a plain robot with some habits, and some faults."""
    robot = plain_robot()
    for name in habits:
        HABITS[name].change(robot)
    for name in faults:
        FAULTS[name].change(robot)
    return robot
