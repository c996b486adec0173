"""Composes the MuJoCo scene: one arena, one robot model attached n times, contacts derived from the time step."""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from nhtrack import assets
from nhtrack.arrays import Array
from nhtrack.diffdrive import DiffDrive, identify
from nhtrack.diffdrive.identification import Parts, identify_parts
from nhtrack.diffdrive.reduced_model import GRAVITY
from nhtrack.errors import RobotError, did_you_mean
from nhtrack.simulation.palette import robot_colour

# Impedance so close to one that penetration, and with it the change of the rolling radius, is a few nanometres.
_STIFF_SOLIMP = (0.9999, 0.9999, 0.001)
# Robots are placed this far into the floor [m], so that every contact is active in the first step; at exactly zero
# distance rounding would decide which are, and the robot would fall on the others.
_TOUCH = 1e-9
# A dense Jacobian is quicker for a handful of robots and ruinous for dozens (docs/fidelity.md).
_DENSE_ROBOTS = 4


@dataclass(frozen=True)
class SceneSpec:
    """All that decides a compiled scene; kept with every recording, so that it can be composed again.

    Attributes:
        robots: names, root first.
        robot: folder in models/ or path to an MJCF file.
        timestep: physics step [s].
        friction: sliding friction coefficient between wheels and floor.
        contact: `stiff` (contact parameters from the time step) or `default` (MuJoCo's own).
        rate_correction: whether the simulation supplies the missing rate term of the contact rows.
        robot_contact: whether robots touch each other.
        virtual_root: whether the root is a marker without a body.
        bounds: rectangle (x_min, x_max, y_min, y_max) [m] that the whole-run cameras frame.
    """

    robots: tuple[str, ...]
    robot: str = "nh_mini"
    timestep: float = 0.001
    friction: float = 1.0
    contact: str = "stiff"
    rate_correction: bool = True
    robot_contact: bool = False
    virtual_root: bool = False
    bounds: tuple[float, float, float, float] = (-1.0, 1.0, -1.0, 1.0)

    def to_json(self) -> str:
        """Returns the spec as one line of JSON."""
        return json.dumps(asdict(self))

    @classmethod
    def from_json(cls, text: str) -> SceneSpec:
        """Returns the spec written by `to_json`."""
        tree = json.loads(text)
        return cls(**tree | {"robots": tuple(tree["robots"]), "bounds": tuple(tree["bounds"])})

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the robots that have a body in the scene."""
        return self.robots[1:] if self.virtual_root else self.robots


@dataclass(frozen=True)
class Addresses:
    """Where the robots with a body live in MuJoCo's arrays; p robots, wheels left then right."""

    root_qpos: np.ndarray  # (p,) first of the free joint's seven coordinates
    root_qvel: np.ndarray  # (p,) first of its six velocities
    wheel_qpos: np.ndarray  # (p, 2)
    wheel_qvel: np.ndarray  # (p, 2)
    motors: np.ndarray  # (p, 2)
    tyres: np.ndarray  # (p, 2) geom ids
    forces: np.ndarray  # (p, 2, 3) places in sensordata of each tyre's contact force, world frame


