"""Composing a scene: robots, names, contacts from the time step, masks, markers, errors, identity."""

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from nhtrack import assets
from nhtrack.errors import RobotError
from nhtrack.simulation.scene import Scene, SceneSpec, load_robot, make_scene, robot_path
from tolerances import HAND, READING

TRIO = SceneSpec(("leader", "f1", "f2"))


@pytest.fixture(scope="module")
def trio() -> Scene:
    return make_scene(TRIO)


def tyres(scene: Scene) -> list[int]:
    return [int(geom) for geom in scene.addresses.tyres.ravel()]


class TestSpec:
    @pytest.mark.parametrize(
        "spec",
        [
            TRIO,
            SceneSpec(
                ("a",), "some/robot.xml", 0.0005, 0.1, "default", False, True, False, (0.0, 1.0, -2.5, 3.0)
            ),
        ],
    )
    def test_json_round_trip(self, spec: SceneSpec) -> None:
        again = SceneSpec.from_json(spec.to_json())
        assert again == spec
        assert hash(again) == hash(spec)  # tuples again, not lists
        assert "\n" not in spec.to_json()

    def test_a_virtual_root_has_no_body(self) -> None:
        assert TRIO.bodies == ("leader", "f1", "f2")
        assert replace(TRIO, virtual_root=True).bodies == ("f1", "f2")


class TestRobots:
    @pytest.mark.parametrize("n", [1, 2, 5, 9])
    def test_n_robots_are_n_robots(self, n: int) -> None:
        scene = make_scene(SceneSpec(tuple(f"r{i}" for i in range(n))))
        assert (scene.model.nq, scene.model.nv, scene.model.nu) == (9 * n, 8 * n, 2 * n)
        mass = sum(scene.model.body_mass)
        assert mass == pytest.approx(n * scene.drive.mass, rel=n * HAND)

    def test_names_are_prefixes(self, trio: Scene) -> None:
        for name in TRIO.robots:
            assert trio.model.body(f"{name}/chassis").id > 0
            assert trio.model.actuator(f"{name}/left_motor").id >= 0

    def test_addresses_lead_to_the_parts_left_then_right(self, trio: Scene) -> None:
        at, model = trio.addresses, trio.model
        for i, name in enumerate(TRIO.robots):
            assert at.root_qpos[i] == model.joint(f"{name}/root/").qposadr[0]
            assert at.root_qvel[i] == model.joint(f"{name}/root/").dofadr[0]
            for j, side in enumerate(("left", "right")):
                assert at.wheel_qpos[i, j] == model.joint(f"{name}/{side}_wheel").qposadr[0]
                assert at.wheel_qvel[i, j] == model.joint(f"{name}/{side}_wheel").dofadr[0]
                assert at.motors[i, j] == model.actuator(f"{name}/{side}_motor").id
                assert at.tyres[i, j] == model.geom(f"{name}/{side}_tyre").id
                assert at.forces[i, j, 0] == model.sensor(f"{name}/{side}_tyre").adr[0]

    def test_robots_stand_where_they_are_put(self, trio: Scene) -> None:
        pose = np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0], [-1.0, 0.5, -9.0]])
        data = mujoco.MjData(trio.model)
        data.qpos = trio.qpos_of(pose, np.full((3, 2), 0.3))
        mujoco.mj_forward(trio.model, data)
        for (x, y, theta), name in zip(pose, TRIO.robots, strict=True):
            body = data.body(f"{name}/chassis")
            np.testing.assert_allclose(body.xpos[:2], (x, y), atol=HAND)
            np.testing.assert_allclose(body.xmat[[0, 3, 8]], (np.cos(theta), np.sin(theta), 1), atol=HAND)
        assert data.ncon == 9  # two tyres and a caster each, on the floor

    def test_a_rolling_robot_does_not_slide_at_its_contacts(self, trio: Scene) -> None:
        pose = np.array([[0.0, 0.0, 0.4], [1.0, 2.0, 3.0], [-1.0, 0.5, -9.0]])
        twist = np.array([[0.3, 0.0, 2.0], [-0.2, 0.0, 1.0], [0.0, 0.0, -3.0]])
        data = mujoco.MjData(trio.model)
        data.qpos, data.qvel = trio.qpos_of(pose, np.zeros((3, 2))), trio.qvel_of(pose, twist)
        mujoco.mj_forward(trio.model, data)
        velocity = np.empty(6)
        for geom in tyres(trio):
            mujoco.mj_objectVelocity(trio.model, data, mujoco.mjtObj.mjOBJ_GEOM, geom, velocity, 0)
            below = velocity[3:] + np.cross(velocity[:3], (0, 0, -trio.drive.wheel_radius))
            np.testing.assert_allclose(below, 0, atol=HAND)

    def test_colours_tell_robots_apart(self, trio: Scene) -> None:
        colours = {tuple(trio.model.material(f"{name}/accent").rgba) for name in TRIO.robots}
        assert len(colours) == 3

    def test_every_bundled_robot_composes(self) -> None:
        for robot in assets.robots():
            make_scene(SceneSpec(("a", "b"), robot))


