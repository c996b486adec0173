"""Composing a scene: robots, names, contacts from the time step, masks, markers, ground, loads, errors, identity."""

import json
import math
from dataclasses import fields, replace
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from nhtrack import assets
from nhtrack.effects import Effect, effect_kinds
from nhtrack.effects.motors import Motors
from nhtrack.effects.patches import Patches
from nhtrack.effects.payload import Payload
from nhtrack.effects.planar_base import PlanarBase
from nhtrack.effects.slope import Slope
from nhtrack.effects.wheel_mismatch import WheelMismatch
from nhtrack.errors import RecordingError, RobotError
from nhtrack.ground import Patch
from nhtrack.robots.contract import Hints
from nhtrack.simulation.robot_models import load_robot, read_robot
from nhtrack.simulation.scene import Scene, SceneSpec, make_scene, unit_spec
from tolerances import HAND, READING

TRIO = SceneSpec(("leader", "f1", "f2"))
ONE = SceneSpec(("robot",))
PLACES = ((0.0, 0.0, 0.0), (1.0, 2.0, 3.0), (-1.0, 0.5, -9.0))
# How far robots are placed into the floor [m].
TOUCH = 1e-9
# No field is at its default.
EVERYTHING = SceneSpec(
    ("a",),
    "some/robot.xml",
    0.0005,
    0.1,
    "default",
    False,
    True,
    True,
    (0.0, 1.0, -2.5, 3.0),
    effects=(
        PlanarBase(),
        Patches((Patch(0.05, rectangle=(0.0, 1.0, -1.0, 2.0)), Patch(0.4, disc=(0.5, 0.5, 0.2)))),
        Slope(0.1, -2.0),
        Payload(0.3, (0.01, -0.02, 0.07), (0.04, 0.05, 0.02)),
        WheelMismatch(0.01),
        Motors(0.02, 30.0),
    ),
    compensation="actual",
    colours=(4,),
    hints=Hints(("a", "b"), ("c",), "-x", "home"),
)


made = cache(make_scene)


def under(spec: SceneSpec, *effects: Effect, **changes: Any) -> SceneSpec:
    """Returns a spec with effects, and with other changes."""
    return replace(spec, effects=effects, **changes)


@pytest.fixture(scope="module")
def trio() -> Scene:
    return made(TRIO)


def standing(scene: Scene, *pose: tuple[float, float, float], angle: float = 0.0) -> mujoco.MjData:
    """Returns the state of robots put somewhere, contacts and all."""
    data = mujoco.MjData(scene.model)
    data.qpos = scene.qpos_of(np.array(pose), np.full((len(pose), 2), angle))
    mujoco.mj_forward(scene.model, data)
    return data


def tyres(scene: Scene) -> list[int]:
    return [int(geom) for geom in scene.addresses.tyres.ravel()]


class TestSpec:
    @pytest.mark.parametrize("spec", [TRIO, EVERYTHING], ids=["defaults", "everything"])
    def test_json_round_trip(self, spec: SceneSpec) -> None:
        again = SceneSpec.from_json(spec.to_json())
        assert again == spec
        assert hash(again) == hash(spec)  # tuples again, not lists
        assert "\n" not in spec.to_json()

    def test_everything_is_tried(self) -> None:
        assert {type(effect) for effect in EVERYTHING.effects} == set(effect_kinds().values())
        for each in fields(SceneSpec):
            assert getattr(EVERYTHING, each.name) != getattr(TRIO, each.name), each.name

    def test_one_kept_before_a_field_came_takes_its_default(self) -> None:
        """Recordings outlive the fields they know; a spec of version 0.1.0."""
        old = (
            '{"robots": ["leader", "f1", "f2"], "robot": "nh_mini", "timestep": 0.001, "friction": 1.0, '
            '"contact": "stiff", "rate_correction": true, "robot_contact": false, "virtual_root": false, '
            '"bounds": [-1.0, 1.0, -1.0, 1.0]}'
        )
        assert SceneSpec.from_json(old) == TRIO
        kept = json.loads(EVERYTHING.to_json())
        del kept["effects"]["motors"]["torque_limit"]
        del kept["colours"]
        others = EVERYTHING.effects[:-1]
        assert SceneSpec.from_json(json.dumps(kept)) == under(EVERYTHING, *others, Motors(None, 30.0), colours=())

    def test_an_effect_that_is_not_known_is_told(self) -> None:
        text = TRIO.to_json().replace('"effects": {}', '"effects": {"wind": {}}')
        with pytest.raises(RecordingError, match="made under the physical effect 'wind', which this version lacks; "):
            SceneSpec.from_json(text)

    def test_a_virtual_root_has_no_body(self) -> None:
        assert TRIO.bodies == ("leader", "f1", "f2")
        assert replace(TRIO, virtual_root=True).bodies == ("f1", "f2")


