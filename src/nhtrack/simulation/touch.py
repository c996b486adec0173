"""Contacts between robots, noted step by step: who touched whom, for how long and how hard.

Each robot has `SLOTS` places for others that it touches; a pair is noted with one of the two. Robots are convex enough
that of those that touch each other in the plane no more are needed (a planar graph has fewer than three edges a node);
a pair for which neither has a place left is not noted, and each of the two then is noted with three others.
"""

from __future__ import annotations

import math

import numpy as np

from nhtrack.compiled import compiled_inside, float64_at, int64_at
from nhtrack.simulation.motion import Motion, Place, Wheels, fill

SLOTS = 3
#: What is noted of a pair: the other's place among the robots, time in contact [s], impulse of the normal forces [N s],
#: largest speed at which their hulls closed in [m/s], largest overlap of their hulls [m].
FIELDS = ("partner", "time", "impulse", "closing_speed", "overlap")
NOTED = len(FIELDS) + 1  # and the time of the last step in which the pair touched

_PARTNER, _TIME, _IMPULSE, _CLOSING, _OVERLAP, _LAST = range(NOTED)


@compiled_inside
def note_touch(
    wheels: Wheels, place: Place, motion: Motion, b: int, one: int, other: int, contact: int, row: int
) -> None:
    """Notes a contact of two robots in a step.

    The velocity of a contact's normal row is that before the step, so that in the first one it is the closing speed.

    Args:
        wheels: what does not change.
        place: of the thread.
        motion: of all simulations; changed.
        b: which of them.
        one: place of a robot among all of them.
        other: of the other one.
        contact: address of the contact.
        row: of its normal among MuJoCo's constraints.
    """
    touch = motion.touch[b]
    robot, slot = _find(touch, one, other)
    if robot < 0:
        return
    noted = touch[robot, slot]
    if math.isnan(noted[_PARTNER]):
        fill(noted, 0.0)
        noted[_PARTNER] = one + other - robot
        noted[_LAST] = math.nan
    layout = wheels.layout
    now = float64_at(place.data + layout.time)
    if noted[_LAST] != now:  # the first contact of the pair in this step
        noted[_TIME] += wheels.h
        noted[_LAST] = now
    noted[_IMPULSE] += wheels.h * float64_at(int64_at(place.data + layout.efc_force) + 8 * row)
    noted[_CLOSING] = max(noted[_CLOSING], -float64_at(int64_at(place.data + layout.efc_velocity) + 8 * row))
    noted[_OVERLAP] = max(noted[_OVERLAP], -float64_at(contact + layout.distance))


@compiled_inside
def _find(touch: np.ndarray, one: int, other: int) -> tuple[int, int]:
    """Returns with which robot and in which slot a pair is noted, or can be; -1 where neither has a place for it."""
    for robot in (one, other):
        for slot in range(touch.shape[1]):
            if touch[robot, slot, _PARTNER] == one + other - robot:
                return robot, slot
    for robot in (one, other):
        for slot in range(touch.shape[1]):
            if math.isnan(touch[robot, slot, _PARTNER]):
                return robot, slot
    return -1, 0


@compiled_inside
def forget_touches(touch: np.ndarray) -> None:
    """Empties all places of the robots of a simulation, shape (n, SLOTS, NOTED)."""
    for i in range(touch.shape[0]):
        for slot in range(touch.shape[1]):
            fill(touch[i, slot], math.nan)
