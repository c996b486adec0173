"""The reduced model's forces and loads against MuJoCo's own inverse dynamics, for every bundled robot.

Mass matrix and wheel torques are checked by `nhtrack fidelity`.

S maps (v, omega) to MuJoCo's velocities under no slip. No contact is involved: MuJoCo's recursive
Newton-Euler gives the forces that a prescribed motion takes, to rounding.
"""

from dataclasses import dataclass

import mujoco
import numpy as np
import pytest

from nhtrack import assets
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.simulation.scene import Scene, SceneSpec, make_scene
from tolerances import HAND, MASS_MATRIX

pytestmark = pytest.mark.fidelity

MOTIONS = np.random.default_rng(2024).uniform(-1, 1, (12, 5))
"""Twelve motions (theta, v, omega, u_x, u_theta), in shares of `most`."""


def most(drive: DiffDrive) -> np.ndarray:
    """Returns a half turn, and the speeds and accelerations at which a robot's motors end, [rad, m/s, rad/s, ...]."""
    speed, force = drive.wheel_radius * drive.motor.no_load_speed, 2 * drive.motor.torque_limit / drive.wheel_radius
    b = drive.half_separation
    return np.array([np.pi, speed, speed / b, force / drive.m_eff, force * b / drive.J_eff])


@dataclass(frozen=True)
class Motion:
    """A robot alone on a floor, rolling without slip."""

    scene: Scene
    theta: float
    v: float
    omega: float
    u_x: float
    u_theta: float

    @property
    def drive(self) -> DiffDrive:
        return self.scene.drive

    @property
    def reduced(self) -> tuple[np.ndarray, ...]:
        return tuple(np.array(value) for value in (self.v, self.omega, self.u_x, self.u_theta))

    @property
    def S(self) -> np.ndarray:
        """Columns of velocities for v = 1 and for omega = 1, casters held, shape (nv, 2)."""
        pose, at = np.array([[0, 0, self.theta]]), self.scene.addresses
        columns = [self.scene.qvel_of(pose, np.array([unit])) for unit in ((1, 0, 0), (0, 0, 1))]
        known = np.zeros(self.scene.model.nv)
        known[[*range(at.root_qvel[0], at.root_qvel[0] + 6), *at.wheel_qvel[0]]] = 1
        return known[:, None] * np.stack(columns, axis=-1)

    def at_this_motion(self) -> mujoco.MjData:
        data = mujoco.MjData(self.scene.model)
        data.qpos = self.scene.qpos_of(np.array([[0, 0, self.theta]]), np.array([[0.7, -1.9]]))
        data.qvel = self.S @ (self.v, self.omega)
        mujoco.mj_fwdPosition(self.scene.model, data)
        mujoco.mj_fwdVelocity(self.scene.model, data)
        return data

    def forces(self) -> np.ndarray:
        """Generalised forces [N, N m] of `M qacc + bias`, gravity included, shape (nv,)."""
        data = self.at_this_motion()
        at, rate = self.scene.addresses, self.v * self.omega
        data.qacc = self.S @ (self.u_x, self.u_theta)
        data.qacc[at.root_qvel] += -rate * np.sin(self.theta)  # d/dt of S
        data.qacc[at.root_qvel + 1] += rate * np.cos(self.theta)
        forces = np.empty(self.scene.model.nv)
        mujoco.mj_rne(self.scene.model, data, 1, forces)
        return forces + self.scene.model.dof_armature * data.qacc  # rotors are no bodies, so mj_rne leaves them out

    def external_wrench(self) -> np.ndarray:
        """Force [N] and moment [N m] on the whole robot at the axle midpoint, body frame, shape (6,)."""
        root = self.scene.addresses.root_qvel[0]
        wrench = self.forces()[root : root + 6]
        c, s = np.cos(self.theta), np.sin(self.theta)
        wrench[:2] = c * wrench[0] + s * wrench[1], c * wrench[1] - s * wrench[0]
        return wrench


@pytest.fixture(scope="module", params=assets.robots())
def motions(request: pytest.FixtureRequest) -> list[Motion]:
    scene = make_scene(SceneSpec(("robot",), request.param))
    return [Motion(scene, *each) for each in MOTIONS * most(scene.drive)]


def assert_close(found: np.ndarray, expected: np.ndarray, size: float) -> None:
    """Asserts equality relative to the size of what is compared."""
    np.testing.assert_allclose(found, expected, rtol=0, atol=MASS_MATRIX * size)


def test_ground_wrench_with_its_coriolis_terms(motions: list[Motion]) -> None:
    for motion in motions:
        wrench, expected = motion.external_wrench(), np.array(motion.drive.ground_wrench(*motion.reduced))
        weight = motion.drive.mass * 9.81
        assert_close(wrench[:2], expected[:2], weight)
        assert_close(wrench[5], expected[2], weight * motion.drive.half_separation)


def loads(drive: DiffDrive, vertical: float, roll: float, pitch: float) -> np.ndarray:
    """Loads [N] of left, right and caster with this resultant at the axle's ground point."""
    assert len(drive.casters) == 1
    feet = np.array([(0, drive.half_separation), (0, -drive.half_separation), *drive.casters])
    return np.linalg.solve(np.vstack([np.ones(3), feet[:, 1], -feet[:, 0]]), [vertical, roll, pitch])


def test_wheel_loads(motions: list[Motion]) -> None:
    for motion in motions:
        wrench, drive = motion.external_wrench(), motion.drive
        # Friction acts a wheel radius below the axle midpoint, at which MuJoCo's moments are taken.
        roll, pitch = wrench[3] - drive.wheel_radius * wrench[1], wrench[4] + drive.wheel_radius * wrench[0]
        # 100: levers as short as 1 cm turn moments into loads.
        found, tolerance = drive.wheel_loads(*motion.reduced), 100 * wrench[2]
        if len(drive.casters) == 1:
            assert_close(found, loads(drive, wrench[2], roll, pitch)[:2], tolerance)
        else:  # two casters side by side: only what the wheels bear together follows from balance
            (behind, _), (same, _) = drive.casters
            assert behind == pytest.approx(same, rel=HAND)
            assert_close(found.sum(), wrench[2] + pitch / behind, tolerance)