class TestRobots:
    @pytest.mark.parametrize("n", [1, 5])
    def test_n_robots_are_n_robots(self, n: int) -> None:
        scene = made(SceneSpec(tuple(f"r{i}" for i in range(n))))
        assert (scene.model.nq, scene.model.nv, scene.model.nu) == (9 * n, 8 * n, 2 * n)
        mass = sum(scene.model.body_mass)
        assert mass == pytest.approx(n * scene.drive.mass, rel=n * HAND)

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

    def test_robots_stand_where_they_are_put(self, trio: Scene) -> None:
        data = standing(trio, *PLACES, angle=0.3)
        for (x, y, theta), name in zip(PLACES, TRIO.robots, strict=True):
            body = data.body(f"{name}/chassis")
            np.testing.assert_allclose(body.xpos[:2], (x, y), atol=HAND)
            np.testing.assert_allclose(body.xmat[[0, 3, 8]], (np.cos(theta), np.sin(theta), 1), atol=HAND)
        assert data.ncon == 9  # two tyres and a caster each, on the floor

    @pytest.mark.parametrize("base", [(), (PlanarBase(),)], ids=["free", "planar"])
    def test_a_rolling_robot_does_not_slide_at_its_contacts(self, base: tuple[Effect, ...]) -> None:
        scene = made(under(TRIO, *base))
        pose = np.array([[0.0, 0.0, 0.4], [1.0, 2.0, 3.0], [-1.0, 0.5, -9.0]])
        twist = np.array([[0.3, 0.0, 2.0], [-0.2, 0.0, 1.0], [0.0, 0.0, -3.0]])
        data = mujoco.MjData(scene.model)
        data.qpos, data.qvel = scene.qpos_of(pose, np.zeros((3, 2))), scene.qvel_of(pose, twist)
        mujoco.mj_forward(scene.model, data)
        velocity = np.empty(6)
        for geom in tyres(scene):
            mujoco.mj_objectVelocity(scene.model, data, mujoco.mjtObj.mjOBJ_GEOM, geom, velocity, 0)
            below = velocity[3:] + np.cross(velocity[:3], (0, 0, -scene.drive.wheel_radius))
            np.testing.assert_allclose(below, 0, atol=HAND)


class TestContact:
    @pytest.mark.parametrize("timestep", [0.0005, 0.004])
    def test_stiff_contacts_follow_the_time_step(self, timestep: float) -> None:
        scene = made(SceneSpec(("a", "b"), timestep=timestep, friction=0.3))
        model = scene.model
        assert model.opt.timestep == timestep
        for geom in tyres(scene) + [model.geom(f"{name}/caster").id for name in ("a", "b")]:
            np.testing.assert_allclose(model.geom_solref[geom], (2 * timestep, 1), rtol=HAND)
            assert model.geom_solimp[geom, 0] == model.geom_solimp[geom, 1] == 0.9999
        assert {float(model.geom_friction[geom, 0]) for geom in tyres(scene)} == {0.3}
        assert {int(model.geom_condim[geom]) for geom in tyres(scene)} == {3}

    def test_the_scenario_s_friction_holds_and_the_caster_does_not_drag(self, trio: Scene) -> None:
        data = standing(trio, *PLACES)
        found = {int(contact.geom[1]): contact for contact in data.contact}
        assert {found[geom].friction[0] for geom in tyres(trio)} == {1.0}
        assert {found[geom].dim for geom in tyres(trio)} == {3}
        assert {found[trio.model.geom(f"{name}/caster").id].dim for name in TRIO.robots} == {1}

    @pytest.mark.parametrize(("robot_contact", "base"), [(False, ()), (True, ()), (True, (PlanarBase(),))])
    def test_robots_touch_each_other_only_when_asked(self, robot_contact: bool, base: tuple[Effect, ...]) -> None:
        scene = made(SceneSpec(("a", "b"), robot_contact=robot_contact, effects=base))
        data = standing(scene, (0.0, 0.0, 0.0), (0.05, 0.02, 1.0))
        robots = scene.model.body_rootid[scene.model.geom_bodyid]
        floor = scene.model.geom("floor").id
        between = [c for c in data.contact if floor not in c.geom]
        assert all(robots[c.geom[0]] != robots[c.geom[1]] for c in between)  # and none itself
        assert bool(between) == robot_contact
        assert sum(floor in c.geom for c in data.contact) == (4 if base else 6)  # both stand either way


