"""The reduced model against MuJoCo's own mass matrix, inverse dynamics and accelerations."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from nhtrack.arrays import Array
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.simulation.scene import Scene
from nhtrack.studies.fidelity.bench import Bench, Finding
from nhtrack.studies.fidelity.casters import RollingCasters
from nhtrack.studies.fidelity.motion import AT_REST

_MOTIONS = np.random.default_rng(2024).uniform(-1, 1, (12, 5))  # theta, v, omega, u_x, u_theta in shares of `_most`


def reduced_model(bench: Bench) -> Iterator[Finding]:
    """Yields how far S^T M S is from the reduced mass matrix, and inverse dynamics from the wheel torques.

    MuJoCo's has what viscous friction adds in a step (`DiffDrive.mass_matrix_over`). S maps (v, omega) to MuJoCo's
    velocities under no slip. No contact is involved: recursive Newton-Euler gives the
    forces that a prescribed motion takes, and their projection on S is what the motors supply.
    """
    scene = bench.scene()
    motions = _MOTIONS * _most(scene.drive)
    cause = "rounding: no number of the reduced model is typed, all are read from MuJoCo's mass matrix"
    matrix = max(_matrix_error(scene, theta) for theta in motions[:, 0])
    yield bench.find("mass matrix in (v, omega)", matrix, "1", 1e-12, cause)
    torque = max(_torque_error(scene, motion) for motion in motions)
    yield bench.find("wheel torques of any motion", torque, "1", 1e-12, cause)


def accelerations(bench: Bench) -> Iterator[Finding]:
    """Yields how far straight acceleration and spin under constant torques are from their closed forms.

    `u_x = 2 tau / (r m_eff)` and `u_theta = 2 tau b / (r J_eff)`, with the wheels' and rotors' inertia in both, over
    ten steps from rest, with what losses take on top. In a spin
    what the offset of the CoM adds is then of the order of the turn squared.
    """
    scene = bench.scene()
    drive, at = scene.drive, scene.addresses
    torque = 0.02 * drive.motor.torque_limit
    force, zero = 2 * torque / drive.wheel_radius, np.zeros(())
    inertia, of, budget = (drive.m_eff, drive.J_eff), "", 1e-5
    if bench.swivels:
        still = np.zeros(scene.addresses.casters.shape[1])
        inertia = tuple(RollingCasters(scene).balance(0.0, still, np.zeros(2)).inertia.diagonal())
        of, budget = "swivel casters: ", 1e-4
    expected = force / inertia[0], force * drive.half_separation / inertia[1]
    ahead = drive.wheel_speeds(np.asarray(expected[0]), zero)
    about = drive.wheel_speeds(zero, np.asarray(expected[1]))
    straight = _acceleration(scene, np.array([torque, torque]), ahead)[at.root_qvel[0]]
    spin = _acceleration(scene, np.array([-torque, torque]), about)[at.root_qvel[0] + 5]
    cause = "regularised contacts give way by 1e-4 of the force while they load up"
    for name, found, closed in zip(("straight acceleration", "spin"), (straight, spin), expected, strict=True):
        yield bench.find(f"{of}{name} under constant torque", abs(found / closed - 1), "1", budget, cause)


def load_shares(bench: Bench) -> Iterator[Finding]:
    """Yields how far the wheels' loads at rest are from statics, in shares of the weight."""
    simulation = bench.simulation(dt=0.01)
    drive = simulation.drive
    simulation.reset(AT_REST)
    for _ in range(10):
        simulation.step(np.zeros((1, 2)))
    still = (np.zeros(1),) * 4
    error = np.abs(simulation.telemetry()["wheel_load"] - drive.wheel_loads(*still)).max()
    cause = "contacts are compressed by nanometres, the caster's and the wheels' not alike"
    yield bench.find("wheel loads against statics", error / (drive.mass * 9.81), "1", 1e-6, cause)


