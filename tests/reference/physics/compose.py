"""Writes the MJCF of a whole scene, contact sensors included: what moves, not what it looks like."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nhtrack import assets
from nhtrack.mjcf import from_path
from nhtrack.robots.diff_drive.identification import Parts

if TYPE_CHECKING:
    from pathlib import Path

    from nhtrack.robots.diff_drive import DiffDrive
    from nhtrack.simulation.scene import Payload, SceneSpec

# Impedance so close to one that penetration, and with it the change of the rolling radius, is a few nanometres.
_STIFF_SOLIMP = (0.9999, 0.9999, 0.001)
# A dense Jacobian is quicker for a handful of robots and ruinous for dozens (docs/fidelity.md).
_DENSE_ROBOTS = 4


def compose(spec: SceneSpec, robot_file: Path, drive: DiffDrive, parts: Parts) -> Any:
    """Returns the MJCF element of a scene."""
    arena = from_path(assets.models_directory() / "arena" / "scene.xml")
    arena.compiler.remove()  # how a robot's file is read is the robot's to say; the arena has no angles
    _set_options(arena, spec)
    for name in spec.bodies:
        robot = from_path(robot_file)
        robot.model = name
        _set_contacts(robot, spec, parts)
        _set_wheels(robot, spec, drive, parts)
        if spec.payload is not None:
            _add_payload(robot, parts.chassis, spec.payload, drive.wheel_radius)
        _attach(arena, robot, spec, drive, parts)
    if spec.virtual_root:
        arena.worldbody.add("body", name=spec.robots[0], mocap=True)
    return arena


def _set_options(arena: Any, spec: SceneSpec) -> None:
    option = arena.option
    option.timestep = spec.timestep
    option.gravity = spec.ground.gravity  # the plane stays level in its own frame; on a slope gravity leans
    option.integrator = "implicitfast"
    option.cone = "elliptic"  # the pyramid loses 29 % of the friction limit at 45 degrees
    option.solver = "Newton"
    option.impratio = 1  # more would shrink the creep of friction, which the rate correction makes up for anyway, and
    # sharpen the cones: at 10 the solver now and then ends a step beside the solution
    option.tolerance = 1e-15  # at 1e-12 a step near the limit of friction now and then ends beside the solution
    option.iterations = 100
    option.ls_iterations = 200  # with the 50 of the default a line search in a sliding contact may not end
    option.jacobian = "dense" if len(spec.bodies) <= _DENSE_ROBOTS else "sparse"
    option.flag.autoreset = "disable"  # a diverged state is an error to report, not one to hide by a reset


def _set_contacts(robot: Any, spec: SceneSpec, parts: Parts) -> None:
    """Writes contact parameters and collision masks into one robot's MJCF."""
    on_floor = parts.tyres if spec.base == "planar" else (*parts.tyres, *parts.casters)
    for name in parts.collision_geoms:
        geom = robot.find("geom", name)
        # The floor's type is 1: robots see it by their affinity 1, and each other only by type and affinity 2.
        geom.contype, geom.conaffinity = (2, 3) if spec.robot_contact else (0, 1)
        if spec.contact == "stiff" and name in (*parts.tyres, *parts.casters):
            geom.solref, geom.solimp = (2 * spec.timestep, 1), _STIFF_SOLIMP
        if name in parts.casters and name not in on_floor:
            geom.contype = geom.conaffinity = 0  # the base holds the robot level
    for name in parts.tyres:
        geom = robot.find("geom", name)
        geom.friction, geom.condim, geom.priority = (spec.friction, 0.005, 0.0001), 3, 1
        robot.sensor.add("contact", name=name, geom1=geom, data="force", reduce="netforce", num=1)
    for name in parts.casters:
        geom = robot.find("geom", name)
        geom.condim, geom.priority = 1, 1


def _set_wheels(robot: Any, spec: SceneSpec, drive: DiffDrive, parts: Parts) -> None:
    """Makes the left tyre larger than the right one by the mismatch, and motors take torques at the wheel."""
    for name, factor in zip(parts.tyres, spec.radius_factors, strict=True):
        geom = robot.find("geom", name)
        size = geom.size if geom.size is not None else geom.dclass.geom.size
        geom.size = factor * np.asarray(size)
    for name in parts.motors:
        motor = robot.find("actuator", name)
        motor.gear, motor.ctrlrange = (1,), (-drive.motor.torque_limit, drive.motor.torque_limit)
        if motor.tag == "general":
            motor.gainprm = (1,)


def _add_payload(robot: Any, chassis: str, payload: Payload, wheel_radius: float) -> None:
    """Adds a box of uniform density to a robot's chassis, called `payload` where the robot has no such part itself."""
    name = "payload"
    while robot.find("body", name) is not None or robot.find("geom", name) is not None:
        name += "_"
    x, y, height = payload.position
    size = np.asarray(payload.size) / 2
    inertia = payload.mass / 3 * (size @ size - size**2)
    body = robot.find("body", chassis).add("body", name=name, pos=(x, y, height - wheel_radius))
    body.add("inertial", pos=(0, 0, 0), mass=payload.mass, diaginertia=inertia)


def _attach(arena: Any, robot: Any, spec: SceneSpec, drive: DiffDrive, parts: Parts) -> None:
    """Hangs one robot into the arena by its axle midpoint: freely, or on three slides and a vertical hinge."""
    for settings in (robot.option, robot.size, robot.statistic, robot.visual):
        settings.remove()  # the scene decides these; where both speak, dm_control would merge or refuse
    chassis = robot.find("body", parts.chassis)
    for joint in chassis.get_children("freejoint"), *chassis.get_children("joint"):
        if joint is not None and (joint.tag == "freejoint" or joint.type == "free"):
            joint.remove()
    chassis.pos, chassis.quat = (0, 0, 0), (1, 0, 0, 0)
    frame = arena.worldbody.attach(robot)
    if spec.base == "free":
        frame.pos = (0, 0, drive.wheel_radius)
        frame.add("freejoint", name="root")
        return
    for name, axis in (("root", (1, 0, 0)), ("y", (0, 1, 0)), ("z", (0, 0, 1))):
        frame.add("joint", name=name, type="slide", axis=axis)
    frame.add("joint", name="yaw", type="hinge", axis=(0, 0, 1))