class TestVirtualRoot:
    def test_the_root_is_a_marker_without_joints_or_contact(self) -> None:
        scene = made(replace(TRIO, virtual_root=True))
        assert scene.marker == 0
        assert scene.model.nu == 4
        assert scene.addresses.motors.shape == (2, 2)
        body = scene.model.body("leader")
        geoms = np.flatnonzero(scene.model.geom_bodyid == body.id)
        assert len(geoms) > 0
        assert not scene.model.geom_contype[geoms].any()
        assert not scene.model.geom_conaffinity[geoms].any()


class TestGround:
    PATCHES = (
        Patch(0.05, rectangle=(0.5, 2.0, -1.0, 3.0)),
        Patch(1.5, disc=(-1.0, 0.5, 0.25)),
        Patch(0.05, rectangle=(0.0, 1.0, 0.0, 1.0)),
    )

    def test_patches_are_drawn_where_they_are_and_touch_nothing(self) -> None:
        model = made(under(ONE, Patches(self.PATCHES))).model
        box, disc, above = (model.geom(f"patch_{i}") for i in range(3))
        for drawn in (box, disc, above):
            assert not drawn.contype
            assert not drawn.conaffinity
            bottom, height = drawn.pos[2] - self.half_height(drawn), 2 * self.half_height(drawn)
            assert bottom == pytest.approx(0, abs=HAND)
            assert 0 < height < 0.002  # below the trails of a film
        np.testing.assert_allclose(box.pos[:2], (1.25, 1.0), atol=HAND)
        np.testing.assert_allclose(box.size[:2], (0.75, 2.0), atol=HAND)
        np.testing.assert_allclose(disc.pos[:2], (-1.0, 0.5), atol=HAND)
        assert disc.size[0] == pytest.approx(0.25, abs=HAND)
        assert box.type == mujoco.mjtGeom.mjGEOM_BOX
        assert disc.type == mujoco.mjtGeom.mjGEOM_CYLINDER
        # Where two overlap the last one counts, so it is the one to be seen.
        assert self.half_height(above) > self.half_height(box)

    @staticmethod
    def half_height(geom: object) -> float:
        return float(geom.size[1 if geom.type == mujoco.mjtGeom.mjGEOM_CYLINDER else 2])  # type: ignore[attr-defined]

    def test_gravity_leans_on_a_slope_and_the_floor_does_not(self) -> None:
        scene = made(under(ONE, Slope(0.3, math.pi / 2)))
        expected = (0, -9.81 * math.sin(0.3), -9.81 * math.cos(0.3))
        np.testing.assert_allclose(scene.model.opt.gravity, expected, atol=9.81 * HAND)
        np.testing.assert_array_equal(scene.model.geom("floor").quat, (1, 0, 0, 0))


