"""A physics step in which tyres may slide, without the lift that MuJoCo's friction cone gives them.

For the rows of a contact, normal n and tangential t, with r = reference - J qacc, MuJoCo's convex model asks of a tyre
that slides a load f_n of

    (R_n + mu^2 R_t) f_n = r_n + mu |r_t|.

Coulomb's law has no |r_t|: its h-fold is the slip speed after the step, so that a sliding tyre is thrown up at mu times
its slip, hops, and bears many times its load where it lands. What is too much is taken off the reference of the normal
row, between the two halves of MuJoCo's step. For that r_t has to be foreseen: with the motors of this step and the
forces of the last one it would be r; loads then change by df until the axle gains what r_n says it misses,

    r_t' = r_t - C (mu r_t/|r_t|, 1) df,

with the compliance C of the robot's tyres as it stands. What is foreseen wrongly shows in the next r_n, and is made
good. Where loads would change more than all there is of r_t, the slip is about to end, and r_t stays. A tyre that is
held at its limit by the other one does not slip, and is let alone.

A step before which no tyre slid is MuJoCo's own, to the last bit.
"""

from __future__ import annotations

import math

import numpy as np

from nhtrack.compiled import call_2, call_4, compiled_inside, float64_at, int32_at, int64_at, put_float64
from nhtrack.simulation.attitude import heading_of
from nhtrack.simulation.forces import tyre_of
from nhtrack.simulation.motion import Motion, Place, Wheels
from nhtrack.simulation.plant import length

# [m/s] Slip speed up to which a tyre at its limit may be held by the other one; it is hardly lifted then.
_CREEP = 1e-4
# Share of what a load lifts a tyre by up to which its friction may press it down or lift it. Beyond, a tyre that slides
# tips its robot, and Coulomb's law has no one solution.
_FIRM = 0.5


def firm_friction(compliance: np.ndarray) -> float:
    """Returns the friction from which on a tyre that slides is MuJoCo's own again: it could tip its robot.

    Args:
        compliance: of the tyres, see `nhtrack.simulation.contact.tyre_compliance`.
    """
    tips = (math.hypot(*compliance[row, row - 2 : row]) for row in (2, 5))
    return min(_FIRM * float(compliance[row, row]) / tip for row, tip in zip((2, 5), tips, strict=True) if tip > 0)


@compiled_inside
def rolling_slip(wheels: Wheels, motion: Motion, b: int, robot: int, wheel: int) -> float:
    """Returns the speed of a tyre's lowest point along its robot after the last step [m/s]."""
    now, plant = motion.velocity[b, robot], wheels.plant
    across = plant.half_separation * now[2] * (2 * wheel - 1)
    turned = motion.qvel[b, robot, wheels.wheel_dofs[wheel]] * wheels.radius_factors[wheel]
    return float(plant.radius * ((now[0] + across) / plant.radius - turned))


@compiled_inside
def step_physics(wheels: Wheels, place: Place, motion: Motion, b: int, first: int) -> None:
    """Steps the physics of a unit whose first robot is `first`."""
    last = first + wheels.tyres.shape[0]
    if not (wheels.told_of_slip and _any_slides(wheels, motion, b, first, last)):
        call_2(place.step, place.model, place.data)
        return
    call_2(place.step_1, place.model, place.data)
    _expect(place, motion, last - first)
    rows = int64_at(place.data + wheels.layout.efc_spare)
    call_4(place.to_rows, place.model, place.data, rows, place.scratch)
    _find_contacts(wheels, place, motion, b, first, last)
    for robot in range(first, last):
        _hold_down(wheels, place, motion, b, robot)
    call_2(place.step_2, place.model, place.data)


@compiled_inside
def _any_slides(wheels: Wheels, motion: Motion, b: int, first: int, last: int) -> bool:
    for robot in range(first, last):
        if _slides(wheels, motion, b, robot, 0) or _slides(wheels, motion, b, robot, 1):
            return True
    return False


@compiled_inside
def _slides(wheels: Wheels, motion: Motion, b: int, robot: int, wheel: int) -> bool:
    """Returns whether a tyre was at its limit, or in the air, and slipped; none where friction outdoes its load."""
    tips = length(wheels.compliance[3 * wheel + 2, 3 * wheel], wheels.compliance[3 * wheel + 2, 3 * wheel + 1])
    firm = motion.friction[b, robot, wheel] * tips < _FIRM * wheels.compliance[3 * wheel + 2, 3 * wheel + 2]
    if not (firm and motion.sliding[b, robot, wheel]):
        return False
    return length(rolling_slip(wheels, motion, b, robot, wheel), motion.velocity[b, robot, 1]) > _CREEP


@compiled_inside
def _expect(place: Place, motion: Motion, robots: int) -> None:
    """Writes the accelerations of a step with its motors and the forces of the step before."""
    count = 8 * motion.qvel.shape[2] * robots
    for i in range(0, count, 8):
        put_float64(place.scratch + i, float64_at(place.warmstart + i) - float64_at(place.unheld + i))
    call_2(place.actuate, place.model, place.data)
    call_2(place.accelerate, place.model, place.data)
    for i in range(0, count, 8):
        put_float64(place.scratch + i, float64_at(place.scratch + i) + float64_at(place.unheld + i))


