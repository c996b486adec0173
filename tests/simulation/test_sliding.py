"""Wheels that slide bear what statics gives them, and wheels that roll know nothing of it."""

from __future__ import annotations

import numpy as np
import pytest

from nhtrack.effects.planar_base import PlanarBase
from nhtrack.simulation.contact import FrictionRow, tyre_compliance
from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.scene import make_scene
from nhtrack.simulation.sliding import firm_friction
from nhtrack.simulation.spec import SceneSpec
from nhtrack.simulation.state import Driven, State

STEP = 0.001


def driven(
    u: tuple[float, float], steps: int, names: tuple[str, ...] = ("one",), untold: bool = False, **spec: object
) -> tuple[MujocoSimulation, Driven]:
    """Returns a simulation of single physics steps, robots a metre apart, and how it went from rest."""
    simulation = MujocoSimulation(make_scene(SceneSpec(names, **spec)), STEP)  # type: ignore[arg-type]
    if untold:
        simulation.wheels = simulation.wheels._replace(told_of_slip=False)
    pose = np.zeros((len(names), 3))
    pose[:, 1] = np.arange(len(names))
    simulation.reset(State(0.0, pose, np.zeros_like(pose)))
    return simulation, simulation.drive_by(np.tile(u, (steps, len(names), 1)))


@pytest.mark.parametrize("robot", ["nh_mini", "waffle"])
def test_wheels_that_spin_bear_in_every_step_what_statics_gives(robot: str) -> None:
    """Friction is mu N, so that m a = mu N for both wheels, with N by the reduced model at that acceleration.

    Motors have come to the torque by which they balance friction; wheels hardly speed up any more. A step without the
    correction has loads between nothing and many times the weight.
    """
    friction, zero = 0.05, np.zeros(())
    simulation, run = driven((2.5, 0.0), 200, robot=robot, friction=friction)
    load, drive = run.telemetry["wheel_load"][100:, 0], simulation.drive
    assert np.abs(run.telemetry["longitudinal_slip"][100:]).min() > 0.05
    gained = (run.xi[-1, 0, 0] - run.xi[100, 0, 0]) / (run.t[-1] - run.t[100])
    np.testing.assert_allclose(load, np.tile(drive.wheel_loads(zero, zero, gained, zero), (100, 1)), rtol=2e-3)
    assert gained == pytest.approx(friction * load.mean(axis=0).sum() / drive.mass, rel=1e-4)
    assert np.abs(run.telemetry["wheel_clearance"][100:]).max() < 1e-7
    _, hopping = driven((2.5, 0.0), 200, untold=True, robot=robot, friction=friction)
    assert hopping.telemetry["wheel_load"][100:, 0].std() > 100 * load.std()


def test_a_robot_that_rolls_has_the_bits_of_a_step_of_mujoco_alone() -> None:
    (_, told), (_, untold) = (driven((1.0, 2.0), 50, untold=untold) for untold in (False, True))
    np.testing.assert_array_equal(told.g, untold.g)
    np.testing.assert_array_equal(told.telemetry["wheel_load"], untold.telemetry["wheel_load"])


@pytest.mark.parametrize(("share", "told"), [(0.98, True), (1.02, False)])
def test_tyres_are_told_of_their_slip_up_to_firm_friction(share: float, told: bool) -> None:
    """Beyond it a step is MuJoCo's own, to the last bit; recordings have the number."""
    firm = firm_friction(tyre_compliance(make_scene(SceneSpec(("one",), robot="burger"))))
    assert firm == pytest.approx(0.79, abs=0.01)
    (_, run), (_, own) = (
        driven((25.0, 0.0), 60, untold=untold, robot="burger", friction=share * firm) for untold in (False, True)
    )
    assert np.abs(own.telemetry["longitudinal_slip"]).max() > 1e-3
    assert told != np.array_equal(run.g, own.g)


def test_robots_of_one_scene_slide_as_each_would_alone() -> None:
    """They can touch, and so are stepped together."""
    _, alone = driven((2.5, 1.0), 100, friction=0.1)
    _, both = driven((2.5, 1.0), 100, ("one", "two"), friction=0.1, robot_contact=True)
    for robot in range(2):
        found = both.telemetry["wheel_load"][:, robot]
        np.testing.assert_allclose(found, alone.telemetry["wheel_load"][:, 0], rtol=1e-6, atol=1e-6)
        np.testing.assert_allclose(both.xi[:, robot], alone.xi[:, 0], rtol=0, atol=1e-8)


def test_contacts_of_mujoco_s_own_are_left_alone() -> None:
    simulation, _ = driven((0.0, 0.0), 1, contact="default")
    assert not simulation.wheels.told_of_slip


def test_compliance_is_that_of_rigid_bodies() -> None:
    """Held level and pushed alike at both tyres, a robot gives way by 2/m, and a wheel forwards by r^2/I besides."""
    scene = make_scene(SceneSpec(("one",), effects=(PlanarBase(),)))
    found, drive = tyre_compliance(scene), scene.drive
    np.testing.assert_allclose(found, found.T, rtol=1e-12)
    turned = drive.wheel_radius**2 / drive.wheel_inertia
    assert found[0, 0] + found[0, 3] == pytest.approx(2 / drive.mass + turned, rel=1e-9)
    soft = FrictionRow.of(scene.model, int(scene.addresses.tyres[0, 0])).regularisation
    assert found[2, 2] + found[2, 5] == pytest.approx(2 / drive.mass + soft, rel=1e-9)