class TestPayload:
    LOAD = Payload(0.3, (0.015, -0.02, 0.08), (0.04, 0.06, 0.02))

    def test_it_is_in_mass_centre_of_mass_and_inertia(self) -> None:
        bare = made(ONE).plant
        laden = made(under(ONE, self.LOAD)).plant
        x, y, _ = self.LOAD.position
        mass = bare.mass + 0.3
        assert laden.mass == pytest.approx(mass, rel=HAND)
        moments = bare.mass * np.array(bare.com) + 0.3 * np.array(self.LOAD.position)
        np.testing.assert_allclose(laden.com, moments / mass, atol=HAND)
        own = 0.3 * (0.04**2 + 0.06**2) / 12
        assert laden.axle_inertia == pytest.approx(bare.axle_inertia + own + 0.3 * (x * x + y * y), rel=HAND)
        assert laden.casters == bare.casters
        assert laden.wheel_inertia == pytest.approx(bare.wheel_inertia, rel=HAND)

    def test_it_is_in_every_robot_of_the_compiled_scene(self) -> None:
        scene = made(under(TRIO, self.LOAD))
        assert sum(scene.model.body_mass) == pytest.approx(3 * scene.plant.mass, rel=HAND)
        data = standing(scene, *(3 * PLACES[:1]))
        for name in TRIO.robots:
            np.testing.assert_allclose(data.body(f"{name}/payload").xpos, self.LOAD.position, atol=1.01 * TOUCH)
            np.testing.assert_allclose(data.body(f"{name}/chassis").subtree_com, scene.plant.com, atol=1.01 * TOUCH)

    def test_a_point_has_a_mass_and_no_size(self) -> None:
        point = replace(self.LOAD, size=(0.0, 0.0, 0.0))
        scene = made(under(ONE, point))
        np.testing.assert_array_equal(scene.model.body("robot/payload").inertia, 0)
        assert (scene.model.geom("robot/payload").size > 0).all()  # and can be seen

    def test_torques_are_for_it_only_where_it_is_known(self) -> None:
        bare = made(ONE).drive
        nominal = made(under(ONE, self.LOAD))
        actual = made(under(ONE, self.LOAD, compensation="actual"))
        assert nominal.drive == bare
        assert nominal.plant == actual.plant == actual.drive
        assert nominal.hash == actual.hash  # the same robots, driven otherwise


class TestMotors:
    def test_their_limits_are_the_scene_s(self) -> None:
        scene = made(under(TRIO, Motors(0.012, 20.0)))
        bare = made(TRIO)
        for drive in (scene.drive, scene.plant):
            assert (drive.motor.torque_limit, drive.motor.no_load_speed) == (0.012, 20.0)
            assert drive.motor.stall_torque == bare.drive.motor.stall_torque
        np.testing.assert_array_equal(scene.model.actuator_ctrlrange, [(-0.012, 0.012)] * 6)
        assert scene.model.actuator_ctrllimited.all()


class TestTyres:
    def test_one_is_larger_than_the_other_and_their_mean_is_the_robot_s(self) -> None:
        scene = made(under(ONE, WheelMismatch(0.02)))
        left, right = (scene.model.geom_size[geom] for geom in tyres(scene))
        alike = made(ONE).model.geom_size[tyres(scene)[0]]
        np.testing.assert_allclose(left, 1.01 * alike, rtol=HAND)
        np.testing.assert_allclose(right, 0.99 * alike, rtol=HAND)
        assert scene.drive == made(ONE).drive  # whoever computes the torques does not know

    @pytest.mark.parametrize("mismatch", [0.02, -0.1])
    @pytest.mark.parametrize("theta", [0.0, 2.0, -9.0])
    def test_such_a_robot_stands_on_both_of_them(self, mismatch: float, theta: float) -> None:
        scene = made(under(ONE, WheelMismatch(mismatch)))
        data = standing(scene, (1.0, 2.0, theta))
        depth = {int(contact.geom[1]): contact.dist for contact in data.contact}
        for geom in tyres(scene):
            assert depth[geom] == pytest.approx(-TOUCH, rel=0.01)
        matrix = data.body("robot/chassis").xmat.reshape(3, 3)
        assert math.atan2(matrix[1, 0], matrix[0, 0]) == pytest.approx(math.remainder(theta, 2 * math.pi), abs=HAND)
        assert matrix[2, 0] == pytest.approx(0, abs=HAND)  # it does not nod
        assert np.sign(matrix[2, 1]) == np.sign(mismatch)  # up on the side of the larger one

    def test_the_wheels_of_one_that_rolls_turn_at_speeds_of_their_own(self) -> None:
        scene = made(under(ONE, WheelMismatch(0.02)))
        qvel = scene.qvel_of(np.zeros((1, 3)), np.array([[0.3, 0.0, 0.0]]))
        np.testing.assert_allclose(qvel[scene.addresses.wheel_qvel[0]], (0.3 / 0.0303, 0.3 / 0.0297), rtol=HAND)