@compiled_inside
def _find_contacts(wheels: Wheels, place: Place, motion: Motion, b: int, first: int, last: int) -> None:
    """Notes the contacts of a unit's tyres."""
    for robot in range(first, last):
        motion.contact[b, robot, 0] = motion.contact[b, robot, 1] = 0
    at = int64_at(place.data + wheels.layout.contact)
    for _ in range(int32_at(place.data + wheels.layout.ncon)):
        tyre = tyre_of(wheels, at)[0]
        if tyre >= 0 and int32_at(at + wheels.layout.efc_address) >= 0:
            motion.contact[b, first + tyre // 2, tyre % 2] = at
        at += wheels.layout.contact_size


@compiled_inside
def _hold_down(wheels: Wheels, place: Place, motion: Motion, b: int, robot: int) -> None:
    """Takes mu |r_t'| off the normal references of a robot's tyres that slide, unless their slip ends in this step."""
    heading = heading_of(wheels.planar, motion.qpos[b, robot])
    left = _missing(wheels, place, motion, b, robot, 0, heading)
    right = _missing(wheels, place, motion, b, robot, 1, heading)
    push_left, push_right = _push(wheels, motion, b, robot, 0, left), _push(wheels, motion, b, robot, 1, right)
    more_left, more_right = _more_load(wheels, motion, b, robot, (left[2] + right[2]) / 2)
    for wheel in range(2):
        contact, missing = motion.contact[b, robot, wheel], left if wheel == 0 else right
        if contact == 0 or not _slides(wheels, motion, b, robot, wheel):
            continue
        along = _moved(wheels, 3 * wheel, more_left, push_left, more_right, push_right)
        across = _moved(wheels, 3 * wheel + 1, more_left, push_left, more_right, push_right)
        share = 1.0 if length(along, across) < length(missing[0], missing[1]) else 0.0
        along, across = missing[0] - share * along, missing[1] - share * across
        references = int64_at(place.data + wheels.layout.efc_reference)
        wanted = _of_contact(wheels, contact, references, heading)
        if along * wanted[0] + across * wanted[1] > 0:
            normal = references + 8 * int32_at(contact + wheels.layout.efc_address)
            put_float64(normal, float64_at(normal) - motion.friction[b, robot, wheel] * length(along, across))


@compiled_inside
def _missing(
    wheels: Wheels, place: Place, motion: Motion, b: int, robot: int, wheel: int, heading: float
) -> tuple[float, float, float]:
    """Returns r of a tyre, along and across its robot and upwards; nothing for one that does not touch."""
    contact = motion.contact[b, robot, wheel]
    if contact == 0:
        return 0.0, 0.0, 0.0
    wanted = _of_contact(wheels, contact, int64_at(place.data + wheels.layout.efc_reference), heading)
    found = _of_contact(wheels, contact, int64_at(place.data + wheels.layout.efc_spare), heading)
    return wanted[0] - found[0], wanted[1] - found[1], wanted[2] - found[2]


@compiled_inside
def _of_contact(wheels: Wheels, contact: int, rows: int, heading: float) -> tuple[float, float, float]:
    """Returns what an array of all constraints has for a contact, along and across a robot and along the normal."""
    row, axes = rows + 8 * int32_at(contact + wheels.layout.efc_address), contact + wheels.layout.frame
    one, other = float64_at(row + 8), float64_at(row + 16)
    x = one * float64_at(axes + 24) + other * float64_at(axes + 48)
    y = one * float64_at(axes + 32) + other * float64_at(axes + 56)
    cosine, sine = math.cos(heading), math.sin(heading)
    return cosine * x + sine * y, cosine * y - sine * x, float64_at(row)


@compiled_inside
def _push(
    wheels: Wheels, motion: Motion, b: int, robot: int, wheel: int, missing: tuple[float, float, float]
) -> tuple[float, float]:
    """Returns the friction of a tyre that comes with each newton of its load, along and across; none where it holds."""
    size = length(missing[0], missing[1])
    slides = size > 0 and _slides(wheels, motion, b, robot, wheel)
    share = motion.friction[b, robot, wheel] / size if slides else 0.0
    return share * missing[0], share * missing[1]


@compiled_inside
def _more_load(wheels: Wheels, motion: Motion, b: int, robot: int, missing: float) -> tuple[float, float]:
    """Returns what has to come to the loads so that an axle gains what it misses upwards; no load is below zero.

    Both tyres get as much: where more than three supports share a robot, what tilts its axle says nothing of loads.
    """
    own, cross = (wheels.compliance[2, 2] + wheels.compliance[5, 5]) / 2, wheels.compliance[2, 5]
    if motion.contact[b, robot, 0] == 0 or motion.contact[b, robot, 1] == 0:
        missing, cross = 2 * missing, 0.0
    more = missing / (own + cross)
    return max(more, -motion.force[b, robot, 0, 2]), max(more, -motion.force[b, robot, 1, 2])


@compiled_inside
def _moved(
    wheels: Wheels, row: int, more: float, push: tuple[float, float], another: float, other: tuple[float, float]
) -> float:
    """Returns by how much more loads and their friction speed up a row of the compliance."""
    gains = wheels.compliance[row]
    by_left = gains[0] * push[0] + gains[1] * push[1] + gains[2]
    by_right = gains[3] * other[0] + gains[4] * other[1] + gains[5]
    return float(more * by_left + another * by_right)