class TestContact:
    @pytest.mark.parametrize("timestep", [0.0005, 0.001, 0.004])
    def test_stiff_contacts_follow_the_time_step(self, timestep: float) -> None:
        scene = make_scene(SceneSpec(("a", "b"), timestep=timestep, friction=0.3))
        model = scene.model
        assert model.opt.timestep == timestep
        for geom in tyres(scene) + [model.geom(f"{name}/caster").id for name in ("a", "b")]:
            np.testing.assert_allclose(model.geom_solref[geom], (2 * timestep, 1), rtol=HAND)
            assert model.geom_solimp[geom, 0] == model.geom_solimp[geom, 1] == 0.9999
        assert {float(model.geom_friction[geom, 0]) for geom in tyres(scene)} == {0.3}
        assert {int(model.geom_condim[geom]) for geom in tyres(scene)} == {3}

    def test_default_contacts_are_mujocos_own(self) -> None:
        scene = make_scene(SceneSpec(("a",), contact="default"))
        np.testing.assert_allclose(scene.model.geom_solref[tyres(scene)], [(0.02, 1)] * 2, rtol=HAND)

    def test_the_scenario_s_friction_holds_and_the_caster_does_not_drag(self, trio: Scene) -> None:
        data = mujoco.MjData(trio.model)
        data.qpos = trio.qpos_of(np.zeros((3, 3)) + np.arange(3)[:, None], np.zeros((3, 2)))
        mujoco.mj_forward(trio.model, data)
        found = {int(contact.geom[1]): contact for contact in data.contact}
        assert {found[geom].friction[0] for geom in tyres(trio)} == {1.0}
        assert {found[geom].dim for geom in tyres(trio)} == {3}
        assert {found[trio.model.geom(f"{name}/caster").id].dim for name in TRIO.robots} == {1}

    @pytest.mark.parametrize(("robot_contact", "touches"), [(False, False), (True, True)])
    def test_robots_touch_each_other_only_when_asked(self, robot_contact: bool, touches: bool) -> None:
        scene = make_scene(SceneSpec(("a", "b"), robot_contact=robot_contact))
        data = mujoco.MjData(scene.model)
        data.qpos = scene.qpos_of(np.array([[0.0, 0.0, 0.0], [0.05, 0.02, 1.0]]), np.zeros((2, 2)))
        mujoco.mj_forward(scene.model, data)
        robots = scene.model.body_rootid[scene.model.geom_bodyid]
        floor = scene.model.geom("floor").id
        between = [c for c in data.contact if floor not in c.geom]
        assert all(robots[c.geom[0]] != robots[c.geom[1]] for c in between)
        assert bool(between) == touches
        assert sum(floor in c.geom for c in data.contact) == 6  # both stand on the floor either way

    def test_a_robot_does_not_touch_itself(self) -> None:
        scene = make_scene(SceneSpec(("a",), robot_contact=True))
        data = mujoco.MjData(scene.model)
        data.qpos = scene.qpos_of(np.zeros((1, 3)), np.zeros((1, 2)))
        mujoco.mj_forward(scene.model, data)
        assert data.ncon == 3


class TestVirtualRoot:
    def test_the_root_is_a_marker_without_joints_or_contact(self) -> None:
        scene = make_scene(replace(TRIO, virtual_root=True))
        assert scene.marker == 0
        assert scene.model.nu == 4
        assert scene.addresses.motors.shape == (2, 2)
        body = scene.model.body("leader")
        geoms = np.flatnonzero(scene.model.geom_bodyid == body.id)
        assert len(geoms) > 0
        assert not scene.model.geom_contype[geoms].any()
        assert not scene.model.geom_conaffinity[geoms].any()

    def test_a_real_root_has_no_marker(self, trio: Scene) -> None:
        assert trio.marker is None
        assert trio.model.nmocap == 0

    def test_followers_keep_their_colours(self, trio: Scene) -> None:
        scene = make_scene(replace(TRIO, virtual_root=True))
        for name in ("f1", "f2"):
            accent = f"{name}/accent"
            np.testing.assert_array_equal(scene.model.material(accent).rgba, trio.model.material(accent).rgba)


