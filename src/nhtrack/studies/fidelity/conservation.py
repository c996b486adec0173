"""What must not change: energy but by work and friction, a robot at rest, mirror images, the place, the process."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from collections.abc import Iterator

import mujoco
import numpy as np

from nhtrack import se2
from nhtrack.arrays import Array
from nhtrack.effects.motors import Motors
from nhtrack.simulation.contact import FrictionRow
from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.scene import Scene
from nhtrack.studies.fidelity.bench import Bench, Finding
from nhtrack.studies.fidelity.losses import NO_TORQUE
from nhtrack.studies.fidelity.motion import AT_REST, drive_open_loop, middles, state_of, weave_within

_LOADED = 10  # steps within which contacts have loaded up
_ROUNDING = "rounding, which nothing amplifies below the limit of friction"


def energy(bench: Bench) -> Iterator[Finding]:
    """Yields what is left of the balance: work of the wheel torques = kinetic energy gained + heat of all friction.

    In shares of the work done, sum of magnitudes: for a drive within friction, and for a launch on spinning wheels.
    """
    weave = weave_within(bench.drive, 0.5)
    inside = _imbalance(bench.simulation(), weave(middles(3.0, 0.001))[:, None])
    cause = "work is summed by the trapezoidal rule, wheel speeds live half a step before the torques' times"
    yield bench.find("energy balance, rolling", inside, "1", 1e-3, cause)
    drive = bench.drive
    torque = drive.motor.torque_limit - max(drive.losses.dry_friction)
    hardest = 2 * torque / (drive.wheel_radius * drive.m_eff)
    launch = np.broadcast_to([min(4.0, hardest), 0.0], (200, 1, 2))
    friction = 0.3 * launch[0, 0, 0] / 9.81
    outside = _imbalance(bench.simulation(friction=friction), launch)
    cause = "the first step of a slide, in which wheels are lifted a little before they are known to slide"
    yield bench.find("energy balance, wheels spinning", outside, "1", 2e-4, cause)


def coasting(bench: Bench) -> Iterator[Finding]:
    """Yields what a turning robot whose motors are off gains in kinetic energy over 3 s, in shares of what it has.

    What losses at the wheel joints take counts as kept. Energies are those of the wheel speeds, half a step apart.

    MuJoCo takes the centripetal force m c omega^2 from velocities half a step old. While the centre of mass, c ahead of
    the axle, trades speed for turn at omega' = -m c v omega / J, that force is off by m c h omega omega' and does the
    work (m c v omega)^2 h / J a second. What is gained beyond that is second order in the step. The energy of casters
    that swivel is not the reduced model's; of their robots `energy` has the balance.
    """
    if bench.swivels:
        return
    drive = bench.drive
    start = state_of(((0, 0, 0), (0.15 * drive.top_speed, 0.15 * drive.top_speed / drive.half_separation)))
    simulation = bench.simulation(effects=(Motors(torque_limit=NO_TORQUE),))
    h = simulation.dt
    speeds = drive_open_loop(simulation, np.zeros((round(3.0 / h), 1, 2)), start, ("wheel_speed",))
    wheels = speeds.telemetry["wheel_speed"][_LOADED:, 0]
    motion = wheels @ np.linalg.inv(drive.rolling_map).T
    kinetic = ((motion @ drive.mass_matrix) * motion).sum(axis=-1) / 2
    v, omega = ((motion[1:] + motion[:-1]) / 2).T
    late = -h * np.cumsum(drive.first_moment[0] * v * omega * np.diff(motion[:, 1]))
    gain = kinetic[1:] - kinetic[0] + h * np.cumsum(_lost(simulation.scene, wheels))
    cause = "MuJoCo's centripetal force is half a step late; first order in the step, none where the CoM is on the axle"
    yield bench.find("energy gained while coasting", gain.max() / kinetic[0], "1", 2e-3, cause)
    cause = "second order in the step"
    yield bench.find("the same, beyond the late force's work", (gain - late).max() / kinetic[0], "1", 1e-5, cause)


def rest(bench: Bench) -> Iterator[Finding]:
    """Yields the speed at which a robot that is told nothing drifts over 10 s."""
    run = drive_open_loop(bench.simulation(dt=0.01), np.zeros((1000, 1, 2)))
    drift = np.abs(run.g[-1, 0, :2]).max() / run.time[-1]
    yield bench.find("drift at rest", drift, "m/s", 1e-9, "placed a nanometre into the floor, robots rise by it")


def symmetry(bench: Bench) -> Iterator[Finding]:
    """Yields differences of a drive from its mirror image, and from itself at another place and heading.

    A robot whose wheels lose unlike torques is not its own mirror image.
    """
    inputs = weave_within(bench.drive, 0.5)(middles(3.0, 0.01))[:, None]
    start, image = state_of(((0, 0, 0.3), (0, 0))), state_of(((0, 0, -0.3), (0, 0)))
    moved = np.array([3.0, -2.0, 1.9])
    here = drive_open_loop(bench.simulation(dt=0.01), inputs, start)
    mirrored = drive_open_loop(bench.simulation(dt=0.01), inputs * (1, -1), image)
    there = drive_open_loop(bench.simulation(dt=0.01), inputs, start._replace(g=se2.compose(moved, start.g)))
    reflected = np.abs(mirrored.g * (1, -1, -1) - here.g).max()
    if all(left == right for left, right in (bench.drive.losses.damping, bench.drive.losses.dry_friction)):
        yield bench.find("mirror symmetry", reflected, "m, rad", 1e-9, _ROUNDING)
    shifted = np.abs(there.g - se2.compose(moved, here.g)).max()
    yield bench.find("left-shift invariance", shifted, "m, rad", 1e-9, _ROUNDING)


def determinism(bench: Bench) -> Iterator[Finding]:
    """Yields how many different results this process and a fresh one give, less one."""
    command = [sys.executable, "-c", f"from {__name__} import digest; print(digest({bench.robot!r}), end='')"]
    other = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    found = {digest(bench.robot), other}
    yield bench.find("different results of two processes", len(found) - 1, "1", 0, "one order of every sum")


def digest(robot: str) -> str:
    """Returns a hash of all poses, twists and loads of a short drive, and of the compiled model."""
    bench = Bench(robot)
    simulation = bench.simulation(dt=0.01)
    inputs = weave_within(bench.drive, 0.5)(middles(1.0, 0.01))[:, None]
    run = drive_open_loop(simulation, inputs, AT_REST, ("wheel_load", "wheel_torque"))
    arrays = [run.time, run.g, run.xi, *run.telemetry.values()]
    content = b"".join(array.tobytes() for array in arrays)
    return hashlib.sha256(content + simulation.scene.hash.encode()).hexdigest()


def _imbalance(simulation: MujocoSimulation, inputs: Array) -> float:
    """Returns |work - energy - heat| in shares of the work done, for a run of single physics steps from rest.

    Over a step forces act by the mean of the velocities at its ends, seen in the configuration at its middle. Heat is
    that of tyres on the floor and of the wheel joints.
    """
    simulation.reset(AT_REST)
    at_rest = _energy(simulation)
    qpos, qvel, torque, force = [], [simulation.qvel], [], []
    for u in inputs:
        qpos.append(simulation.qpos)
        simulation.step(u)
        qvel.append(simulation.qvel)
        torque.append(simulation.telemetry()["wheel_torque"][0])
        force.append(simulation.contact_force[0, :, :2])
    h, mean = simulation.dt, (np.array(qvel[:-1]) + qvel[1:]) / 2
    wheels = simulation.scene.addresses.wheel_qvel[0]
    power = (np.array(torque) * mean[:, wheels]).sum(axis=-1)
    heat = h * _lost(simulation.scene, np.array(qvel)[:, wheels]).sum()
    heat -= h * (np.array(force) * _tyre_velocities(simulation.scene, np.array(qpos), mean)).sum()
    return float(abs(h * power.sum() - (_energy(simulation) - at_rest) - heat) / (h * np.abs(power).sum()))


def _lost(scene: Scene, speed: Array) -> Array:
    """Returns the mean power that losses take in the steps between wheel speeds, shape (k, 2) -> (k - 1,) [W]."""
    losses, mean = scene.drive.losses, (speed[1:] + speed[:-1]) / 2
    torque = losses.viscous(mean)
    for wheel, dof in enumerate(scene.addresses.wheel_qvel[0]):
        row, dry = FrictionRow.of_joint(scene.model, int(dof)), losses.dry_friction[wheel]
        torque[:, wheel] += np.clip(row.force(speed[:-1, wheel], speed[1:, wheel]), -dry, dry)
    power: Array = (torque * mean).sum(axis=-1)
    return power


def _tyre_velocities(scene: Scene, qpos: Array, qvel: Array) -> Array:
    """Returns the horizontal velocities of the tyres' contact points, shape (steps, 2, 2) [m/s], world frame."""
    at, drive = scene.addresses, scene.drive
    (place,), (root,) = at.root_qpos, at.root_qvel
    theta = 2 * np.arctan2(qpos[:, place + 6], qpos[:, place + 3])
    ahead = np.stack([np.cos(theta), np.sin(theta)], axis=-1)[:, None]
    across = drive.half_separation * np.array([1.0, -1.0])
    backwards = qvel[:, [root + 5]] * across + drive.wheel_radius * qvel[:, at.wheel_qvel[0]]
    return np.asarray(qvel[:, None, root : root + 2] - backwards[..., None] * ahead)


def _energy(simulation: MujocoSimulation) -> float:
    """Returns kinetic energy and height of a whole scene by MuJoCo's own mass matrix [J], at the velocities' time.

    That of a scene with viscous friction is that of a step, see `DiffDrive.mass_matrix_over`.
    """
    model, data = simulation.scene.model, mujoco.MjData(simulation.scene.model)
    momentum = np.zeros(model.nv)
    data.qpos, data.qvel = simulation.qpos, simulation.qvel
    mujoco.mj_integratePos(model, data.qpos, data.qvel, -model.opt.timestep / 2)
    mujoco.mj_fwdPosition(model, data)
    mujoco.mj_energyPos(model, data)
    mujoco.mj_mulM(model, data, momentum, data.qvel)
    momentum -= model.opt.timestep / 2 * model.dof_damping * data.qvel
    return float(data.qvel @ momentum / 2 + data.energy[0])
