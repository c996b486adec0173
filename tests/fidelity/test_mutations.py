"""The budgets can be broken: each fault put into a scene on purpose breaks one that is named here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import mujoco
import pytest

from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.scene import Scene
from nhtrack.studies.fidelity.bench import Bench
from nhtrack.studies.fidelity.suite import CHECKS

STOPPING = "stopping distance with locked wheels"

pytestmark = [pytest.mark.slow, pytest.mark.fidelity]


def wheels_swapped(scene: Scene) -> Scene:
    at = scene.addresses
    return replace(scene, addresses=replace(at, motors=at.motors[:, ::-1]))


def com_mirrored(scene: Scene) -> Scene:
    x, y, height = scene.drive.com
    return replace(scene, drive=replace(scene.drive, com=(-x, y, height)))


def no_wheel_inertia(scene: Scene) -> Scene:
    return replace(scene, drive=replace(scene.drive, wheel_inertia=0.0))


def wider(scene: Scene) -> Scene:
    """Returns the scene with an axle that the reduced model takes for 0.1 % wider than it is."""
    return replace(scene, drive=replace(scene.drive, half_separation=1.001 * scene.drive.half_separation))


def no_priority(scene: Scene) -> Scene:
    """Returns the scene with tyres whose friction is the larger one of their own and the floor's."""
    scene.model.geom_priority[:] = 0
    return scene


def cylinders(scene: Scene) -> Scene:
    """Returns the scene with tyres as cylinders, which stand on a line: it resists turning."""
    robot = mujoco.MjSpec.from_string(scene.xml)
    for tyre in scene.addresses.tyres.ravel():
        geom = robot.geom(scene.model.geom(int(tyre)).name)
        geom.type, geom.size = mujoco.mjtGeom.mjGEOM_CYLINDER, (geom.size[0], geom.size[1], 0.0)
        geom.quat = (0.5**0.5, 0.5**0.5, 0.0, 0.0)  # the axis of a cylinder is its own z
    return replace(scene, model=robot.compile())


def correction_off(simulation: MujocoSimulation) -> None:
    parts = ("before_share", "after_share", "force_share")  # what the correction is made of
    shares = {name: 1.01 * getattr(simulation.wheels, name) for name in parts}
    simulation.wheels = simulation.wheels._replace(**shares)


def correction_on_ice(simulation: MujocoSimulation) -> None:
    """A correction that were a force of its own would move robots without friction too."""
    for model in simulation._models:
        model.opt.gravity[1] += 1e-3 * simulation.wheels.corrected


def hulls_bounce(scene: Scene) -> Scene:
    scene.model.geom_solref[:] = 0.02, 0.3
    return scene


def slip_untold(simulation: MujocoSimulation) -> None:
    simulation.wheels = simulation.wheels._replace(told_of_slip=False)


@dataclass(frozen=True)
class Mutation:
    """A fault, the check that must find it, and the budget that it breaks."""

    name: str
    check: str
    budget: str
    change: Callable[[Scene], Scene] | None = None
    tamper: Callable[[MujocoSimulation], None] | None = None


MUTATIONS = (
    Mutation("rate correction 1 % off", "planar_base", "planar base: position after 10 s", tamper=correction_off),
    Mutation("wheels swapped", "accelerations", "spin under constant torque", wheels_swapped),
    Mutation("centre of mass mirrored", "reduced_model", "wheel torques of any motion", com_mirrored),
    Mutation("centre of mass mirrored", "load_shares", "wheel loads against statics", com_mirrored),
    Mutation("centre of mass mirrored", "planar_base", "planar base: heading after 10 s", com_mirrored),
    Mutation("no wheel inertia", "reduced_model", "mass matrix in (v, omega)", no_wheel_inertia),
    Mutation("no wheel inertia", "accelerations", "straight acceleration under constant torque", no_wheel_inertia),
    Mutation("axle 0.1 % wider", "planar_base", "planar base: heading after 10 s", wider),
    Mutation("wheels not told of their slip", "energy", "energy balance, wheels spinning", tamper=slip_untold),
    Mutation("wheels not told of their slip", "stopping_distance", STOPPING, tamper=slip_untold),
    Mutation("hulls bounce", "collisions", "collision: overlap against v T/e", hulls_bounce),
    Mutation("no geom priority", "friction_limits", "friction limit, turning", no_priority),
    Mutation("cylinder wheels", "accelerations", "spin under constant torque", cylinders),
    Mutation(
        "a correction that pushes", "ice", "no friction: what the rate correction moves", tamper=correction_on_ice
    ),
)


@pytest.mark.parametrize("mutation", MUTATIONS, ids=lambda mutation: f"{mutation.name}-{mutation.check}")
def test_a_fault_breaks_its_budget(mutation: Mutation) -> None:
    """Without the fault it is kept: see test_suite.py."""
    bench = Bench("nh_mini", mutation.change, mutation.tamper)
    findings = {finding.check: finding for finding in CHECKS[mutation.check](bench)}
    assert not findings[mutation.budget].ok
