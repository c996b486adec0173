"""A compiled MuJoCo scene for the array simulation: robots of one kind on a floor, and the way around its arrays."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np

from nhtrack.arrays import Array
from nhtrack.effects.wheel_mismatch import WheelMismatch
from nhtrack.robots.contract import Parts
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.simulation.robot_models import read_robot
from nhtrack.simulation.spec import SceneSpec
from reference.physics.compose import compose

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
    forces: np.ndarray  # (p, 2, 3) places in sensordata of each tyre's contact force, world frame


@dataclass(frozen=True)
class Scene:
    """A compiled scene; torques are computed with `drive`, the robots are as `plant`, `marker` is the root's mocap."""

    spec: SceneSpec
    model: mujoco.MjModel
    drive: DiffDrive
    plant: DiffDrive
    addresses: Addresses
    marker: int | None

    @property
    def radius_factors(self) -> tuple[float, float]:
        """Radii of the left and the right tyre over the nominal radius."""
        return 1 + mismatch_of(self.spec) / 2, 1 - mismatch_of(self.spec) / 2

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
        radius, half_width, _ = self.model.geom_size[self.addresses.tyres[0, 0]]
        q = mismatch_of(self.spec) * self.drive.wheel_radius / self.drive.wheel_separation
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
        qvel[..., at.root_qvel + (3 if self.plant.levelled else 5)] = omega
        qvel[..., at.wheel_qvel] = self.drive.wheel_speeds(v, omega) / self.radius_factors
        return qvel


def mismatch_of(spec: SceneSpec) -> float:
    """Returns (r_left - r_right)/r of the tyres."""
    return sum(effect.mismatch for effect in spec.effects if isinstance(effect, WheelMismatch))


def make_scene(spec: SceneSpec) -> Scene:
    """Returns the compiled scene of a spec."""
    robot = read_robot(spec)
    drive, plant, parts = robot.drive, robot.plant, robot.parts
    arena = compose(spec, robot.reading.mjcf, drive, parts)
    model = mujoco.MjModel.from_xml_string(arena.to_xml_string(), arena.get_assets())
    marker = int(model.body(spec.robots[0]).mocapid[0]) if spec.virtual_root else None
    return Scene(spec, model, drive, plant, _addresses(model, spec, parts), marker)


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
