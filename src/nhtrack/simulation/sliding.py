"""A physics step in which tyres may slide, without the lift that MuJoCo's friction cone gives them.

For the rows of a contact, normal n and tangential t, with r = reference - J qacc, MuJoCo's convex model asks that a tyre
that slides has the load f_n of

    (R_n + mu^2 R_t) f_n = r_n + mu |r_t|.

Coulomb's law has no |r_t|: its h-fold is the slip speed after the step, so that a sliding tyre is thrown up at mu times
its slip, hops, and bears many times its load where it lands. What is too much is therefore taken off the reference of
the normal row, between the two halves of MuJoCo's step. `J qacc` is that of the step before: while a tyre slides loads
hardly change from one step to the next, and where they do the error falls off geometrically, by the factor
c/(1 + c) a step with c = mu^2 times normal mass over tangential mass. Steps in which nothing slid before are MuJoCo's own.
"""

from __future__ import annotations

from nhtrack.compiled import call_2, call_4, compiled_inside, float64_at, int32_at, int64_at, put_float64
from nhtrack.simulation.forces import tyre_of
from nhtrack.simulation.motion import Motion, Place, Wheels
from nhtrack.simulation.plant import length


@compiled_inside
def step_physics(wheels: Wheels, place: Place, motion: Motion, b: int, first: int) -> None:
    """Steps the physics of a unit whose first robot is `first`."""
    if wheels.told_of_slip and _any_slides(wheels, motion, b, first):
        call_2(place.step_1, place.model, place.data)
        _hold_down(wheels, place, motion, b, first)
        call_2(place.step_2, place.model, place.data)
    else:
        call_2(place.step, place.model, place.data)


@compiled_inside
def _any_slides(wheels: Wheels, motion: Motion, b: int, first: int) -> bool:
    for robot in range(first, first + wheels.tyres.shape[0]):
        if motion.sliding[b, robot, 0] or motion.sliding[b, robot, 1]:
            return True
    return False


@compiled_inside
def _hold_down(wheels: Wheels, place: Place, motion: Motion, b: int, first: int) -> None:
    """Takes mu |r_t| off the references of the normal rows of tyres that slide, unless their slip ends in this step."""
    layout, data = wheels.layout, place.data
    gained, references = int64_at(data + layout.efc_spare), int64_at(data + layout.efc_reference)
    _expect(place, wheels.tyres.shape[0] * motion.qvel.shape[2])
    call_4(place.to_rows, place.model, data, gained, place.scratch)
    at = int64_at(data + layout.contact)
    for _ in range(int32_at(data + layout.ncon)):
        row, tyre = int32_at(at + layout.efc_address), tyre_of(wheels, at)[0]
        if row >= 0 and tyre >= 0 and motion.sliding[b, first + tyre // 2, tyre % 2]:
            friction, normal = motion.friction[b, first + tyre // 2, tyre % 2], references + 8 * row
            along, across = float64_at(normal + 8), float64_at(normal + 16)
            left_along = along - float64_at(gained + 8 * row + 8)
            left_across = across - float64_at(gained + 8 * row + 16)
            if along * left_along + across * left_across > 0:
                put_float64(normal, float64_at(normal) - friction * length(left_along, left_across))
        at += layout.contact_size


@compiled_inside
def _expect(place: Place, count: int) -> None:
    """Writes the accelerations to expect in this step: with its motors, and with the forces of the step before."""
    for i in range(0, 8 * count, 8):
        put_float64(place.scratch + i, float64_at(place.warmstart + i) - float64_at(place.unheld + i))
    call_2(place.actuate, place.model, place.data)
    call_2(place.accelerate, place.model, place.data)
    for i in range(0, 8 * count, 8):
        put_float64(place.scratch + i, float64_at(place.scratch + i) + float64_at(place.unheld + i))
