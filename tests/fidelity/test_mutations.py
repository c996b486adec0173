"""The budgets can be broken: one wrong sign, number or shape, and the open-loop run leaves its budget."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import mujoco
import pytest

from motions import OpenLoopError, weaving_error
from nhtrack.errors import SimulationDiverged
from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.scene import Scene, SceneSpec, make_scene
from tolerances import OPEN_LOOP_HEADING, OPEN_LOOP_POSITION, OPEN_LOOP_POSITION_UNCORRECTED

pytestmark = pytest.mark.slow

SPEC = SceneSpec(("robot",))
DURATION = 4.0  # [s] long enough for 1 m of path and 3 rad of turn


def sound(scene: Scene) -> Scene:
    return scene


def torques_swapped(scene: Scene) -> Scene:
    at = scene.addresses
    return replace(scene, addresses=replace(at, motors=at.motors[:, ::-1]))


def no_first_moment(scene: Scene) -> Scene:
    return replace(scene, drive=replace(scene.drive, com=(0.0, 0.0, scene.drive.com[2])))


def no_wheel_spin(scene: Scene) -> Scene:
    return replace(scene, drive=replace(scene.drive, wheel_inertia=0.0))


def wider(scene: Scene) -> Scene:
    """Returns the scene with an axle that the reduced model takes for 0.1 % wider than it is."""
    return replace(scene, drive=replace(scene.drive, half_separation=1.001 * scene.drive.half_separation))


def cylinders(scene: Scene) -> Scene:
    """Returns the scene with tyres as cylinders, which stand on a line: it resists turning."""
    robot = mujoco.MjSpec.from_string(scene.xml)
    for tyre in scene.addresses.tyres.ravel():
        geom = robot.geom(scene.model.geom(int(tyre)).name)
        geom.type, geom.size = mujoco.mjtGeom.mjGEOM_CYLINDER, (0.03, 0.004, 0.0)
        geom.quat = (0.5**0.5, 0.5**0.5, 0.0, 0.0)  # the axis of a cylinder is its own z
    return replace(scene, model=robot.compile())


def correction_reversed(simulation: MujocoSimulation) -> None:
    sound = simulation._surface_velocity
    simulation._surface_velocity = lambda *motion: -sound(*motion)  # type: ignore[method-assign]


def correction_halved(simulation: MujocoSimulation) -> None:
    sound = simulation._surface_velocity
    simulation._surface_velocity = lambda *motion: sound(*motion) / 2  # type: ignore[method-assign]


def error(
    spec: SceneSpec, change: Callable[[Scene], Scene] = sound, tamper: Callable | None = None
) -> OpenLoopError:
    simulation = MujocoSimulation(change(make_scene(spec)), spec.timestep)
    if tamper is not None:
        tamper(simulation)
    try:
        return weaving_error(simulation, DURATION)
    except SimulationDiverged:  # further off than any budget
        return OpenLoopError(math.inf, math.inf)


def test_unchanged_it_is_within_both_budgets() -> None:
    found = error(SPEC)
    assert found.position <= OPEN_LOOP_POSITION
    assert found.heading <= OPEN_LOOP_HEADING


@pytest.mark.parametrize("tamper", [correction_reversed, correction_halved])
def test_a_wrong_rate_correction_breaks_the_position_budget(tamper: Callable) -> None:
    assert error(SPEC, tamper=tamper).position > 10 * OPEN_LOOP_POSITION


@pytest.mark.parametrize("change", [torques_swapped, no_first_moment, no_wheel_spin, wider])
def test_a_wrong_model_breaks_both_budgets(change: Callable[[Scene], Scene]) -> None:
    found = error(SPEC, change)
    assert found.position > 10 * OPEN_LOOP_POSITION
    assert found.heading > 10 * OPEN_LOOP_HEADING


def test_mujocos_default_contacts_break_the_uncorrected_budget() -> None:
    plain = replace(SPEC, rate_correction=False)
    assert error(plain).position <= OPEN_LOOP_POSITION_UNCORRECTED
    assert error(replace(plain, contact="default")).position > OPEN_LOOP_POSITION_UNCORRECTED


def test_cylinders_for_tyres_break_the_uncorrected_budget() -> None:
    """A line of contact holds the yaw: the robot hardly turns."""
    found = error(replace(SPEC, rate_correction=False), cylinders)
    assert found.position > 10 * OPEN_LOOP_POSITION_UNCORRECTED
    assert found.heading > 1.0