def _most(drive: DiffDrive) -> Array:
    """Returns half a turn and the speeds and accelerations at which a robot's motors end."""
    r, b = drive.wheel_radius, drive.half_separation
    speed, force = r * drive.motor.no_load_speed, 2 * drive.motor.torque_limit / r
    return np.array([np.pi, speed, speed / b, force / drive.m_eff, force * b / drive.J_eff])


def _slip_free(scene: Scene, theta: float) -> Array:
    """Returns S, shape (nv, 2), of a robot whose casters do not swivel: the reduced model takes them as fixed."""
    return RollingCasters(scene).slip_free(theta, np.zeros(scene.addresses.casters.shape[1]), rolling=False)[1]


def _posed(scene: Scene, theta: float, qvel: Array) -> mujoco.MjData:
    data = mujoco.MjData(scene.model)
    data.qpos = scene.qpos_of(np.array([[0.0, 0.0, theta]]), np.array([[0.7, -1.9]]))
    data.qvel = qvel
    mujoco.mj_fwdPosition(scene.model, data)
    mujoco.mj_fwdVelocity(scene.model, data)
    return data


def _matrix_error(scene: Scene, theta: float) -> float:
    """Returns the largest deviation of S^T M S from the reduced mass matrix, in shares of its diagonal."""
    S, M = _slip_free(scene, theta), np.zeros((scene.model.nv,) * 2)
    mujoco.mj_fullM(scene.model, _posed(scene, theta, np.zeros(scene.model.nv)), M)
    expected = scene.drive.mass_matrix_over(scene.spec.timestep)
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    return float(np.abs((S.T @ M @ S - expected) / scale).max())


def _torque_error(scene: Scene, motion: Array) -> float:
    """Returns by how much the wheel torques of a motion differ from inverse dynamics, in shares of the weight's."""
    theta, v, omega, u_x, u_theta = motion
    S, root = _slip_free(scene, theta), scene.addresses.root_qvel[0]
    data = _posed(scene, theta, S @ (v, omega))
    data.qacc = S @ (u_x, u_theta)
    data.qacc[root] -= v * omega * np.sin(theta)  # d/dt of S
    data.qacc[root + 1] += v * omega * np.cos(theta)
    forces = np.empty(scene.model.nv)
    mujoco.mj_rne(scene.model, data, 1, forces)
    model, drive = scene.model, scene.drive
    rotors = model.dof_armature - scene.spec.timestep / 2 * model.dof_damping  # no bodies, mj_rne leaves them out
    losses = model.dof_damping * data.qvel + model.dof_frictionloss * np.sign(data.qvel)
    work = S.T @ (forces + rotors * data.qacc + losses)
    left, right = drive.wheel_torques(np.asarray(v), np.asarray(omega), np.asarray(u_x), np.asarray(u_theta))
    r, b = drive.wheel_radius, drive.half_separation
    found = np.array([(left + right) / r, (right - left) / r])
    return float(np.abs(work / (1, b) - found).max() / (drive.mass * 9.81))


def _acceleration(scene: Scene, torque: Array, rate: Array) -> Array:
    """Returns MuJoCo's mean acceleration over ten steps from rest under constant wheel torques, shape (nv,).

    Args:
        scene: of one robot.
        torque: of the wheels [N m], shape (2,), beside what losses take.
        rate: acceleration of the wheels that it should make [rad/s^2], shape (2,): losses go by the speed in a step.
    """
    losses, wheels = scene.drive.losses, scene.addresses.wheel_qvel[0]
    model, data, steps = scene.model, mujoco.MjData(scene.model), 10
    data.qpos = scene.qpos_of(np.zeros((1, 3)), np.zeros((1, 2)))
    for _ in range(steps):
        speed = data.qvel[wheels] + model.opt.timestep / 2 * rate
        data.ctrl[scene.addresses.motors[0]] = torque + losses.viscous(speed) + losses.dry(speed, rate)
        mujoco.mj_step(model, data)
    return np.asarray(data.qvel / (steps * model.opt.timestep))
