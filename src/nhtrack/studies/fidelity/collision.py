"""How hulls collide: what two robots keep of their momentum, how fast they part, how far they overlap."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import mujoco
import numpy as np

from nhtrack.arrays import Array
from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.touch import FIELDS
from nhtrack.studies.fidelity.bench import Bench, Finding
from nhtrack.studies.fidelity.motion import state_of

_SPEEDS = (0.1, 0.2)  # [m/s] at which robots coast into each other
_ASIDE = 0.4  # of the reach of a hull, by which the one that is hit off its centre is


class Collision(NamedTuple):
    """What two robots did on a floor without friction, and what their hulls' contact was.

    Attributes:
        momentum: that of both before and after, along x and y [kg m/s], and its moment about their CoM [kg m^2/s].
        parting: how fast they parted along x, over how fast they met [1].
        impulse: of the normal forces over what the one that was hit gained of momentum [1].
        overlap: the largest, over the speed at which the hulls closed in [s].
    """

    momentum: tuple[Array, Array]
    parting: float
    impulse: float
    overlap: float


def collisions(bench: Bench) -> Iterator[Finding]:
    """Yields figures of hulls that meet head-on, that hit one at rest, and that hit it off its centre.

    MuJoCo's reference for contacts like those of hulls is critically damped, a = -2 x'/T - x/T^2 with T = d timeconst.
    From x' = -v it comes to x = -v T/e, and lets go where a is zero, after 2 T, at the speed v/e^2.
    """
    meeting = [(v, other) for v in _SPEEDS for other in (v, 0.0)]
    scene = bench.scene(robots=("robot", "other"), robot_contact=True, friction=0.0)
    time = _time_of(scene.model)
    central = [_collide(bench, *each) for each in meeting]
    aside = [_collide(bench, v, 0.0, _ASIDE) for v in _SPEEDS]
    kept = max(_lost(each, v) for each, (v, _) in zip(central, meeting, strict=True))
    cause = "MuJoCo's least friction of 1e-5 between wheels and floor"
    yield bench.find("collision: momentum lost", kept, "1", 1e-3, cause)
    lost = [_lost(each, v) for each, v in zip(aside, _SPEEDS, strict=True)]
    yield bench.find("collision off the centre: momentum and its moment lost", max(lost), "1", 2e-3, cause)
    impulse = max(abs(each.impulse - 1) for each in central)
    yield bench.find("collision: impulse against momentum gained", impulse, "1", 0.02, cause)
    parting = max(abs(each.parting - math.exp(-2)) for each in central)
    cause = "hulls meet above or below centres of mass, and pitch; some meet in several points"
    yield bench.find("collision: restitution less 1/e^2", parting, "1", 0.4, cause)
    overlap = max(abs(each.overlap / (time / math.e) - 1) for each in central)
    yield bench.find("collision: overlap against v T/e", overlap, "1", 0.25, cause)


def _time_of(model: mujoco.MjModel) -> float:
    """Returns T of the hulls' contacts [s]: they are as soft as MuJoCo has them."""
    softest = max(np.flatnonzero(model.geom_contype == 2), key=lambda geom: model.geom_solref[geom, 0])
    return float(model.geom_solref[softest, 0] * model.geom_solimp[softest, 1])


def _reach(model: mujoco.MjModel) -> float:
    """Returns how far hulls reach from a robot's axle at most [m]."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    hulls = model.geom_contype == 2
    return float((np.hypot(*data.geom_xpos[hulls, :2].T) + model.geom_rbound[hulls]).max())


def _collide(bench: Bench, v: float, other: float, aside: float = 0.0) -> Collision:
    """Returns what comes of a robot that drives at v along x and one that comes towards it, or is at rest."""
    simulation = bench.simulation(robots=("robot", "other"), robot_contact=True, friction=0.0)
    apart = 2 * _reach(simulation.scene.model)
    simulation.reset(state_of(((0, 0, 0), (v, 0)), ((apart, aside * apart / 2, math.pi), (other, 0))))
    before = _momentum(simulation)
    xi = simulation.drive_by(np.zeros((round((apart / (v + other) + 0.1) / simulation.dt), 2, 2))).xi
    (noted,) = simulation.motion.touch[np.isfinite(simulation.motion.touch[..., 0])]
    touch = dict(zip(FIELDS, noted, strict=False))
    parting = -(xi[-1, 0, 0] + xi[-1, 1, 0]) / (v + other)
    impulse = touch["impulse"] / (bench.drive.mass * (other - xi[-1, 1, 0]))
    return Collision((before, _momentum(simulation)), parting, impulse, touch["overlap"] / touch["closing_speed"])


def _lost(collision: Collision, v: float) -> float:
    before, after = collision.momentum
    return float(np.abs(after - before).max() / v)


def _momentum(simulation: MujocoSimulation) -> Array:
    """Returns momentum and moment of momentum of a scene in shares of what its first robot has at 1 m/s, shape (3,)."""
    model, data = simulation.scene.model, mujoco.MjData(simulation.scene.model)
    data.qpos, data.qvel = simulation.qpos, simulation.qvel
    mujoco.mj_fwdPosition(model, data)
    mujoco.mj_fwdVelocity(model, data)
    mujoco.mj_subtreeVel(model, data)
    mass = float(model.body_mass.sum())
    whole = mass * data.subtree_linvel[0, :2]
    return np.array([*whole, data.subtree_angmom[0, 2] / _reach(model)]) / (mass / 2)