class TestIdentity:
    def test_the_hash_is_the_scene_s(self, trio: Scene) -> None:
        assert make_scene(TRIO).hash == trio.hash
        assert len(trio.hash) == 64

    @pytest.mark.parametrize(
        "change",
        [
            {"timestep": 0.002},
            {"friction": 0.9},
            {"contact": "default"},
            {"robot_contact": True},
            {"virtual_root": True},
            {"bounds": (-2.0, 2.0, -2.0, 2.0)},
            {"robots": ("leader", "f1")},
        ],
        ids=str,
    )
    def test_whatever_changes_the_scene_changes_the_hash(self, trio: Scene, change: dict) -> None:
        assert make_scene(replace(TRIO, **change)).hash != trio.hash


@pytest.fixture
def own_robot(tmp_path: Path) -> Path:
    """A user's copy of nh_mini: other compiler settings, other options, placed elsewhere."""
    text = assets.find_robot("nh_mini").read_text()
    for old, new in (
        ('<compiler angle="radian" autolimits="false"/>', '<compiler angle="radian" autolimits="true"/>'),
        ('ctrllimited="true" ', ""),
        ('timestep="0.001"', 'timestep="0.0023" gravity="0 0 -1.62"'),
        ('<body name="chassis">', '<body name="chassis" pos="1 2 3">'),
    ):
        assert old in text
        text = text.replace(old, new)
    path = tmp_path / "my_robot.xml"
    path.write_text(text)
    return path


class TestOwnRobot:
    def test_the_scene_decides_the_options(self, own_robot: Path) -> None:
        scene = make_scene(SceneSpec(("a", "b"), str(own_robot), timestep=0.0005))
        assert scene.model.opt.timestep == 0.0005
        assert scene.model.opt.gravity[2] == pytest.approx(-9.81, rel=HAND)

    def test_the_robot_decides_how_it_is_read(self, own_robot: Path) -> None:
        scene = make_scene(SceneSpec(("a",), str(own_robot)))
        assert scene.model.actuator_ctrllimited.all()  # autolimits

    def test_it_is_the_same_robot(self, own_robot: Path) -> None:
        theirs = make_scene(SceneSpec(("a",), str(own_robot))).drive
        ours = make_scene(SceneSpec(("a",))).drive
        assert theirs.mass == pytest.approx(ours.mass, rel=HAND)
        assert theirs.com == pytest.approx(ours.com, abs=READING)
        assert theirs.axle_inertia == pytest.approx(ours.axle_inertia, abs=READING)

    def test_it_stands_on_the_floor(self, own_robot: Path) -> None:
        scene = make_scene(SceneSpec(("a",), str(own_robot)))
        data = mujoco.MjData(scene.model)
        data.qpos = scene.qpos_of(np.zeros((1, 3)), np.zeros((1, 2)))
        mujoco.mj_forward(scene.model, data)
        np.testing.assert_allclose(data.body("a/chassis").xpos[:2], 0, atol=READING)
        assert data.ncon == 3


class TestErrors:
    def test_an_unknown_robot(self) -> None:
        with pytest.raises(
            RobotError, match=r"no robot 'nh_mimi'; did you mean 'nh_mini'\? available: .*nh_mini"
        ):
            make_scene(SceneSpec(("a",), "nh_mimi"))

    def test_an_mjcf_that_is_not_there(self, tmp_path: Path) -> None:
        path = tmp_path / "absent.xml"
        with pytest.raises(RobotError, match=r"absent\.xml: no such MJCF file"):
            robot_path(str(path))

    @pytest.mark.parametrize(
        "text", ["", "not xml", "<mujoco><worldbody><body/></mujoco>", "<mujoco><wheel/></mujoco>"]
    )
    def test_an_mjcf_that_mujoco_cannot_read(self, tmp_path: Path, text: str) -> None:
        path = tmp_path / "broken.xml"
        path.write_text(text)
        with pytest.raises(RobotError, match=r"broken\.xml: MuJoCo cannot compile it: "):
            load_robot(str(path))

    def test_an_mjcf_that_is_no_robot(self, tmp_path: Path) -> None:
        path = tmp_path / "ball.xml"
        path.write_text('<mujoco><worldbody><geom size="1"/></worldbody></mujoco>')
        with pytest.raises(RobotError, match="expected one body with a free joint"):
            make_scene(SceneSpec(("a",), str(path)))