class TestPlanarBase:
    def test_three_slides_and_a_vertical_hinge(self) -> None:
        scene = made(under(TRIO, PlanarBase()))
        assert (scene.model.nq, scene.model.nv, scene.model.nu) == (18, 18, 6)
        slide, hinge = mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE
        at = scene.addresses
        for i, _ in enumerate(TRIO.robots):
            first = int(at.root_qpos[i])
            assert first == at.root_qvel[i] == 6 * i  # places and velocities alike
            np.testing.assert_array_equal(scene.model.jnt_type[first : first + 4], [slide, slide, slide, hinge])
            axes = scene.model.jnt_axis[first : first + 4]
            np.testing.assert_array_equal(axes, [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, 1)])

    def test_robots_stand_where_they_are_put_on_their_wheels_alone(self) -> None:
        scene = made(under(TRIO, PlanarBase()))
        data = standing(scene, *PLACES, angle=0.3)
        for (x, y, theta), name in zip(PLACES, TRIO.robots, strict=True):
            body = data.body(f"{name}/chassis")
            np.testing.assert_allclose(body.xpos, (x, y, scene.drive.wheel_radius), atol=1.01 * TOUCH)
            np.testing.assert_allclose(body.xmat[[0, 3, 8]], (np.cos(theta), np.sin(theta), 1), atol=HAND)
        assert {int(contact.geom[1]) for contact in data.contact} == set(tyres(scene))

    def test_its_reduced_model_knows(self) -> None:
        robot = read_robot(under(ONE, PlanarBase()))
        for model in (robot.drive, robot.plant):
            assert model.levelled
            turning = np.array([0.4]), np.array([2.0]), np.array([0.3]), np.array([5.0])
            half = model.mass * 9.81 / 2
            np.testing.assert_allclose(model.wheel_loads(*turning), [(half, half)], rtol=HAND)
            np.testing.assert_allclose(model.caster_load(*turning), 0, atol=half * HAND)


class TestIdentity:
    CHANGES = (
        {"timestep": 0.002},
        {"friction": 0.9},
        {"contact": "default"},
        {"robot_contact": True},
        {"virtual_root": True},
        {"bounds": (-2.0, 2.0, -2.0, 2.0)},
        {"robots": ("leader", "f1")},
        {"effects": (PlanarBase(),)},
        {"effects": (Patches((Patch(0.1, disc=(0.0, 0.0, 1.0)),)),)},
        {"effects": (Slope(0.1),)},
        {"effects": (Slope(0.1, 1.0),)},
        {"effects": (TestPayload.LOAD,)},
        {"effects": (WheelMismatch(0.01),)},
        {"effects": (Motors(0.01),)},
    )

    def test_the_hash_is_the_scene_s(self, trio: Scene) -> None:
        assert make_scene(TRIO).hash == trio.hash
        assert len(trio.hash) == 64

    def test_the_order_of_effects_does_not_matter(self) -> None:
        effects = (*EVERYTHING.effects[:-2], Motors(0.02, 30.0))  # a planar base has no place for unlike wheels
        assert made(under(TRIO, *effects)).hash == made(under(TRIO, *effects[::-1])).hash

    @pytest.mark.slow
    def test_whatever_changes_the_scene_changes_the_hash(self) -> None:
        changed = [replace(TRIO, **change) for change in self.CHANGES]  # type: ignore[arg-type]
        assert len({made(spec).hash for spec in (TRIO, *changed)}) == 1 + len(changed)


def binary(model: mujoco.MjModel) -> bytes:
    buffer = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()


