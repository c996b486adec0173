"""Scenes composed with dm_control and without it are the same to the last bit."""

from __future__ import annotations

import dataclasses
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

import nhtrack.mjcf
from nhtrack import assets
from nhtrack.effects.patches import Patches
from nhtrack.effects.payload import Payload
from nhtrack.effects.planar_base import PlanarBase
from nhtrack.effects.wheel_mismatch import WheelMismatch
from nhtrack.errors import RobotError
from nhtrack.ground import Patch
from nhtrack.mjcf import plain
from nhtrack.mjcf.attach import REFERENCES
from nhtrack.mjcf.files import FILES, UNREADABLE
from nhtrack.simulation import scene
from nhtrack.simulation.spec import SceneSpec

both = pytest.mark.skipif(find_spec("dm_control") is None, reason="dm_control is not installed")

PAYLOAD = Payload(0.2, (0.0, 0.01, 0.1), (0.05, 0.05, 0.05))
PATCHES = Patches((Patch(0.05, disc=(0.5, 0.1, 0.2)), Patch(1.5, rectangle=(0.0, 1.0, 0.0, 1.0))))
# A robot of habits unlike ours: files, a main class of its own, names that point at all kinds of things.
STRANGER = """<mujoco model="stranger">
  <compiler angle="degree" meshdir="parts" texturedir="skins"/>
  <include file="settings.xml"/>
  <asset>
    <mesh file="wedge.obj" scale="0.1 0.1 0.1"/>
    <texture name="paint" type="2d" file="paint.png"/>
    <texture name="plain" type="cube" builtin="flat" rgb1="1 0 0" width="8" height="48"/>
    <material name="accent" texture="paint"/>
    <material name="other" texture="plain" class="dull"/>
  </asset>
  <worldbody>
    <light name="lamp" pos="0 0 1" mode="targetbody" target="chassis"/>
    <body name="chassis">
      <freejoint name="root"/>
      <geom name="hull" size="0.1"/>
      <geom name="wedge" type="mesh" mesh="wedge" material="accent" class="visual"/>
      <geom size="0.01" pos="0 0 0.1"/>
      <site name="imu" pos="0 0 0.1" euler="0 90 0"/>
      <body name="arm" pos="0.2 0 0" childclass="visual">
        <joint name="shoulder" axis="0 1 0" range="-90 90" limited="true"/>
        <geom name="rod" size="0.02" fromto="0 0 0 0.2 0 0" type="capsule"/>
        <site name="tip" pos="0.2 0 0"/>
        <body name="hand" pos="0.2 0 0">
          <joint name="wrist" axis="0 1 0"/>
          <geom name="palm" size="0.03"/>
        </body>
      </body>
    </body>
  </worldbody>
  <contact>
    <exclude body1="chassis" body2="arm"/>
    <pair geom1="hull" geom2="palm"/>
  </contact>
  <equality>
    <joint joint1="wrist" joint2="shoulder" polycoef="0 0.5 0 0 0"/>
    <weld body1="hand" body2="chassis" active="false"/>
  </equality>
  <tendon>
    <fixed name="cable"><joint joint="wrist" coef="1"/><joint joint="shoulder" coef="-1"/></fixed>
    <spatial name="rope"><site site="imu"/><geom geom="palm" sidesite="tip"/><site site="tip"/></spatial>
  </tendon>
  <actuator>
    <motor name="arm_motor" joint="shoulder" gear="2"/>
    <position name="cable_motor" tendon="cable" kp="3"/>
    <general name="thrust" site="tip" refsite="imu" gear="1 0 0 0 0 0"/>
  </actuator>
  <sensor>
    <gyro name="gyro" site="imu"/>
    <framepos name="where" objtype="site" objname="tip" reftype="body" refname="chassis"/>
    <actuatorfrc name="force" actuator="arm_motor"/>
    <subtreecom name="centre" body="chassis"/>
  </sensor>
</mujoco>"""
SETTINGS = """<mujoco>
  <default>
    <geom density="500" rgba="0.5 0.6 0.7 1"/>
    <motor ctrlrange="-2 2" ctrllimited="true"/>
    <material specular="0.1"/>
    <mesh inertia="shell"/>
    <pair friction="0.3 0.3 0.01 0.001 0.001"/>
    <tendon width="0.002"/>
    <equality solref="0.01 1"/>
    <site size="0.004"/>
    <default class="visual"><geom contype="0" conaffinity="0" group="2"/><joint damping="0.1"/></default>
    <default class="dull"><material specular="0"/></default>
  </default>
  <visual><rgba joint="0 1 0 1"/></visual>
  <custom><numeric name="motor_stall_torque" data="0.1"/></custom>
</mujoco>"""
WEDGE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


