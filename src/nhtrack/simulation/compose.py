"""Writes the MJCF of a scene: one arena, one robot in it for all of them, the floor and what robots carry."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from nhtrack import assets
from nhtrack.colours import rgb
from nhtrack.mjcf import parse_mjcf, read_mjcf
from nhtrack.robots.contract import Parts
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.simulation.fleet import ROBOT, Blueprint, Robot, make_blueprint
from nhtrack.simulation.robot_models import RobotModels
from nhtrack.simulation.spec import SceneSpec

# Impedance so close to one that penetration, and with it the change of the rolling radius, is a few nanometres.
_STIFF_SOLIMP = (0.9999, 0.9999, 0.001)
# A dense Jacobian is quicker for a handful of robots and ruinous for dozens (docs/fidelity.md).
_DENSE_ROBOTS = 4


def compose_scene(spec: SceneSpec, robot: RobotModels, *, share_materials: bool = False) -> Blueprint:
    """Returns the blueprint of a scene.

    Args:
        spec: what to compose.
        robot: what is known of its robots.
        share_materials: whether robots have one set of materials, with an accent of each colour.
    """
    arena = read_mjcf(assets.models_directory() / "arena" / "scene.xml")
    arena.compiler.remove()  # how a robot's file is read is the robot's to say; the arena has no angles
    _set_options(arena, spec)
    for effect in spec.effects:
        effect.edit_arena(arena, spec.ground)
    if spec.bodies:
        _add_robot(arena, spec, robot)
    if spec.virtual_root:
        _add_marker(arena, spec, robot.drive.half_separation)
    _add_cameras(arena, spec.bounds)
    return make_blueprint(
        arena.to_xml_string(), arena.get_assets(), _robots(spec), "accent", share_materials=share_materials
    )


def _add_robot(arena: Any, spec: SceneSpec, robot: RobotModels) -> None:
    """Adds the one robot that stands for all."""
    element = parse_mjcf(robot.reading.mjcf)
    element.model = ROBOT
    _set_contacts(element, spec, robot.parts)
    _set_motors(element, robot.drive, robot.parts)
    _set_losses(arena, element, spec, robot.parts)
    for effect in spec.effects:
        effect.edit_robot(element, robot.parts, robot.nominal)
    frame = _attach(arena, element, robot.drive, robot.parts)
    for effect in spec.effects:
        effect.edit_frame(frame)


def _robots(spec: SceneSpec) -> tuple[Robot, ...]:
    for name in spec.bodies:
        if "/" in name:
            raise ValueError(f"a robot's name cannot contain '/': got {name}")
    return tuple(
        Robot(name, (*rgb(spec.colour(place)), 1.0)) for place, name in enumerate(spec.bodies, start=spec.first_body)
    )


def _set_options(arena: Any, spec: SceneSpec) -> None:
    option = arena.option
    option.timestep = spec.timestep
    option.gravity = spec.ground.gravity  # the plane stays level in its own frame; on a slope gravity leans
    option.integrator = "implicitfast"  # but with damping, see `_set_losses`
    option.cone = "elliptic"  # the pyramid loses 29 % of the friction limit at 45 degrees
    option.solver = "Newton"
    option.impratio = 1  # more would shrink the creep of friction, which the rate correction makes up for anyway, and
    # sharpen the cones: at 10 the solver now and then ends a step beside the solution
    option.tolerance = 1e-15  # at 1e-12 a step near the limit of friction now and then ends beside the solution
    option.iterations = 100
    option.ls_tolerance = 1  # the first point that is better: with this tolerance the default spins on rounding
    option.ls_iterations = 200  # with the 50 of the default a line search in a sliding contact may not end
    option.jacobian = "dense" if len(spec.bodies) <= _DENSE_ROBOTS else "sparse"
    option.flag.autoreset = "disable"  # a diverged state is an error to report, not one to hide by a reset


def _set_contacts(robot: Any, spec: SceneSpec, parts: Parts) -> None:
    """Writes contact parameters and collision masks into one robot's MJCF."""
    for name in parts.collision_geoms:
        geom = robot.find("geom", name)
        # The floor's type is 1: robots see it by their affinity 1, and each other only by type and affinity 2.
        geom.contype, geom.conaffinity = (2, 3) if spec.robot_contact else (0, 1)
        if spec.contact == "stiff" and name in (*parts.tyres, *parts.casters):
            geom.solref, geom.solimp = (2 * spec.timestep, 1), _STIFF_SOLIMP
    for name in (*parts.tyres, *parts.rolling_casters):
        geom = robot.find("geom", name)
        geom.friction, geom.condim, geom.priority = (spec.ground.friction, 0.005, 0.0001), 3, 1
    for name in set(parts.casters) - set(parts.rolling_casters):
        geom = robot.find("geom", name)
        geom.condim, geom.priority = 1, 1


