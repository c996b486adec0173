"""The Waffle Pi with its arm as its file has it: masses, arm, servos and casters against its README."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from nhtrack.studies.fidelity.bench import Bench
from nhtrack.studies.fidelity.motion import drive_open_loop, state_of
from papers import MODELS, numbers, of_boxes, of_parts, readme_table

FILE = MODELS / "waffle" / "robot.xml"
GRAVITY = 9.81
WRITTEN = 1e-9  # masses are written out; centres [m] and inertias [kg m^2] to nine digits
RPM = 2 * np.pi / 60


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(FILE))


@pytest.fixture(scope="module")
def data(model: mujoco.MjModel) -> mujoco.MjData:
    """The robot at its key `home`."""
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    mujoco.mj_forward(model, data)
    return data


def inertia_of(model: mujoco.MjModel, name: str) -> np.ndarray:
    """Inertia of a body about its centre of mass, in its own axes."""
    body, axes = model.body(name), np.zeros(9)
    mujoco.mju_quat2Mat(axes, body.iquat)
    return np.asarray(axes.reshape(3, 3) @ np.diag(body.inertia) @ axes.reshape(3, 3).T)


def boxes(rows: list[list[str]]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Masses, centres and sizes of a table of boxes, in kg and m."""
    mass = 1e-3 * np.array([float(row[1]) for row in rows])
    at, size = (1e-3 * np.array([numbers(row[column]) for row in rows]) for column in (2, 3))
    return mass, at, size


def test_the_base_is_its_parts_and_the_arm_s_foot(model: mujoco.MjModel) -> None:
    mass, at, size = boxes(readme_table("waffle", "Inertia of the base"))
    com, inertia = of_boxes(mass, at, size)
    foot = np.array([-0.092 + 3.0876154e-04, 0.0, 0.101 - 1.2176461e-04])
    own = np.array([[1.2505234e-05, 0, -1.7855208e-07], [0, 2.1898364e-05, 0], [-1.7855208e-07, 0, 1.9267361e-05]])
    masses = np.array([mass.sum(), 0.079119962])
    com, inertia = of_parts(masses, np.array([com, foot]), np.array([inertia, own]))
    body = model.body("base_footprint")
    assert body.mass[0] == pytest.approx(masses.sum(), rel=WRITTEN)
    np.testing.assert_allclose(body.ipos, com, rtol=0, atol=1e-9)
    np.testing.assert_allclose(inertia_of(model, "base_footprint"), inertia, rtol=0, atol=1e-10)


def test_the_hand_is_link5_and_two_fingers(model: mujoco.MjModel) -> None:
    link5, fingers = readme_table("waffle", "The arm")[4:]
    own = np.array([[8.0870749e-05, 0, -1.0157896e-06], [0, 7.5980465e-05, 0], [-1.0157896e-06, 0, 9.3127351e-05]])
    finger, size = float(fingers[1]) / 2, np.array([0.088, 0.04, 0.058])
    box = finger / 12 * (size @ size * np.eye(3) - np.diag(size**2))
    left, right = 1e-3 * np.array(numbers(fingers[2])).reshape(2, 3)
    centre = (0.044206755, 0.0, 0.0089142216)
    np.testing.assert_allclose(1e3 * np.array(centre), numbers(link5[2]), rtol=0, atol=5e-4)
    masses = np.array([float(link5[1]), finger, finger])
    com, inertia = of_parts(masses, np.array([centre, left, right]), np.array([own, box, box]))
    assert model.body("link5").mass[0] == pytest.approx(masses.sum(), rel=WRITTEN)
    np.testing.assert_allclose(model.body("link5").ipos, com, rtol=0, atol=1e-9)
    np.testing.assert_allclose(inertia_of(model, "link5"), inertia, rtol=0, atol=1e-12)


@pytest.mark.parametrize("row", [1, 2, 3])
def test_links_are_those_of_the_readme(model: mujoco.MjModel, row: int) -> None:
    name, mass, centre, _ = readme_table("waffle", "The arm")[row]
    assert model.body(name).mass[0] == pytest.approx(float(mass), rel=1e-7)
    np.testing.assert_allclose(1e3 * model.body(name).ipos, numbers(centre), rtol=0, atol=5.1e-4)


def test_base_and_arm_weigh_what_their_maker_says(model: mujoco.MjModel) -> None:
    assert model.body_mass.sum() == pytest.approx(1.8 + 0.71137, rel=WRITTEN)
    arm = sum(float(row[1]) for row in readme_table("waffle", "The arm"))
    assert arm == pytest.approx(0.71137, rel=1e-7)


def test_the_servos_are_the_motor_s_line_seen_at_the_rotor(model: mujoco.MjModel) -> None:
    stall, no_load = 2.7, 70 * RPM
    for servo in (model.actuator(0), model.actuator(1)):
        gear = servo.gear[0]
        assert gear == 212.6
        np.testing.assert_allclose(servo.forcerange[1] * gear, stall, rtol=1e-6)
        np.testing.assert_allclose(servo.ctrlrange[1] / gear, no_load, rtol=1e-6)
        assert servo.gainprm[0] * gear**2 == pytest.approx(stall / no_load, rel=1e-6)


def test_the_arm_is_folded_at_home(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    np.testing.assert_allclose([data.joint(f"joint{k}").qpos[0] for k in (1, 2, 3, 4)], [0, -1, 0.7, 0.3])
    hand = data.site("end_effector").xpos
    assert 0.25 < hand[2] < 0.35  # above the lidar, which ends at 0.14
    com = data.subtree_com[model.body("base_footprint").id]
    assert com[0] / com[2] * -GRAVITY == pytest.approx(5.18, abs=0.05)  # 5.16 with the wheels' own inertia


def test_reaching_out_would_cost_the_casters_their_load(model: mujoco.MjModel) -> None:
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    for name, angle in {"joint2": 0.8, "joint3": -0.4, "joint4": -0.4}.items():
        data.joint(name).qpos[0] = angle
    mujoco.mj_forward(model, data)
    com = data.subtree_com[model.body("base_footprint").id]
    assert com[0] == pytest.approx(-0.019, abs=5e-4)
    assert com[0] / com[2] * -GRAVITY == pytest.approx(1.9, abs=0.05)


def test_it_stands_on_two_tyres_and_two_casters(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    resting = mujoco.MjData(model)
    mujoco.mj_copyData(resting, model, data)
    for _ in range(1000):
        mujoco.mj_step(model, resting)
    touching = [model.geom(max(contact.geom)).name for contact in resting.contact[: resting.ncon]]
    assert set(touching) == {"left tire", "right tire", "caster_back_left", "caster_back_right"}


# driven ---------------------------------------------------------------------------------------------------------------


def test_wheels_and_casters_share_a_sideways_load_as_predicted() -> None:
    """Four supports: balance leaves one of their loads open, which the compliances of the contacts settle."""
    bench = Bench("waffle")
    v, omega = 0.5 * bench.drive.top_speed, 0.6
    run = drive_open_loop(
        bench.simulation(dt=0.01), np.zeros((20, 1, 2)), state_of(((0, 0, 0), (v, omega))), ("wheel_load",)
    )
    still = np.zeros(())
    expected = bench.drive.wheel_loads(np.array(v), np.array(omega), still, still)
    alike = replace(bench.drive, compliances=()).wheel_loads(np.array(v), np.array(omega), still, still)
    weight = bench.drive.mass * GRAVITY
    found = run.telemetry["wheel_load"][-1, 0]
    assert np.abs(found - expected).max() < 1e-5 * weight  # the robot has turned its speed a little since
    assert np.abs(alike - expected).max() > 1e-4 * weight