@contextmanager
def without_dm_control() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr(nhtrack.mjcf, "find_spec", lambda _: None)
        yield


def model_bytes(model: mujoco.MjModel) -> bytes:
    buffer = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()


@pytest.fixture
def stranger(tmp_path: Path) -> Path:
    from PIL import Image

    for name, text in (("stranger.xml", STRANGER), ("settings.xml", SETTINGS), ("parts/wedge.obj", WEDGE)):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    (tmp_path / "skins").mkdir()
    Image.new("RGB", (4, 4), (200, 100, 0)).save(tmp_path / "skins" / "paint.png")
    return tmp_path / "stranger.xml"


def in_arena(from_path: Callable[[Path], Any], file: Path) -> mujoco.MjModel:
    """Two of a robot in the arena, some of it edited after it was hung there."""
    arena = from_path(assets.models_directory() / "arena" / "scene.xml")
    arena.compiler.remove()
    for name in ("a", "b"):
        robot = from_path(file)
        robot.model = name
        robot.find("joint", "root").remove()
        frame = arena.worldbody.attach(robot)
        frame.pos = (0.1, 0.2 + 0.3 * (name == "b"), 1 / 3)
        frame.add("freejoint", name="root")
        robot.find("actuator", "arm_motor").gear = (3.5,)
        robot.find("geom", "palm").size = 1.1 * np.asarray(robot.find("geom", "palm").size)
        box = robot.find("body", "hand").add("body", name="load", pos=(0, 0, 0.1))
        box.add("geom", name="load", type="box", size=(0.1, 0.1, 0.1 / 3), material=robot.find("material", "accent"))
    return mujoco.MjModel.from_xml_string(arena.to_xml_string(), arena.get_assets())


# -- the same as with dm_control ---------------------------------------------------------------------


@pytest.mark.slow
@both
@pytest.mark.parametrize("robot", assets.robots())
@pytest.mark.parametrize(
    "change",
    [
        {"effects": (PlanarBase(),)},
        {"robot_contact": True, "contact": "default"},
        {"effects": (WheelMismatch(0.02), PAYLOAD, PATCHES), "virtual_root": True},
    ],
    ids=["planar", "contact", "changed"],
)
def test_a_scene_is_the_same(robot: str, change: dict[str, Any]) -> None:
    spec = dataclasses.replace(SceneSpec(robots=("leader", "one", "two"), robot=robot), **change)
    expected = scene.make_scene(spec)
    with without_dm_control():
        assert scene.make_scene(spec).hash == expected.hash


@pytest.mark.slow
@both
def test_a_fleet_of_many_and_a_film_are_the_same() -> None:
    spec = SceneSpec(robots=tuple(f"robot_{index}" for index in range(70)), robot="nh_mini")
    for share in (False, True):
        expected = scene.make_scene(spec, share_materials=share)
        with without_dm_control():
            assert scene.make_scene(spec, share_materials=share).hash == expected.hash


@both
def test_a_robot_of_other_habits_is_the_same(stranger: Path) -> None:
    expected = in_arena(nhtrack.mjcf.read_mjcf, stranger)
    assert {expected.nmesh, expected.ntendon - 2, expected.neq - 2, expected.nexclude} == {2}
    assert model_bytes(in_arena(plain.from_path, stranger)) == model_bytes(expected)


@both
def test_every_attribute_that_names_an_element_is_known() -> None:
    """Those of dm_control's schema, and none of them is something else elsewhere."""
    kinds: dict[str, set[str]] = {}

    def collect(element: ET.Element) -> None:
        if element.attrib["name"] in ("visual", *UNREADABLE):
            return
        for attribute in element.iterfind("attributes/attribute"):
            kinds.setdefault(attribute.attrib["name"], set()).add(attribute.attrib["type"])
        for child in element.iterfind("children/element"):
            collect(child)

    collect(ET.fromstring((files("dm_control") / "mjcf" / "schema.xml").read_bytes()))
    naming = {name for name, found in kinds.items() if found & {"reference", "identifier"}}
    assert naming - {"model"} == set(REFERENCES)
    assert all(kinds[name] <= {"reference", "identifier"} for name in REFERENCES)
    assert {name for name, found in kinds.items() if "file" in found} == set(FILES)


