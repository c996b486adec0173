"""A compiled MuJoCo scene: robots of one kind on a floor, and the way around its arrays."""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from nhtrack import assets
from nhtrack.arrays import Array
from nhtrack.diffdrive import DiffDrive, identify
from nhtrack.diffdrive.identification import Parts, identify_parts
from nhtrack.errors import RobotError, did_you_mean
from nhtrack.ground import Ground, Patch
from nhtrack.simulation.compose import compose, loaded_robot
from nhtrack.simulation.palette import robot_colour

# Robots are placed this far into the floor [m], so that every contact is active in the first step; at exactly zero
# distance rounding would decide which are, and the robot would fall on the others.
_TOUCH = 1e-9


@dataclass(frozen=True)
class Payload:
    """A box of uniform density that every robot carries.

    Attributes:
        mass: [kg].
        position: its centre, x and y in the chassis frame and height above the floor [m].
        size: its edges [m]; zeros for a point.
    """

    mass: float
    position: tuple[float, float, float]
    size: tuple[float, float, float] = (0.0, 0.0, 0.0)


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
        base: `free` (a free joint, three supports) or `planar` (held level by slides and a vertical hinge).
        patches: regions of the floor with a friction of their own.
        slope: angle of the floor with the horizontal [rad].
        uphill: direction in which the floor rises [rad].
        payload: what every robot carries, or None.
        wheel_mismatch: (r_left - r_right)/r of the tyres; their mean stays r.
        torque_limit: of each wheel motor [N m], or None for the robot's own.
        no_load_speed: of each wheel [rad/s], or None for the robot's own.
        compensation: what the wheel torques are computed for: `nominal` (the robot as its file has it, on a level
            floor) or `actual` (its payload and the slope as well).
        colours: each robot's place in the palette, shape n; empty where a robot's place here is its place there.
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
    base: str = "free"
    patches: tuple[Patch, ...] = ()
    slope: float = 0.0
    uphill: float = 0.0
    payload: Payload | None = None
    wheel_mismatch: float = 0.0
    torque_limit: float | None = None
    no_load_speed: float | None = None
    compensation: str = "nominal"
    colours: tuple[int, ...] = ()

    def to_json(self) -> str:
        """Returns the spec as one line of JSON."""
        return json.dumps(asdict(self))

    @classmethod
    def from_json(cls, text: str) -> SceneSpec:
        """Returns the spec written by `to_json`; what an older one lacks is at its default."""
        tree = _frozen(json.loads(text))
        tree["patches"] = tuple(Patch(**patch) for patch in tree.get("patches", ()))
        if tree.get("payload") is not None:
            tree["payload"] = Payload(**tree["payload"])
        return cls(**tree)

    @property
    def first_body(self) -> int:
        """Place in `robots` of the first robot that has a body in the scene."""
        return 1 if self.virtual_root else 0

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the robots that have a body in the scene."""
        return self.robots[self.first_body :]

    def colour(self, place: int) -> str:
        """Returns the colour `#RRGGBB` in which the robot at a place of `robots` is drawn."""
        return robot_colour(self.colours[place] if self.colours else place)

    @property
    def ground(self) -> Ground:
        """What the robots stand on."""
        return Ground(self.friction, self.patches, self.slope, self.uphill)

    @property
    def radius_factors(self) -> tuple[float, float]:
        """Radii of the left and the right tyre over the nominal radius."""
        return 1 + self.wheel_mismatch / 2, 1 - self.wheel_mismatch / 2


def _frozen(tree: Any) -> Any:
    """Returns a JSON tree with its lists as tuples."""
    if isinstance(tree, dict):
        return {key: _frozen(value) for key, value in tree.items()}
    return tuple(_frozen(item) for item in tree) if isinstance(tree, list) else tree


@dataclass(frozen=True)
class Addresses:
    """Where the robots with a body live in MuJoCo's arrays; p robots, wheels left then right."""

    root_qpos: np.ndarray  # (p,) first coordinate of the base: x, then y and z
    root_qvel: np.ndarray  # (p,) first velocity of the base: along x, then y and z
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
        drive: the reduced model that the wheel torques are computed with.
        plant: the reduced model of the robots as they are, with what they carry.
        addresses: where each robot lives in the model's arrays.
        marker: mocap id of the virtual root's marker, or None.
        xml: the composed MJCF.
    """

    spec: SceneSpec
    model: mujoco.MjModel
    drive: DiffDrive
    plant: DiffDrive
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
        """Returns MuJoCo coordinates of robots that stand on the floor, leaning where their wheels are unlike.

        Args:
            pose: poses of the robots with a body, shape (..., p, 3).
            wheel_angle: wheel angles [rad], shape (..., p, 2).

        Returns:
            Coordinates, shape (..., nq).
        """
        at = self.addresses
        height, lean = self._stance()
        qpos = np.zeros((*pose.shape[:-2], self.model.nq))
        qpos[..., at.root_qpos] = pose[..., 0]
        qpos[..., at.root_qpos + 1] = pose[..., 1]
        qpos[..., at.root_qpos + 2] = height - _TOUCH
        if self.spec.base == "planar":
            qpos[..., at.root_qpos + 3] = pose[..., 2]
        else:
            cosine, sine = np.cos(pose[..., 2] / 2), np.sin(pose[..., 2] / 2)
            qpos[..., at.root_qpos + 3] = cosine * math.cos(lean / 2)
            qpos[..., at.root_qpos + 4] = cosine * math.sin(lean / 2)
            qpos[..., at.root_qpos + 5] = sine * math.sin(lean / 2)
            qpos[..., at.root_qpos + 6] = sine * math.cos(lean / 2)
        qpos[..., at.wheel_qpos] = wheel_angle
        return qpos

    def _stance(self) -> tuple[float, float]:
        """Height of the axle midpoint above the floor [m] and sideways lean phi [rad] of robots that stand.

        An ellipsoid of radius r_i and half width k r_i that leans with its axle has its centre s r_i above the floor,
        s = sqrt(cos^2 phi + k^2 sin^2 phi). The two centres are 2 b apart on the axle, so that

            sin phi = s q,  q = (r_left - r_right)/(2 b),  hence  s = 1/sqrt(1 + (1 - k^2) q^2).
        """
        radius, half_width, _ = self.model.geom_size[self.addresses.tyres[0, 0]]
        q = self.spec.wheel_mismatch * self.drive.wheel_radius / self.drive.wheel_separation
        s = 1 / math.sqrt(1 + (1 - (half_width / radius) ** 2) * q**2)
        return s * self.drive.wheel_radius, math.asin(s * q)

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
        qvel[..., at.root_qvel + (3 if self.spec.base == "planar" else 5)] = omega
        qvel[..., at.wheel_qvel] = self.drive.wheel_speeds(v, omega) / self.spec.radius_factors
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


def reduced_models(spec: SceneSpec) -> tuple[DiffDrive, DiffDrive]:
    """Returns the reduced model that wheel torques are computed with, and that of the robots as they are.

    Raises:
        RobotError: as `make_scene`.
    """
    alone = load_robot(spec.robot)
    nominal = plant = _limited(identify(alone), spec)
    if spec.payload is not None:
        laden = loaded_robot(robot_path(spec.robot), spec.payload, nominal.wheel_radius, identify_parts(alone))
        plant = _limited(identify(_compiled(laden, spec.robot)), spec)
    return (plant if spec.compensation == "actual" else nominal), plant


def _limited(drive: DiffDrive, spec: SceneSpec) -> DiffDrive:
    """Returns a reduced model with the motors' limits and the base of a spec."""
    limits = {"torque_limit": spec.torque_limit, "no_load_speed": spec.no_load_speed}
    motor = replace(drive.motor, **{name: limit for name, limit in limits.items() if limit is not None})
    return replace(drive, motor=motor, levelled=spec.base == "planar")


def make_scene(spec: SceneSpec) -> Scene:
    """Returns the compiled scene of a spec.

    Raises:
        RobotError: the robot cannot be found, compiled, driven, or attached.
    """
    drive, plant = reduced_models(spec)
    parts = identify_parts(load_robot(spec.robot))
    arena = compose(spec, robot_path(spec.robot), drive, parts)
    model = _compiled(arena, spec.robot)
    marker = int(model.body(spec.robots[0]).mocapid[0]) if spec.virtual_root else None
    return Scene(spec, model, drive, plant, _addresses(model, spec, parts), marker, arena.to_xml_string())


def _compiled(element: Any, robot: str) -> mujoco.MjModel:
    """Returns the compiled model of a dm_control element."""
    try:
        return mujoco.MjModel.from_xml_string(element.to_xml_string(), element.get_assets())
    except ValueError as error:
        raise RobotError(f"a scene of {robot!r} does not compile: {error}") from error


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
