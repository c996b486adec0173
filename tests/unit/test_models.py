"""The robot nh_mini and the arena: structure, statics, mass budget, motors, and rest on the floor."""

import re
import tomllib
from pathlib import Path
from types import ModuleType

import mujoco
import numpy as np
import pytest

MODELS = Path(__file__).resolve().parents[2] / "models"
ROBOT = MODELS / "nh_mini" / "robot.xml"
ARENA = MODELS / "arena" / "scene.xml"
GRAVITY = 9.81
GEOMETRY = 1e-12  # [m] coordinates written in the MJCF, after one or two additions
STIFF_SOLREF, STIFF_SOLIMP = (0.002, 1.0), (0.9999, 0.9999, 0.001, 0.5, 2.0)
PLACES = ((0.0, 0.0, 0.0), (0.5, 0.3, 1.2), (-0.4, 0.6, -2.5))


@pytest.fixture(scope="module")
def robot() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(ROBOT))


@pytest.fixture(scope="module")
def data(robot: mujoco.MjModel) -> mujoco.MjData:
    data = mujoco.MjData(robot)
    mujoco.mj_forward(robot, data)
    return data


@pytest.fixture
def mjcf(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.setenv("MUJOCO_GL", "disable")  # dm_control would otherwise look for a display on import
    from dm_control import mjcf

    return mjcf


@pytest.fixture
def trio(mjcf: ModuleType) -> mujoco.MjModel:
    """Three robots attached to the arena, with a contact stiff enough to call the floor rigid."""
    arena = mjcf.from_path(str(ARENA))
    for index, (x, y, theta) in enumerate(PLACES):
        robot = mjcf.from_path(str(ROBOT))
        robot.model = f"r{index}"
        robot.find("joint", "root").remove()  # MuJoCo wants a free joint on a top-level body: the frame
        for name in ("left_tyre", "right_tyre", "caster"):
            robot.find("geom", name).solref, robot.find("geom", name).solimp = STIFF_SOLREF, STIFF_SOLIMP
        frame = arena.attach(robot)
        frame.pos, frame.euler = (x, y, 0.03), (0, 0, theta)
        frame.add("freejoint", name="root")
    return mujoco.MjModel.from_xml_string(arena.to_xml_string(), arena.get_assets())


def support_loads(robot: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    """Loads [N] on left tyre, right tyre, caster: three points carry a weight at the centre of mass."""
    points = np.array([data.geom(name).xpos for name in ("left_tyre", "right_tyre", "caster")])
    weight = GRAVITY * robot.body_subtreemass[robot.body("chassis").id]
    com = data.subtree_com[robot.body("chassis").id]
    balance = np.vstack([np.ones(3), points[:, 0], points[:, 1]])
    return np.linalg.solve(balance, weight * np.array([1.0, com[0], com[1]]))


# structure ------------------------------------------------------------------------------------------------


def test_one_free_chassis_stands_on_two_hinged_wheels(robot: mujoco.MjModel) -> None:
    bodies = [robot.body(index).name for index in range(robot.nbody)]
    assert bodies == ["world", "chassis", "left_wheel", "right_wheel"]
    assert robot.joint("root").type == mujoco.mjtJoint.mjJNT_FREE
    assert robot.nv == 8
    for side in ("left", "right"):
        joint = robot.joint(f"{side}_wheel")
        assert joint.type == mujoco.mjtJoint.mjJNT_HINGE
        assert robot.body(f"{side}_wheel").parentid == robot.body("chassis").id
        np.testing.assert_array_equal(joint.axis, [0, 1, 0])
        np.testing.assert_array_equal(joint.pos, [0, 0, 0])
        assert joint.stiffness == joint.damping[0] == joint.frictionloss[0] == joint.armature[0] == 0
        assert not joint.limited


def test_the_origin_is_the_axle_midpoint(robot: mujoco.MjModel) -> None:
    left, right = robot.body("left_wheel").pos, robot.body("right_wheel").pos
    np.testing.assert_array_equal(left + right, [0, 0, 0])
    assert left[1] > 0
    assert left[0] == left[2] == 0


def test_wheels_and_caster_touch_one_floor(robot: mujoco.MjModel, data: mujoco.MjData) -> None:
    lowest = {
        name: data.geom(name).xpos[2] - robot.geom(name).size[-1 if "tyre" in name else 0]
        for name in ("left_tyre", "right_tyre", "caster")
    }
    wheel_radius = robot.geom("left_tyre").size[0]
    assert wheel_radius == 0.03
    for name, height in lowest.items():
        assert height == pytest.approx(-wheel_radius, abs=GEOMETRY), name


def test_tyres_are_round_and_resist_sliding_in_one_point(robot: mujoco.MjModel) -> None:
    for side in ("left", "right"):
        tyre = robot.geom(f"{side}_tyre")
        assert tyre.type == mujoco.mjtGeom.mjGEOM_ELLIPSOID
        assert tyre.size[0] == tyre.size[2] > 5 * tyre.size[1]
        assert (tyre.condim, tyre.priority, tyre.friction[0]) == (3, 1, 1.0)
        np.testing.assert_array_equal(tyre.pos, [0, 0, 0])


def test_the_caster_is_a_frictionless_ball(robot: mujoco.MjModel) -> None:
    caster = robot.geom("caster")
    assert caster.type == mujoco.mjtGeom.mjGEOM_SPHERE
    assert (caster.condim, caster.priority) == (1, 1)
    assert robot.body(caster.bodyid[0]).name == "chassis"
    assert caster.pos[1] == 0


def test_the_hull_clears_the_floor_and_encloses_the_tyres(robot: mujoco.MjModel) -> None:
    hull, tyre = robot.geom("hull"), robot.geom("left_tyre")
    radius, half_height = hull.size[:2]
    assert hull.pos[2] - half_height > -0.03 + 0.005
    angle = np.linspace(0, 2 * np.pi, 3601)
    outline = np.hypot(tyre.size[0] * np.cos(angle), 0.05 + tyre.size[1] * np.sin(angle))
    assert outline.max() < radius


def test_only_named_primitives_collide(robot: mujoco.MjModel) -> None:
    colliding = {
        robot.geom(i).name for i in range(robot.ngeom) if robot.geom_contype[i] or robot.geom_conaffinity[i]
    }
    assert colliding == {"left_tyre", "right_tyre", "caster", "hull"}
    for index in range(robot.ngeom):
        geom = robot.geom(index)
        assert geom.name
        assert geom.group == (3 if geom.name in colliding else 2), geom.name


def test_the_robot_is_its_own_mirror_image(robot: mujoco.MjModel, data: mujoco.MjData) -> None:
    def shape(index: int, sign: float) -> tuple[object, ...]:
        x, y, z = data.geom_xpos[index]
        size = robot.geom_size[index].tolist()
        numbers = np.round([x, sign * y, z, *size], 9) + 0.0  # + 0.0 turns -0.0 into 0.0
        return (robot.geom_type[index], robot.geom_matid[index], *numbers)

    everything = range(robot.ngeom)
    assert sorted(shape(i, 1.0) for i in everything) == sorted(shape(i, -1.0) for i in everything)
    mass_matrix = np.zeros((robot.nv, robot.nv))
    mujoco.mj_fullM(robot, data, mass_matrix)
    mirror = np.diag([1, -1, 1, -1, 1, -1, 0, 0])
    mirror[6, 7] = mirror[7, 6] = 1
    np.testing.assert_allclose(mirror @ mass_matrix @ mirror, mass_matrix, rtol=0, atol=1e-15)


def test_a_robot_can_be_recoloured_and_looked_at(robot: mujoco.MjModel) -> None:
    assert np.sum(robot.geom_matid == robot.material("accent").id) >= 5
    assert {robot.camera(i).name for i in range(robot.ncam)} == {"chase", "onboard"}


# mass, statics, motors -------------------------------------------------------------------------------------


def readme_table(heading: str) -> list[list[str]]:
    """Cells of the rows of the first table under a heading of the robot's README, without its head."""
    section = (MODELS / "nh_mini" / "README.md").read_text().split(f"## {heading}\n")[1]
    rows = re.findall(r"^\|(.+)\|$", section.split("\n## ")[0], flags=re.MULTILINE)
    return [[cell.strip() for cell in row.split("|")] for row in rows[2:]]


def test_the_mass_budget_in_the_readme_gives_the_inertia_in_the_mjcf(robot: mujoco.MjModel) -> None:
    rows = readme_table("Mass budget of the chassis")
    mass = 1e-3 * np.array([float(row[1]) for row in rows])
    at, size = (1e-3 * np.array([[float(v) for v in row[c].split(",")] for row in rows]) for c in (2, 3))
    chassis = robot.body("chassis")
    assert chassis.mass[0] == pytest.approx(mass.sum(), rel=1e-9)
    com = mass @ at / mass.sum()
    np.testing.assert_allclose(chassis.ipos, com, rtol=0, atol=1e-9)
    inertia = np.zeros((3, 3))
    for m, p, s in zip(mass, at - com, size, strict=True):  # boxes, and Steiner
        inertia += m / 12 * (s @ s * np.eye(3) - np.diag(s**2)) + m * (p @ p * np.eye(3) - np.outer(p, p))
    axes = np.zeros(9)
    mujoco.mju_quat2Mat(axes, chassis.iquat)
    axes = axes.reshape(3, 3)
    np.testing.assert_allclose(axes @ np.diag(chassis.inertia) @ axes.T, inertia, rtol=0, atol=1e-12)


def test_a_wheel_is_a_solid_disc(robot: mujoco.MjModel) -> None:
    mass, radius, width = 0.01134, 0.03, 0.008
    disc = [mass * (3 * radius**2 + width**2) / 12, mass * radius**2 / 2]
    for side in ("left", "right"):
        wheel = robot.body(f"{side}_wheel")
        assert wheel.mass[0] == pytest.approx(mass, rel=1e-12)
        np.testing.assert_allclose(wheel.inertia, [disc[0], disc[1], disc[0]], rtol=1e-12)
        np.testing.assert_array_equal(wheel.iquat, [1, 0, 0, 0])


def test_the_weight_rests_on_three_points(robot: mujoco.MjModel, data: mujoco.MjData) -> None:
    loads = support_loads(robot, data)
    weight = GRAVITY * robot.body_mass.sum()
    assert robot.body_mass.sum() == pytest.approx(0.70118, rel=1e-9)
    assert (loads > 0).all()
    assert loads[0] == pytest.approx(loads[1], rel=1e-12)
    assert loads.sum() == pytest.approx(weight, rel=1e-12)
    assert 0.10 < loads[2] / weight < 0.25


def test_the_motors_are_the_gearmotor_of_the_readme(robot: mujoco.MjModel) -> None:
    stall = robot.numeric("motor_stall_torque").data[0]
    no_load = robot.numeric("motor_no_load_speed").data[0]
    assert stall == pytest.approx(0.01 * 9.80665, rel=1e-12)  # 1.0 kgf cm
    assert no_load == pytest.approx(450 * 2 * np.pi / 60, rel=1e-12)
    for index, side in enumerate(("left", "right")):
        motor = robot.actuator(f"{side}_motor")
        assert motor.id == index
        assert motor.trnid[0] == robot.joint(f"{side}_wheel").id
        assert (motor.gear[0], motor.gainprm[0], motor.biastype) == (1.0, 1.0, 0)
        assert motor.ctrllimited
        np.testing.assert_allclose(motor.ctrlrange, [-0.4 * stall, 0.4 * stall], rtol=1e-12)


def test_the_motors_can_drive_but_not_lift_the_caster(robot: mujoco.MjModel, data: mujoco.MjData) -> None:
    radius, mass, spin = 0.03, robot.body_mass.sum(), robot.body("left_wheel").inertia[1]
    torque = robot.actuator("left_motor").ctrlrange[1]
    no_load = robot.numeric("motor_no_load_speed").data[0]
    stall = robot.numeric("motor_stall_torque").data[0]
    fastest_at_full_torque = radius * no_load * (1 - torque / stall)
    acceleration = 2 * torque / radius / (mass + 2 * spin / radius**2)
    com = data.subtree_com[robot.body("chassis").id]
    lift_off = GRAVITY * -com[0] / ((com[2] + radius) * (1 + 2 * spin / (mass * radius**2)))
    assert fastest_at_full_torque > 0.8
    assert 3.0 < acceleration < lift_off


def test_a_sideways_push_slides_the_robot_before_it_tips(robot: mujoco.MjModel, data: mujoco.MjData) -> None:
    com = data.subtree_com[robot.body("chassis").id]
    caster = data.geom("caster").xpos[0]
    # The tipping axis runs from a tyre to the caster; its distance from the centre of mass, seen from above.
    normal = np.array([0.05, -caster]) / np.hypot(0.05, caster)
    arm = normal @ (np.array([0.0, 0.05]) - com[:2])
    assert arm / (com[2] + 0.03) > 1.0  # steeper than the friction cone of friction 1


# the arena --------------------------------------------------------------------------------------------------


def test_the_arena_compiles_alone() -> None:
    arena = mujoco.MjModel.from_xml_path(str(ARENA))
    floor = arena.geom("floor")
    assert floor.type == mujoco.mjtGeom.mjGEOM_PLANE
    np.testing.assert_array_equal(floor.size[:2], [0, 0])  # endless
    assert floor.pos[2] == 0
    assert arena.material("floor").reflectance == 0
    key = arena.light("key")
    assert key.type == mujoco.mjtLightType.mjLIGHT_SPOT
    assert key.castshadow
    assert arena.vis.global_.offwidth >= 1920
    assert arena.vis.global_.offheight >= 1080


def test_three_robots_attach_and_keep_the_robots_options(trio: mujoco.MjModel, robot: mujoco.MjModel) -> None:
    assert (trio.nv, trio.nu) == (24, 6)
    for name in ("r0", "r1", "r2"):
        assert trio.joint(f"{name}/root/").type == mujoco.mjtJoint.mjJNT_FREE
        assert trio.actuator(f"{name}/left_motor").trnid[0] == trio.joint(f"{name}/left_wheel").id
        assert trio.body(f"{name}/").subtreemass[0] == pytest.approx(robot.body_mass.sum(), rel=1e-12)
    for option in ("timestep", "integrator", "cone", "solver", "impratio", "tolerance"):
        assert getattr(trio.opt, option) == getattr(robot.opt, option), option
    assert trio.stat.extent == 1.0  # clipping planes stay in metres


@pytest.mark.slow
def test_robots_at_rest_stay_at_rest(
    trio: mujoco.MjModel, robot: mujoco.MjModel, data: mujoco.MjData
) -> None:
    state = mujoco.MjData(trio)
    # One nanometre into the floor: at exactly zero distance rounding decides which of the three contacts is
    # active in the first step, and the robot would fall and tilt for a millisecond.
    state.qpos[2::9] -= 1e-9
    start = state.qpos.copy()
    mujoco.mj_step(trio, state, nstep=500)
    settled = state.qpos.copy()
    mujoco.mj_step(trio, state, nstep=500)
    moved = np.abs(settled - start).reshape(3, 9)
    assert moved[:, :3].max() < 1e-8  # [m] contacts compressed by the weight; 3.5e-9 expected of solimp .9999
    assert moved[:, 3:7].max() < 1e-7  # quaternion: the caster, less loaded, is compressed less
    assert np.abs(state.qpos - settled).max() < 1e-12  # and then nothing creeps
    loads = {"left_tyre": 0.0, "right_tyre": 0.0, "caster": 0.0}
    force = np.zeros(6)
    for index, contact in enumerate(state.contact):
        mujoco.mj_contactForce(trio, state, index, force)
        loads[trio.geom(max(contact.geom)).name.split("/")[1]] += force[0] / 3
    np.testing.assert_allclose(list(loads.values()), support_loads(robot, data), rtol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(("share", "lifts"), [(1.0, False), (1.05, False), (1.15, True)])
def test_full_braking_leaves_the_caster_on_the_floor(trio: mujoco.MjModel, share: float, lifts: bool) -> None:
    """The caster lifts at 4.00 / 3.67 = 1.09 of the torque limit, and not before."""
    state = mujoco.MjData(trio)
    state.qpos[2::9] -= 1e-9
    for name in ("r0", "r1", "r2"):
        for side in ("left", "right"):
            limit = trio.actuator(f"{name}/{side}_motor").ctrlrange[1]
            state.joint(f"{name}/{side}_wheel").qfrc_applied = -share * limit  # past the motor's own limit
    mujoco.mj_step(trio, state, nstep=50)
    casters = {trio.geom(f"{name}/caster").id for name in ("r0", "r1", "r2")}
    on_floor = [contact for contact in state.contact if casters & set(contact.geom)]
    assert len(on_floor) == (0 if lifts else 3)


def test_the_models_travel_with_the_package() -> None:
    project = tomllib.loads((MODELS.parent / "pyproject.toml").read_text())
    assert "models" in project["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]
