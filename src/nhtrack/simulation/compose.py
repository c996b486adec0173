"""Writes the MJCF of a scene: one arena, one robot in it for all of them, the floor and what robots carry."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nhtrack import assets
from nhtrack.colours import GRIP, ICE, rgb
from nhtrack.ground import Patch
from nhtrack.mjcf import from_path
from nhtrack.robots.diff_drive.identification import Parts
from nhtrack.simulation.fleet import ROBOT, Blueprint, Robot, make_blueprint

if TYPE_CHECKING:
    from pathlib import Path

    from nhtrack.robots.diff_drive import DiffDrive
    from nhtrack.simulation.spec import Payload, SceneSpec

# Impedance so close to one that penetration, and with it the change of the rolling radius, is a few nanometres.
_STIFF_SOLIMP = (0.9999, 0.9999, 0.001)
# A dense Jacobian is quicker for a handful of robots and ruinous for dozens (docs/fidelity.md).
_DENSE_ROBOTS = 4
_UNLIKE_FLOOR = 0.3  # change of friction at which a patch is drawn in full colour
_FLOOR = (0.65, 0.67, 0.70)  # colour of the floor, which fainter patches come nearer to
_PATCH_HEIGHT = 3e-4  # [m] drawn above the floor, below trails; patches that overlap are stacked


def compose(
    spec: SceneSpec,
    robot_file: Path,
    drive: DiffDrive,
    parts: Parts,
    *,
    share_materials: bool = False,
) -> Blueprint:
    """Returns the blueprint of a scene.

    Args:
        spec: what to compose.
        robot_file: MJCF of its robot.
        drive: the robot's reduced model, of which the wheel radius and the torque limit are used.
        parts: names of the robot's parts.
        share_materials: whether robots have one set of materials, with an accent of each colour.
    """
    arena = from_path(assets.models_directory() / "arena" / "scene.xml")
    arena.compiler.remove()  # how a robot's file is read is the robot's to say; the arena has no angles
    _set_options(arena, spec)
    for index, patch in enumerate(spec.patches):
        _draw_patch(arena, f"patch_{index}", patch, spec.friction, (index + 1) * _PATCH_HEIGHT)
    if spec.bodies:
        robot = from_path(robot_file)
        robot.model = ROBOT
        _set_contacts(robot, spec, parts)
        _set_wheels(robot, spec, drive, parts)
        if spec.payload is not None:
            _add_payload(robot, parts.chassis, spec.payload, drive.wheel_radius)
        _attach(arena, robot, spec, drive, parts)
    if spec.virtual_root:
        _add_marker(arena, spec, drive.half_separation)
    _add_cameras(arena, spec.bounds)
    return make_blueprint(
        arena.to_xml_string(), arena.get_assets(), _robots(spec), "accent", share_materials=share_materials
    )


def _robots(spec: SceneSpec) -> tuple[Robot, ...]:
    for name in spec.bodies:
        if "/" in name:
            raise ValueError(f"a robot's name cannot contain '/': got {name}")
    return tuple(
        Robot(name, (*rgb(spec.colour(place)), 1.0)) for place, name in enumerate(spec.bodies, start=spec.first_body)
    )


def loaded_robot(robot_file: Path, payload: Payload, wheel_radius: float, parts: Parts) -> Any:
    """Returns the MJCF element of one robot alone with what it carries."""
    robot = from_path(robot_file)
    _add_payload(robot, parts.chassis, payload, wheel_radius)
    return robot


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
    option.ls_tolerance = 1  # the first point that is better: with this tolerance the default spins on rounding
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
    drawn = np.maximum(size, 1e-3)
    look = {"rgba": (0.72, 0.55, 0.35, 1), "contype": 0, "conaffinity": 0, "group": 2}
    body.add("geom", name=name, type="box", size=drawn, **look)


def _draw_patch(arena: Any, name: str, patch: Patch, floor: float, height: float) -> None:
    """Draws a patch flat on the floor, bluish where it is slippier than the floor and brown where it grips more."""
    unlike = 0.3 + 0.7 * min(1.0, abs(patch.friction - floor) / _UNLIKE_FLOOR)
    mixed = unlike * np.array(rgb(ICE if patch.friction < floor else GRIP)) + (1 - unlike) * np.array(_FLOOR)
    matt = arena.asset.add("material", name=name, rgba=(*mixed, 1), specular=0, shininess=0)
    look = {"name": name, "material": matt, "contype": 0, "conaffinity": 0, "group": 2}
    if patch.disc is not None:
        x, y, radius = patch.disc
        arena.worldbody.add("geom", type="cylinder", size=(radius, height / 2), pos=(x, y, height / 2), **look)
    elif patch.rectangle is not None:
        x_min, x_max, y_min, y_max = patch.rectangle
        size, centre = ((x_max - x_min) / 2, (y_max - y_min) / 2), ((x_min + x_max) / 2, (y_min + y_max) / 2)
        arena.worldbody.add("geom", type="box", size=(*size, height / 2), pos=(*centre, height / 2), **look)


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