class TestFleet:
    MANY = replace(TRIO, robots=("leader", *(f"f{i}" for i in range(70))))

    @pytest.mark.parametrize(
        "change",
        [
            {},
            {"effects": (PlanarBase(),), "robot_contact": True},
            pytest.param({"robot": "pioneer", "effects": (Payload(0.1, (0.0, 0.0, 0.3)),)}, marks=pytest.mark.slow),
        ],
        ids=str,
    )
    def test_many_read_in_groups_are_those_of_one_text(self, change: dict) -> None:
        scene = made(replace(self.MANY, **change))
        assert scene.blueprint.is_read_in_groups
        assert binary(scene.model) == binary(mujoco.MjModel.from_xml_string(scene.xml))

    @pytest.mark.slow
    def test_many_with_casters_that_swing_are_too(self) -> None:
        """Parts of one robot do not touch each other."""
        scene = made(replace(self.MANY, robot="mp500", robot_contact=True))
        assert scene.blueprint.is_read_in_groups
        assert scene.model.nexclude % len(self.MANY.robots) == 0 < scene.model.nexclude
        assert binary(scene.model) == binary(mujoco.MjModel.from_xml_string(scene.xml))

    def test_a_robot_s_materials_are_its_own(self, own_robot: Path) -> None:
        """Also those that geoms have by a class of the robot's file."""
        old, new = '<default class="visual">', '<geom material="glass"/><default class="visual">'
        bare = '<geom name="arm" size="0.01" mass="0" contype="0" conaffinity="0"/><body name="left_wheel"'
        text = own_robot.read_text().replace(old, new).replace('<body name="left_wheel"', bare)
        own_robot.write_text(text)
        for spec in (TRIO, self.MANY):
            model = made(replace(spec, robot=str(own_robot))).model
            for name, (geom, material) in product(
                spec.robots, (("left_spoke_2", "rim"), ("arm", "glass"), ("left_hub", "accent"))
            ):
                assert model.geom(f"{name}/{geom}").matid[0] == model.material(f"{name}/{material}").id

    def test_a_virtual_root_leads_many(self) -> None:
        scene = made(replace(self.MANY, virtual_root=True))
        assert scene.blueprint.is_read_in_groups
        assert scene.model.body("leader").mocapid[0] == scene.marker
        assert len(scene.addresses.motors) == scene.model.nu / 2 == 70

    def test_many_may_share_their_materials(self) -> None:
        scene = made(self.MANY, share_materials=True)
        own = made(self.MANY)
        assert scene.blueprint.is_read_in_groups
        # As many as robots' names have first letters, and as colours: MuJoCo draws no scene of more than 999.
        assert scene.model.nmat < own.model.nmat / 5
        for each in ("rgba", "specular", "shininess", "emission", "texid"):
            one, other = (getattr(s.model, f"mat_{each}")[s.model.geom_matid] for s in (scene, own))
            np.testing.assert_array_equal(one, other)

    def test_a_name_is_written_as_it_is(self) -> None:
        scene = made(replace(TRIO, robots=("a&b", 'x"<', "__robot__")))
        assert [scene.model.body(f"{name}/chassis").id for name in scene.spec.robots] == [2, 6, 10]
        with pytest.raises(ValueError, match="cannot contain '/'"):
            made(replace(TRIO, robots=("a/b",)))

    def test_a_unit_is_one_of_the_robots_alone(self) -> None:
        effects = WheelMismatch(0.01), Slope(0.1), TestPayload.LOAD
        spec = under(TRIO, *effects, virtual_root=True, colours=(0, 3, 5))
        scene, unit = made(spec), made(unit_spec(spec))
        assert unit.spec.bodies == spec.bodies[-1:]
        assert (unit.drive, unit.plant, unit.marker) == (scene.drive, scene.plant, None)
        tyres = scene.addresses.tyres[-1]
        for each in ("geom_solref", "geom_solimp", "geom_size", "geom_friction"):
            alone = getattr(unit.model, each)[unit.addresses.tyres[0]]
            np.testing.assert_array_equal(alone, getattr(scene.model, each)[tyres])
        np.testing.assert_array_equal(unit.model.qpos0, scene.model.qpos0[-unit.model.nq :])
        np.testing.assert_array_equal(unit.model.opt.gravity, scene.model.opt.gravity)
        np.testing.assert_array_equal(unit.model.material("f2/accent").rgba, scene.model.material("f2/accent").rgba)


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
    @pytest.mark.slow
    def test_the_scene_decides_options_and_the_robot_how_it_is_read(self, own_robot: Path) -> None:
        scene = made(SceneSpec(("a",), str(own_robot), timestep=0.0005))
        assert scene.model.opt.timestep == 0.0005
        assert scene.model.opt.gravity[2] == pytest.approx(-9.81, rel=HAND)
        assert scene.model.actuator_ctrllimited.all()  # autolimits

    def test_it_is_the_same_robot_and_stands_on_the_floor(self, own_robot: Path) -> None:
        scene = made(SceneSpec(("a",), str(own_robot)))
        ours = made(ONE).drive
        assert scene.drive.mass == pytest.approx(ours.mass, rel=HAND)
        assert scene.drive.com == pytest.approx(ours.com, abs=READING)
        assert scene.drive.axle_inertia == pytest.approx(ours.axle_inertia, abs=READING)
        data = standing(scene, PLACES[0])
        np.testing.assert_allclose(data.body("a/chassis").xpos[:2], 0, atol=READING)
        assert data.ncon == 3

    def test_it_may_have_a_payload_of_its_own(self, own_robot: Path) -> None:
        own = '<geom name="payload" size="0.01" mass="0.05" contype="0" conaffinity="0"/>'
        body = f'<body name="payload" pos="0 0 0.03">{own}</body>'
        text = own_robot.read_text().replace('<body name="left_wheel"', f'{body}<body name="left_wheel"')
        own_robot.write_text(text)
        load = Payload(0.1, (0.0, 0.0, 0.07))
        bare, laden = (made(SceneSpec(("a",), str(own_robot), effects=each)).plant for each in ((), (load,)))
        assert laden.mass == pytest.approx(bare.mass + 0.1, rel=HAND)

    @pytest.mark.parametrize(
        ("tag", "gear"), [("motor", 'gear="4"'), ("general", 'gear="2" gainprm="2"')], ids=["motor", "general"]
    )
    def test_its_motors_may_be_geared(self, own_robot: Path, tag: str, gear: str) -> None:
        """Whatever a control means in its file, in a scene it is the torque at the wheel."""
        text = own_robot.read_text()
        for side in ("left", "right"):
            old = f'<motor name="{side}_motor" joint="{side}_wheel" gear="1" ctrlrange="-0.0392266 0.0392266"/>'
            assert old in text
            new = f'<{tag} name="{side}_motor" joint="{side}_wheel" {gear} ctrlrange="-0.00980665 0.00980665"/>'
            text = text.replace(old, new)
        own_robot.write_text(text)
        scene = made(SceneSpec(("a",), str(own_robot)))
        assert scene.drive.motor.torque_limit == pytest.approx(0.0392266, rel=HAND)
        data = mujoco.MjData(scene.model)
        data.ctrl[:] = 0.03, 0.05
        mujoco.mj_forward(scene.model, data)
        torques = data.qfrc_actuator[scene.addresses.wheel_qvel[0]]
        np.testing.assert_allclose(torques, (0.03, 0.0392266), rtol=HAND)