@dataclass(frozen=True)
class Scene:
    """A compiled scene and the way around it.

    Attributes:
        spec: what it was composed from.
        model: the compiled model.
        drive: the reduced model of its robots.
        addresses: where each robot lives in the model's arrays.
        marker: mocap id of the virtual root's marker, or None.
        xml: the composed MJCF.
    """

    spec: SceneSpec
    model: mujoco.MjModel
    drive: DiffDrive
    addresses: Addresses
    marker: int | None
    xml: str = field(repr=False)

    @property
    def hash(self) -> str:
        """SHA-256 of the compiled model's binary form."""
        buffer = np.empty(mujoco.mj_sizeModel(self.model), np.uint8)
        mujoco.mj_saveModel(self.model, None, buffer)
        return hashlib.sha256(buffer.tobytes()).hexdigest()

    def qpos_of(self, pose: Array, wheel_angle: Array) -> Array:
        """Returns MuJoCo coordinates of robots that stand level on the floor.

        Args:
            pose: poses of the robots with a body, shape (..., p, 3).
            wheel_angle: wheel angles [rad], shape (..., p, 2).

        Returns:
            Coordinates, shape (..., nq).
        """
        at = self.addresses
        qpos = np.zeros((*pose.shape[:-2], self.model.nq))
        qpos[..., at.root_qpos] = pose[..., 0]
        qpos[..., at.root_qpos + 1] = pose[..., 1]
        qpos[..., at.root_qpos + 2] = self.drive.wheel_radius - _TOUCH
        qpos[..., at.root_qpos + 3] = np.cos(pose[..., 2] / 2)
        qpos[..., at.root_qpos + 6] = np.sin(pose[..., 2] / 2)
        qpos[..., at.wheel_qpos] = wheel_angle
        return qpos

    def qvel_of(self, pose: Array, twist: Array) -> Array:
        """Returns MuJoCo velocities of robots that roll without slip, shape (..., nv).

        Args:
            pose: poses, shape (..., p, 3).
            twist: body twists with v_y = 0, shape (..., p, 3).
        """
        at = self.addresses
        v, omega, theta = twist[..., 0], twist[..., 2], pose[..., 2]
        qvel = np.zeros((*pose.shape[:-2], self.model.nv))
        qvel[..., at.root_qvel] = v * np.cos(theta)
        qvel[..., at.root_qvel + 1] = v * np.sin(theta)
        qvel[..., at.root_qvel + 5] = omega
        qvel[..., at.wheel_qvel] = self.drive.wheel_speeds(v, omega)
        return qvel


def robot_path(robot: str) -> Path:
    """Returns the MJCF file of a robot named by its folder in models/ or by a path that ends in `.xml`.

    Raises:
        RobotError: no such robot; the message lists those there are.
    """
    if Path(robot).suffix == ".xml":
        if not Path(robot).is_file():
            raise RobotError(f"{robot}: no such MJCF file")
        return Path(robot)
    if robot not in assets.robots():
        raise RobotError(f"no robot {robot!r}; {did_you_mean(robot, assets.robots())}")
    return assets.find_robot(robot)


def load_robot(robot: str) -> mujoco.MjModel:
    """Returns the compiled model of one robot alone.

    Raises:
        RobotError: no such robot, or MuJoCo cannot compile it.
    """
    path = robot_path(robot)
    try:
        return mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        raise RobotError(f"{path}: MuJoCo cannot compile it: {error}") from error


def make_scene(spec: SceneSpec) -> Scene:
    """Returns the compiled scene of a spec.

    Raises:
        RobotError: the robot cannot be found, compiled, driven, or attached.
    """
    mjcf = _mjcf()
    alone = load_robot(spec.robot)
    drive, parts = identify(alone), identify_parts(alone)
    arena = mjcf.from_path(str(assets.models_directory() / "arena" / "scene.xml"))
    arena.compiler.remove()  # how a robot's file is read is the robot's to say; the arena has no angles
    _set_options(arena, spec)
    for index, name in enumerate(spec.robots):
        if name in spec.bodies:
            robot = mjcf.from_path(str(robot_path(spec.robot)))
            robot.model = name
            _set_contacts(robot, spec, parts)
            _paint(robot, robot_colour(index))
            _attach(arena, robot, drive, parts)
    marker = _add_marker(arena, spec.robots[0]) if spec.virtual_root else None
    _add_cameras(arena, spec.bounds)
    xml = arena.to_xml_string()
    try:
        model = mujoco.MjModel.from_xml_string(xml, arena.get_assets())
    except ValueError as error:
        raise RobotError(f"a scene of {spec.robot!r} does not compile: {error}") from error
    mocap = None if marker is None else int(model.body(marker).mocapid[0])
    return Scene(spec, model, drive, _addresses(model, spec, parts), mocap, xml)


def _mjcf() -> Any:
    """Returns dm_control.mjcf, imported without the search for a display that its renderer would begin."""
    chosen = os.environ.get("MUJOCO_GL")
    os.environ["MUJOCO_GL"] = "disable"
    try:
        from dm_control import mjcf
    finally:
        if chosen is None:
            del os.environ["MUJOCO_GL"]
        else:
            os.environ["MUJOCO_GL"] = chosen
    return mjcf