def _set_motors(robot: Any, drive: DiffDrive, parts: Parts) -> None:
    """Makes motors take torques at the wheel, up to their limit."""
    for name in parts.motors:
        motor = robot.find("actuator", name)
        if math.isfinite(drive.motor.torque_limit):
            motor.ctrllimited, motor.ctrlrange = "true", (-drive.motor.torque_limit, drive.motor.torque_limit)


def _set_losses(arena: Any, robot: Any, spec: SceneSpec, parts: Parts) -> None:
    """Lets viscous friction act by the mean velocity of a step, and dry friction hold as stiffly as contacts.

    MuJoCo's implicit damping comes after contacts are solved without it, so that they do not hold in the end: wheels
    slip, and the reaction tips the chassis. With h d/2 in the armature and damping taken explicitly, `(M + h d/2) (v' -
    v)/h = forces - d v`, contacts and friction are solved together, and friction is of second order in h.
    """
    for joint in _joints(robot.find("body", parts.chassis)):
        damping = 0.0 if joint.damping is None else float(np.ravel(joint.damping)[0])  # a list to dm_control
        if damping:
            joint.armature = (joint.armature or 0.0) + spec.timestep * damping / 2
            arena.option.integrator, arena.option.flag.eulerdamp = "Euler", "disable"
        if joint.frictionloss and spec.contact == "stiff":
            joint.solreffriction, joint.solimpfriction = (2 * spec.timestep, 1), _STIFF_SOLIMP


def _joints(body: Any) -> Iterator[Any]:
    """Yields the joints of a body and of all that hang on it."""
    yield from body.get_children("joint")
    for child in body.get_children("body"):
        yield from _joints(child)


def _attach(arena: Any, robot: Any, drive: DiffDrive, parts: Parts) -> Any:
    """Returns the frame by which one robot, free to move, hangs in the arena, at its axle midpoint."""
    robot.find("body", parts.chassis).get_children("freejoint").remove()
    frame = arena.worldbody.attach(robot)
    frame.pos = (0, 0, drive.wheel_radius)
    frame.add("freejoint", name="root")
    return frame


def _add_marker(arena: Any, spec: SceneSpec, radius: float) -> None:
    """Adds the moving marker of a virtual leader, a body of its name as wide as the robots' axle."""
    body = arena.worldbody.add("body", name=spec.robots[0], mocap=True)
    look = {"rgba": (*rgb(spec.colour(0)), 0.6), "contype": 0, "conaffinity": 0, "group": 2}
    body.add("geom", type="cylinder", size=(radius, 0.002), pos=(0, 0, 0.002), **look)
    arrow = (0, 0, radius / 5, 1.4 * radius, 0, radius / 5)
    body.add("geom", type="capsule", size=(0.12 * radius,), fromto=arrow, **look)


def _add_cameras(arena: Any, bounds: tuple[float, float, float, float]) -> None:
    """Adds `top` and `isometric`, which frame a rectangle of the floor [m]."""
    x_min, x_max, y_min, y_max = bounds
    centre = np.array([(x_min + x_max) / 2, (y_min + y_max) / 2, 0.0])
    span = max(x_max - x_min, (y_max - y_min) * 4 / 3, 0.5)
    distance = 0.6 * span / np.tan(np.radians(45) / 2)
    above = centre + np.array([0, 0, distance])
    arena.worldbody.add("camera", name="top", pos=above, xyaxes=(1, 0, 0, 0, 1, 0), fovy=45)
    ahead = np.array([np.cos(np.radians(40)), 0, np.sin(np.radians(40))])
    position = centre + distance * np.array([0, -ahead[0], ahead[2]])
    arena.worldbody.add("camera", name="isometric", pos=position, xyaxes=(1, 0, 0, 0, ahead[2], ahead[0]), fovy=45)
