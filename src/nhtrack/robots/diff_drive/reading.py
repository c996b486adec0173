"""Reads a differential drive from a file that somebody else wrote."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco

from nhtrack.robots.contract import Parts, Refusal, RefusedRobot
from nhtrack.robots.diff_drive.actuators import read_motor
from nhtrack.robots.diff_drive.identification import identify
from nhtrack.robots.diff_drive.leftovers import leftovers, unknown_to_model
from nhtrack.robots.diff_drive.model import DiffDrive
from nhtrack.robots.diff_drive.roles import find_roles
from nhtrack.robots.diff_drive.stance import read_stance
from nhtrack.robots.diff_drive.tyres import Axle, read_axle, read_tyre
from nhtrack.robots.diff_drive.writing import Found, write_robot
from nhtrack.robots.kind import Kind, Reading
from nhtrack.robots.reading.source import Source
from nhtrack.robots.reading.standard import bare

__all__ = ["KIND"]


def read(source: Source) -> Reading:
    """Returns a differential drive as it was read.

    Raises:
        RefusedRobot: it is none, or has what the reduced model does not know of; all reasons at once.
    """
    roles = find_roles(source)
    drawn = [read_tyre(source, joint) for joint in roles.wheels]
    motor, motor_refusals, motor_notes, motor_source = read_motor(source, roles.wheels, roles.pulls)
    refusals = [*unknown_to_model(source, roles), *motor_refusals, *(each for _, own in drawn for each in own)]
    tyres = [tyre for tyre, _ in drawn if tyre is not None]
    if len(tyres) < 2:
        raise RefusedRobot(source.file, refusals)
    axle, own = read_axle(source, roles.root, tyres)
    if own:
        raise RefusedRobot(source.file, [*refusals, *own])
    stance, own = read_stance(source, roles, axle)
    if refusals or own:
        raise RefusedRobot(source.file, [*refusals, *own])
    mjcf, parts, sources = write_robot(Found(source, roles, axle, stance))
    try:
        alone = mujoco.MjModel.from_xml_string(bare(mjcf))
    except ValueError as error:
        raise RefusedRobot(source.file, [Refusal("", f"its standard form does not compile: {error}")]) from error
    model = identify(alone, parts, motor)
    refusals = [*_tipping(model), *_uneven(source, axle, alone, parts, model), *_braked(source, axle, model)]
    if refusals:
        raise RefusedRobot(source.file, refusals)
    notes = (*source.notes, *leftovers(source, roles), *axle.notes, *stance.notes, *motor_notes)
    return Reading(source.file, KIND.name, mjcf, parts, model, sources | {"motors": motor_source}, notes)


KIND = Kind("diff_drive", read)
_EVEN = 1e-5  # how much the wheels' spin inertias may differ, over the robot's mass times the wheel's radius squared


def _uneven(source: Source, axle: Axle, alone: mujoco.MjModel, parts: Parts, model: DiffDrive) -> Iterator[Refusal]:
    """Yields that the wheels' spin inertias differ by what the robot's motion shows."""
    spins = [float(alone.dof_M0[alone.joint(name).dofadr[0]]) for name in parts.wheel_joints]
    if abs(spins[0] - spins[1]) > _EVEN * model.mass * model.wheel_radius**2:
        one, two = (source.element("joint", tyre.joint) for tyre in (axle.left, axle.right))
        yield Refusal(
            one, f"its wheel's inertia of {spins[0]:.6g} kg m^2 is not that of {two}, {spins[1]:.6g}: make them equal"
        )


def _braked(source: Source, axle: Axle, model: DiffDrive) -> Iterator[Refusal]:
    """Yields that dry friction holds a wheel against all that its motor has."""
    limit = model.motor.torque_limit
    for tyre, dry in zip((axle.left, axle.right), model.losses.dry_friction, strict=True):
        if dry >= limit:
            name = source.element("joint", tyre.joint)
            yield Refusal(name, f"its frictionloss of {dry:.4g} N m holds it against the {limit:.4g} N m of its motor")


def _tipping(model: DiffDrive) -> list[Refusal]:
    lifted = [name for name, load in model.support_loads().items() if load <= 0]
    if not lifted:
        return []
    x, y = model.com[:2]
    said = f"its centre of mass lies at ({x:.3g}, {y:.3g}) m from the axle's middle"
    return [Refusal("", f"it tips by itself: {said}, and the {' and the '.join(lifted)} would lift")]
