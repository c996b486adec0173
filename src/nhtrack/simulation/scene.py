"""A compiled MuJoCo scene: robots of one kind on a floor, and the way around its arrays."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass, field, replace

import mujoco
import numpy as np

from nhtrack.arrays import Array
from nhtrack.errors import RobotError
from nhtrack.robots.contract import Parts
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.simulation.casters import caster_rates
from nhtrack.simulation.compose import compose_scene
from nhtrack.simulation.fleet import Blueprint, compile_blueprint
from nhtrack.simulation.robot_models import RobotModels, read_robot
from nhtrack.simulation.spec import SceneSpec

__all__ = ["Addresses", "Scene", "SceneSpec", "make_scene", "stepped_scene", "unit_spec"]

# Robots are placed this far into the floor [m], so that every contact is active in the first step; at exactly zero
# distance rounding would decide which are, and the robot would fall on the others.
_TOUCH = 1e-9


@dataclass(frozen=True)
class Addresses:
    """Where the robots with a body live in MuJoCo's arrays; p robots, wheels left then right."""

    root_qpos: np.ndarray  # (p,) first coordinate of the base: x, then y and z
    root_qvel: np.ndarray  # (p,) first velocity of the base: along x, then y and z
    wheel_qpos: np.ndarray  # (p, 2)
    wheel_qvel: np.ndarray  # (p, 2)
    motors: np.ndarray  # (p, 2)
    tyres: np.ndarray  # (p, 2) geom ids
    casters: np.ndarray  # (p, k) velocities of all joints of casters that swivel
    rollers: np.ndarray  # (p, m) geom ids of their wheels


@dataclass(frozen=True)
class Scene:
    """A compiled scene and the way around it.

    Attributes:
        spec: what it was composed from.
        model: the compiled model.
        drive: the reduced model that the wheel torques are computed with.
        plant: the reduced model of the robots as they are, with what they carry.
        radius_factors: radii of the left and the right tyre over the nominal radius, as compiled.
        addresses: where each robot lives in the model's arrays.
        caster_rates: velocities of the joints of casters that trail, for v and for omega, shape (k, 2).
        marker: mocap id of the virtual root's marker, or None.
        blueprint: the composed MJCF.
    """

    spec: SceneSpec
    model: mujoco.MjModel
    drive: DiffDrive
    plant: DiffDrive
    radius_factors: tuple[float, float]
    addresses: Addresses
    caster_rates: np.ndarray = field(repr=False)
    marker: int | None
    blueprint: Blueprint = field(repr=False)

    @property
    def xml(self) -> str:
        """The composed MJCF."""
        return self.blueprint.xml

    @property
    def hash(self) -> str:
        """SHA-256 of the compiled model's binary form."""
        buffer = np.empty(mujoco.mj_sizeModel(self.model), np.uint8)
        mujoco.mj_saveModel(self.model, None, buffer)
        return hashlib.sha256(buffer.tobytes()).hexdigest()

    @property
    def tyre_flatness(self) -> float:
        """1 - k^2 of tyres that are ellipsoids of radius r and half width k r."""
        radius, half_width, _ = self.model.geom_size[self.addresses.tyres[0, 0]]
        return float(1 - (half_width / radius) ** 2)

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
        if self.plant.levelled:
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
        left, right = self.radius_factors
        q = (left - right) * self.drive.wheel_radius / self.drive.wheel_separation
        s = 1 / math.sqrt(1 + self.tyre_flatness * q**2)
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
        qvel[..., at.root_qvel + (3 if self.plant.levelled else 5)] = omega
        qvel[..., at.wheel_qvel] = self.drive.wheel_speeds(v, omega) / self.radius_factors
        qvel[..., at.casters] = np.stack([v, omega], axis=-1) @ self.caster_rates.T
        return qvel


def unit_spec(spec: SceneSpec) -> SceneSpec:
    """Returns the spec of the last of a scene's robots alone, with the same physics."""
    return replace(spec, robots=spec.robots[-1:], virtual_root=False, colours=spec.colours[-1:])