class TestErrors:
    def test_an_unknown_robot(self) -> None:
        with pytest.raises(RobotError, match=r"no robot 'nh_mimi'; did you mean 'nh_mini'\? available: .*nh_mini"):
            made(SceneSpec(("a",), "nh_mimi"))

    def test_an_mjcf_that_is_not_there(self, tmp_path: Path) -> None:
        path = tmp_path / "absent.xml"
        with pytest.raises(RobotError, match=r"absent\.xml: no such robot file"):
            load_robot(str(path))

    @pytest.mark.parametrize(
        "text", ["", "not xml", "<mujoco><worldbody><body/></mujoco>", "<mujoco><wheel/></mujoco>"]
    )
    def test_an_mjcf_that_mujoco_cannot_read(self, tmp_path: Path, text: str) -> None:
        path = tmp_path / "broken.xml"
        path.write_text(text)
        with pytest.raises(RobotError, match=r"broken\.xml: "):
            load_robot(str(path))

    def test_an_mjcf_that_is_no_robot(self, tmp_path: Path) -> None:
        path = tmp_path / "ball.xml"
        path.write_text('<mujoco><worldbody><geom size="1"/></worldbody></mujoco>')
        with pytest.raises(RobotError, match="it has no body"):
            made(SceneSpec(("a",), str(path)))
