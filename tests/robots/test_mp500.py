"""The MP-500 as its file has it: parts, wheels, servos and caster against its README, and the caster at work."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from papers import MODELS, numbers, of_boxes, readme_quantity, readme_table

FILE = MODELS / "mp500" / "robot.xml"
AXLE = np.array([0.1155, 0.0, -0.084])  # the axle midpoint in the frame of the platform [m]
FLOOR = np.array([0.1155, 0.0, -0.214])  # the frame of the maker's drawing
TRAIL, SWIVEL, ROLLER = 0.06, -0.43, 0.08  # [m]
GRAVITY = 9.81
WRITTEN = 1e-9  # masses and lengths are written out

# [1] share of a turn of the caster by which it may be off the direction in which it has to trail, when it has had ten
# trails to settle: e^-10, and the slip of its contact.
TRAILING = 1e-3


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    """The robot on a floor, as `python -m mujoco.viewer` would have it."""
    spec = mujoco.MjSpec.from_file(str(FILE))
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1])
    return spec.compile()


def settled(model: mujoco.MjModel, command: tuple[float, float], seconds: float) -> mujoco.MjData:
    """The state after a while under constant commands of the servos [rad/s], from rest."""
    data = mujoco.MjData(model)
    data.ctrl[:] = command
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
    return data


def test_the_parts_in_the_file_are_those_of_the_readme(model: mujoco.MjModel) -> None:
    rows = readme_table("mp500", "Mass budget")
    for name, mass, centre, size, _ in rows:
        part = model.geom(name)
        np.testing.assert_allclose(part.pos - FLOOR, 1e-3 * np.array(numbers(centre)), rtol=0, atol=WRITTEN)
        np.testing.assert_allclose(2 * part.size, 1e-3 * np.array(numbers(size)), rtol=0, atol=WRITTEN)
        assert part.type[0] == mujoco.mjtGeom.mjGEOM_BOX
        assert part.group[0] == 4  # weighs, and is not seen
        assert float(mass) > 0
    mass, at = np.array([float(row[1]) for row in rows]), np.array([numbers(row[2]) for row in rows])
    com, inertia = of_boxes(mass, 1e-3 * at, 1e-3 * np.array([numbers(row[3]) for row in rows]))
    platform, axes = model.body("platform"), np.zeros(9)
    mujoco.mju_quat2Mat(axes, platform.iquat)
    rotation = axes.reshape(3, 3)
    assert platform.mass[0] == pytest.approx(mass.sum(), rel=WRITTEN)
    np.testing.assert_allclose(platform.ipos - FLOOR, com, rtol=0, atol=WRITTEN)
    np.testing.assert_allclose(rotation @ np.diag(platform.inertia) @ rotation.T, inertia, rtol=0, atol=1e-9)


def test_the_robot_weighs_what_its_maker_says(model: mujoco.MjModel) -> None:
    assert model.body_mass.sum() == pytest.approx(70.0, abs=1e-9)
    assert model.body("caster_fork").mass[0] == pytest.approx(0.85, rel=WRITTEN)
    assert model.body("caster_wheel").mass[0] == pytest.approx(0.95, rel=WRITTEN)


def test_the_servos_follow_from_motor_gear_and_belt(model: mujoco.MjModel) -> None:
    ratio, radius = 8 * 1.5, 0.13
    for side in ("left", "right"):
        servo, joint = model.actuator(f"drive_{side}"), model.joint(f"wheel_{side}_joint")
        np.testing.assert_allclose(servo.forcerange, [-0.95 * ratio, 0.95 * ratio], rtol=WRITTEN)
        np.testing.assert_allclose(servo.ctrlrange, [-1.5 / radius, 1.5 / radius], rtol=5e-5)
        assert servo.gainprm[0] == -servo.biasprm[2] == 10
        rated, speed = 0.95 * ratio, 3000 * 2 * np.pi / 60 / ratio
        assert joint.damping[0] == pytest.approx((1 - 0.96 * 0.98) * rated / speed, rel=2e-3)
        assert joint.armature[0] == pytest.approx(2.8e-5 * ratio**2, rel=0.01)
    printed = {row[0].split(" (")[0]: row[1] for row in readme_table("mp500", "Motors")}
    assert readme_quantity(printed["torque limit"])[0] == pytest.approx(0.95 * ratio, rel=WRITTEN)
    assert readme_quantity(printed["damping"])[0] == model.joint("wheel_left_joint").damping[0]


def test_rated_torque_gives_the_acceleration_that_the_maker_allows(model: mujoco.MjModel) -> None:
    wheel = model.body("wheel_left")
    spin = wheel.inertia.max() + model.joint("wheel_left_joint").armature[0]
    acceleration = 2 * 11.4 / 0.13 / (model.body_mass.sum() + 2 * spin / 0.13**2)
    assert acceleration == pytest.approx(2.43, abs=0.005)  # as the README says, beside the maker's 2.4


def test_at_rest_it_stands_on_its_tyres_and_its_caster(model: mujoco.MjModel) -> None:
    data = settled(model, (0.0, 0.0), 2.0)
    assert np.abs(data.qvel).max() < 1e-6
    touching = {model.body(model.geom_bodyid[max(contact.geom)]).name for contact in data.contact[: data.ncon]}
    assert touching == {"wheel_left", "wheel_right", "caster_wheel"}


@pytest.mark.parametrize(("command", "rest"), [((4.0, 4.0), 0.0), ((-4.0, -4.0), np.pi), ((4.0, 2.0), None)])
def test_the_caster_trails(model: mujoco.MjModel, command: tuple[float, float], rest: float | None) -> None:
    """Its wheel rolls where its swivel has just been: v sin(phi) = omega (s cos(phi) - e)."""
    data = mujoco.MjData(model)
    data.joint("caster_swivel").qpos[0] = 0.4
    data.ctrl[:] = command
    for _ in range(3000):
        mujoco.mj_step(model, data)
    v, omega, phi = np.hypot(*data.qvel[:2]), data.qvel[5], data.joint("caster_swivel").qpos[0]
    if rest is None:
        ahead = np.sign(data.qvel[:2] @ (np.cos(heading(data)), np.sin(heading(data))))
        assert ahead * v * np.sin(phi) == pytest.approx(omega * (SWIVEL * np.cos(phi) - TRAIL), abs=0.02 * abs(omega))
    else:
        assert np.cos(phi - rest) > 1 - TRAILING
    rolled = data.joint("caster_roll").qvel[0] * ROLLER
    assert abs(rolled) == pytest.approx(v, rel=0.1)


def heading(data: mujoco.MjData) -> float:
    return float(2 * np.arctan2(data.qpos[6], data.qpos[3]))