# -- on its own --------------------------------------------------------------------------------------


def test_what_is_read_can_be_asked_for(stranger: Path) -> None:
    robot = plain.from_path(stranger)
    hull = robot.find("geom", "hull")
    assert hull is not None
    assert (hull.tag, hull.size, hull.material, hull.dclass) == ("geom", 0.1, None, None)
    assert robot.find("geom", "wedge").dclass.geom.group == 2  # type: ignore[union-attr]
    assert robot.find("joint", "root").tag == "freejoint"  # type: ignore[union-attr]
    assert robot.find("actuator", "imu") is None
    assert list(robot.find("site", "imu").pos) == [0, 0, 0.1]  # type: ignore[union-attr]
    assert robot.option.timestep is None
    robot.option.flag.contact = "disable"
    assert '<option><flag contact="disable" /></option>' in robot.to_xml_string()
    assert {Path(name).suffix for name in robot.get_assets()} == {".obj", ".png"}


def test_numbers_are_read_back_to_the_last_bit() -> None:
    robot = plain.from_path(assets.models_directory() / "nh_mini" / "robot.xml")
    value = np.array([1 / 3, np.nextafter(1, 2), 1e-300])
    robot.find("geom", "hull").pos = value  # type: ignore[union-attr]
    assert (robot.find("geom", "hull").pos == value).all()  # type: ignore[union-attr]


def test_main_classes_and_the_world_keep_their_meaning(tmp_path: Path) -> None:
    """dm_control reads neither."""
    (tmp_path / "robot.xml").write_text("""<mujoco model="r">
      <default class="all"><geom size="0.5"/><default class="thin"><geom size="0.1"/></default></default>
      <worldbody><body name="b" childclass="thin">
        <geom name="one"/><geom name="two" class="all"/><geom name="three" class="main"/>
      </body></worldbody>
      <equality><weld body1="b" body2="world"/></equality></mujoco>""")
    (tmp_path / "scene.xml").write_text("<mujoco><worldbody/></mujoco>")
    arena = plain.from_path(tmp_path / "scene.xml")
    arena.worldbody.attach(plain.from_path(tmp_path / "robot.xml"))
    model = mujoco.MjModel.from_xml_string(arena.to_xml_string())
    assert [model.geom(f"r/{name}").size[0] for name in ("one", "two", "three")] == [0.1, 0.5, 0.5]
    assert list(model.eq_obj1id) + list(model.eq_obj2id) == [model.body("r/b").id, 0]


@pytest.mark.parametrize("tag", UNREADABLE)
def test_what_makes_up_names_is_refused(tag: str, tmp_path: Path) -> None:
    (tmp_path / "robot.xml").write_text(f"<mujoco><worldbody><{tag}/></worldbody></mujoco>")
    with pytest.raises(RobotError, match=rf"robot\.xml: cannot read <{tag}> without dm_control"):
        plain.from_path(tmp_path / "robot.xml")


@pytest.mark.parametrize(("text", "said"), [("<mujoco", "no XML"), ("<robot/>", "expected <mujoco>, got <robot>")])
def test_what_is_no_mjcf_is_refused(text: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "robot.xml").write_text(text)
    with pytest.raises(RobotError, match=said):
        plain.from_path(tmp_path / "robot.xml")


@pytest.mark.parametrize(
    ("scene_has", "robot_has", "said"),
    [
        ('<compiler angle="radian"/>', "", "<compiler> angle: the scene has 'radian', the robot leaves it out"),
        ('<option timestep="0.001"/>', '<option timestep="0.002"/>', "timestep: the scene has '0.001', the robot has"),
        ("<default><geom density='1'/></default>", "", "a scene that robots hang in cannot have default classes"),
    ],
)
def test_settings_that_contradict_each_other_are_refused(
    scene_has: str, robot_has: str, said: str, tmp_path: Path
) -> None:
    for name, text in (("scene.xml", scene_has), ("robot.xml", robot_has)):
        (tmp_path / name).write_text(f"<mujoco>{text}<worldbody/></mujoco>")
    arena = plain.from_path(tmp_path / "scene.xml")
    arena.worldbody.attach(plain.from_path(tmp_path / "robot.xml"))
    with pytest.raises(RobotError, match=said):
        arena.to_xml_string()