def _set_options(arena: Any, spec: SceneSpec) -> None:
    option = arena.option
    option.timestep = spec.timestep
    option.gravity = (0, 0, -GRAVITY)
    option.integrator = "implicitfast"
    option.cone = "elliptic"  # the pyramid loses 29 % of the friction limit at 45 degrees
    option.solver = "Newton"
    option.impratio = 10  # tenfold less creep of the regularised friction, at no visible cost
    option.tolerance = 1e-12
    option.iterations = 100
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
    for name in parts.tyres:
        geom = robot.find("geom", name)
        geom.friction, geom.condim, geom.priority = (spec.friction, 0.005, 0.0001), 3, 1
        robot.sensor.add("contact", name=name, geom1=geom, data="force", reduce="netforce", num=1)
    for name in parts.casters:
        geom = robot.find("geom", name)
        geom.condim, geom.priority = 1, 1


def _paint(robot: Any, colour: str) -> None:
    accent = robot.find("material", "accent")
    if accent is not None:
        accent.rgba = (*_rgb(colour), 1)


def _rgb(colour: str) -> tuple[float, float, float]:
    """Returns red, green and blue from 0 to 1 of a colour written #rrggbb."""
    red, green, blue = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return red, green, blue


def _attach(arena: Any, robot: Any, drive: DiffDrive, parts: Parts) -> None:
    """Hangs one robot into the arena by a free joint at its axle midpoint."""
    for settings in (robot.option, robot.size, robot.statistic, robot.visual):
        settings.remove()  # the scene decides these; where both speak, dm_control would merge or refuse
    chassis = robot.find("body", parts.chassis)
    for joint in chassis.get_children("freejoint"), *chassis.get_children("joint"):
        if joint is not None and (joint.tag == "freejoint" or joint.type == "free"):
            joint.remove()
    chassis.pos, chassis.quat = (0, 0, 0), (1, 0, 0, 0)
    frame = arena.worldbody.attach(robot)
    frame.pos = (0, 0, drive.wheel_radius)
    frame.add("freejoint", name="root")


def _add_marker(arena: Any, name: str) -> str:
    """Adds the moving marker of a virtual leader and returns its body's name."""
    body = arena.worldbody.add("body", name=name, mocap=True)
    look = {"rgba": (*_rgb(robot_colour(0)), 0.6), "contype": 0, "conaffinity": 0, "group": 2}
    body.add("geom", type="cylinder", size=(0.05, 0.002), pos=(0, 0, 0.002), **look)
    body.add("geom", type="capsule", size=(0.006,), fromto=(0, 0, 0.01, 0.07, 0, 0.01), **look)
    return name


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


def _addresses(model: mujoco.MjModel, spec: SceneSpec, parts: Parts) -> Addresses:
    robots = spec.bodies
    roots = [model.joint(f"{name}/root/") for name in robots]
    wheels = [[model.joint(f"{name}/{joint}") for joint in parts.wheel_joints] for name in robots]
    sensors = [[int(model.sensor(f"{name}/{tyre}").adr[0]) for tyre in parts.tyres] for name in robots]
    return Addresses(
        root_qpos=np.array([int(joint.qposadr[0]) for joint in roots], dtype=int),
        root_qvel=np.array([int(joint.dofadr[0]) for joint in roots], dtype=int),
        wheel_qpos=np.array([[int(joint.qposadr[0]) for joint in pair] for pair in wheels], dtype=int),
        wheel_qvel=np.array([[int(joint.dofadr[0]) for joint in pair] for pair in wheels], dtype=int),
        motors=np.array([[model.actuator(f"{name}/{motor}").id for motor in parts.motors] for name in robots]),
        tyres=np.array([[model.geom(f"{name}/{tyre}").id for tyre in parts.tyres] for name in robots]),
        forces=np.array(sensors, dtype=int)[..., None] + np.arange(3),
    )