def make_scene(spec: SceneSpec, robot: RobotModels | None = None, *, share_materials: bool = False) -> Scene:
    """Returns the compiled scene of a spec.

    Args:
        spec: what to compile.
        robot: what is known of its robots, where that has been read already.
        share_materials: whether robots have one set of materials, with an accent of each colour; MuJoCo draws no scene
            of more than 999.

    Raises:
        RobotError: the robot cannot be found, compiled, driven, or attached.
        ValueError: what is known is of other robots.
    """
    robot = robot or read_robot(spec)
    robot.require(spec)
    blueprint = compose_scene(spec, robot, share_materials=share_materials)
    try:
        model = compile_blueprint(blueprint)
    except ValueError as error:
        raise RobotError(f"a scene of {spec.robot!r} does not compile: {error}") from error
    addresses = _addresses(model, spec, robot.parts)
    marker = int(model.body(spec.robots[0]).mocapid[0]) if spec.virtual_root else None
    factors = _radius_factors(model, addresses, robot.drive)
    still = np.zeros((addresses.casters.shape[1], 2))
    scene = Scene(spec, model, robot.drive, robot.plant, factors, addresses, still, marker, blueprint)
    return replace(scene, caster_rates=_caster_rates(scene)) if still.size else scene


def stepped_scene(spec: SceneSpec, robot: RobotModels | None = None) -> Scene:
    """Returns the scene that a simulation of a spec steps: of one robot where robots cannot touch each other.

    Args:
        spec: of all robots.
        robot: what is known of them, where that has been read already.

    Raises:
        RobotError: as `make_scene`.
    """
    return make_scene(spec if spec.robot_contact else unit_spec(spec), robot)


def _radius_factors(model: mujoco.MjModel, addresses: Addresses, drive: DiffDrive) -> tuple[float, float]:
    left, right = (float(model.geom_size[tyre, 0]) / drive.wheel_radius for tyre in addresses.tyres[0])
    return left, right


def _caster_rates(scene: Scene) -> np.ndarray:
    """Returns the velocities of the first robot's casters where it stands at the origin; none on a planar base."""
    at, data = scene.addresses, mujoco.MjData(scene.model)
    pose = np.zeros((len(at.casters), 3))
    data.qpos = scene.qpos_of(pose, np.zeros((len(pose), 2)))
    mujoco.mj_fwdPosition(scene.model, data)
    motions = np.broadcast_to([[[1.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]]], (2, len(pose), 3))
    pull = scene.qvel_of(np.broadcast_to(pose, motions.shape), motions).T
    return caster_rates(scene.model, data, at.casters[0], at.rollers[0], pull)


def _addresses(model: mujoco.MjModel, spec: SceneSpec, parts: Parts) -> Addresses:
    robots = spec.bodies
    roots = [model.joint(f"{name}/root/") for name in robots]
    wheels = [[model.joint(f"{name}/{joint}") for joint in parts.wheel_joints] for name in robots]
    casters = _caster_joints(model, robots[0], parts) if robots else []
    return Addresses(
        root_qpos=np.array([int(joint.qposadr[0]) for joint in roots], dtype=int),
        root_qvel=np.array([int(joint.dofadr[0]) for joint in roots], dtype=int),
        wheel_qpos=np.array([[int(joint.qposadr[0]) for joint in pair] for pair in wheels], dtype=int),
        wheel_qvel=np.array([[int(joint.dofadr[0]) for joint in pair] for pair in wheels], dtype=int),
        motors=np.array([[model.actuator(f"{name}/{motor}").id for motor in parts.motors] for name in robots]),
        tyres=np.array([[model.geom(f"{name}/{tyre}").id for tyre in parts.tyres] for name in robots]),
        casters=np.array(
            [[int(model.joint(f"{name}/{joint}").dofadr[0]) for joint in casters] for name in robots], int
        ),
        rollers=np.array([[model.geom(f"{name}/{geom}").id for geom in parts.rolling_casters] for name in robots], int),
    )


def _caster_joints(model: mujoco.MjModel, name: str, parts: Parts) -> list[str]:
    """Returns the joints of a robot's casters: its own, but for the wheels'; those of its frame end in a slash."""
    names = (model.joint(joint).name for joint in range(model.njnt))
    own = (each.removeprefix(f"{name}/") for each in names if each.startswith(f"{name}/") and not each.endswith("/"))
    return [each for each in own if each not in parts.wheel_joints]
