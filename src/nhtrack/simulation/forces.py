"""Forces of the floor on the tyres and contacts between robots, from MuJoCo's list: sensors of them cost O(n^2)."""

from __future__ import annotations

from nhtrack.compiled import compiled_inside, float64_at, int32_at, int64_at
from nhtrack.simulation.motion import Motion, Place, Wheels, fill
from nhtrack.simulation.plant import length, wheel_utilisation
from nhtrack.simulation.touch import note_touch

# Share of the friction limit from which a wheel counts as sliding within a physics step.
SLIDING = 1 - 1e-6


@compiled_inside
def read_forces(wheels: Wheels, place: Place, motion: Motion, b: int, first: int) -> None:
    """Reads the forces of the floor on the tyres of a unit, in the world frame, and what its robots touch.

    `first` is the unit's first robot.
    """
    layout = wheels.layout
    force, can_touch = motion.force[b], motion.touch.shape[1] > 0
    for i in range(wheels.tyres.shape[0]):
        for wheel in range(2):
            fill(force[first + i, wheel], 0.0)
    at = int64_at(place.data + layout.contact)
    forces = int64_at(place.data + layout.efc_force)
    for _ in range(int32_at(place.data + layout.ncon)):
        row, (tyre, sign) = int32_at(at + layout.efc_address), tyre_of(wheels, at)
        if row >= 0 and tyre >= 0:
            axes, parts = at + layout.frame, forces + 8 * row
            on_tyre = force[first + tyre // 2, tyre % 2]
            for axis in range(3):
                pushed = float64_at(axes + 8 * axis) * float64_at(parts)
                pushed += float64_at(axes + 24 + 8 * axis) * float64_at(parts + 8)
                pushed += float64_at(axes + 48 + 8 * axis) * float64_at(parts + 16)
                on_tyre[axis] += sign * pushed
        elif row >= 0 and can_touch:
            one = wheels.owners[int32_at(at + layout.geom)]
            another = wheels.owners[int32_at(at + layout.geom + 4)]
            if one >= 0 and another >= 0 and one != another:
                place_one, place_another = first + one + wheels.first_body, first + another + wheels.first_body
                note_touch(wheels, place, motion, b, place_one, place_another, at, row)
        at += layout.contact_size


@compiled_inside
def tyre_of(wheels: Wheels, contact: int) -> tuple[int, float]:
    """Returns which tyre of a unit meets the floor in the contact at an address, -1 for none, and who pushes it.

    The normal points from the first geom to the second, which the force pushes along it: 1 where that is the tyre.
    """
    geom = contact + wheels.layout.geom
    role, other = wheels.roles[int32_at(geom)], wheels.roles[int32_at(geom + 4)]
    if role == -2 and other >= 0:
        return other, 1.0
    return (role, -1.0) if other == -2 and role >= 0 else (-1, 0.0)


@compiled_inside
def note_forces(motion: Motion, b: int, robot: int) -> None:
    """Adds the loads of a step to those of its period; notes who slides, and the largest friction utilisation."""
    for wheel in range(2):
        force, noted = motion.force[b, robot, wheel], motion.rolled[b, robot, wheel]
        noted[3] += force[2]
        limit, used = motion.friction[b, robot, wheel] * max(force[2], 0.0), length(force[0], force[1])
        noted[4] = max(noted[4], wheel_utilisation(used, limit))
        motion.sliding[b, robot, wheel] = used >= SLIDING * limit
