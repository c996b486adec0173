"""Which files hold a robot: endings, folders, URDF, meshes found and missing, and what is said of all others."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from nhtrack.errors import RobotError
from nhtrack.robots.contract import Hints
from nhtrack.robots.registry import read_file
from odd_robots.on_disk import shell, urdf, written
from odd_robots.plain import plain_robot, text_of

WHEELS = Hints(wheels=("left_axle", "right_axle"))

@pytest.mark.parametrize("name", ["robot.xml", "ROBOT.XML", "robot.mjcf", "a robot.of mine.xml"])
def test_a_file_is_known_by_its_ending(name: str, tmp_path: Path) -> None:
    assert read_file(written(tmp_path, name, text_of(plain_robot()))).model.wheel_radius == pytest.approx(0.05)


@pytest.mark.parametrize("comment", ["<!-- a -- b -->", "\ufeff", "<?xml version='1.0'?>\n<!-- x -->"])
def test_what_mujoco_reads_is_read(comment: str, tmp_path: Path) -> None:
    assert read_file(written(tmp_path, "robot.xml", comment + text_of(plain_robot()))).model.mass == pytest.approx(2.6)


class TestFolders:
    def test_one_model(self, tmp_path: Path) -> None:
        file = written(tmp_path, "cart.xml", text_of(plain_robot()))
        assert read_file(tmp_path).file == file

    def test_one_model_and_the_scene_around_it(self, tmp_path: Path) -> None:
        file = written(tmp_path, "cart.xml", text_of(plain_robot()))
        written(tmp_path, "scene.xml", '<mujoco><include file="cart.xml"/></mujoco>')
        assert read_file(tmp_path).file == file

    def test_several_are_named(self, tmp_path: Path) -> None:
        for name in ("a.xml", "b.xml"):
            written(tmp_path, name, text_of(plain_robot()))
        with pytest.raises(RobotError, match=r"a\.xml, b\.xml"):
            read_file(tmp_path)

    def test_none(self, tmp_path: Path) -> None:
        with pytest.raises(RobotError, match="none"):
            read_file(tmp_path)


class TestInclude:
    def test_a_robot_in_a_scene(self, tmp_path: Path) -> None:
        written(tmp_path, "parts/cart.xml", text_of(plain_robot()))
        scene = written(
            tmp_path,
            "scene.xml",
            '<mujoco><include file="parts/cart.xml"/><worldbody><geom type="plane" size="1 1 1"/></worldbody></mujoco>',
        )
        assert read_file(scene).model.mass == pytest.approx(2.6)

    def test_what_is_missing_is_named(self, tmp_path: Path) -> None:
        scene = written(tmp_path, "scene.xml", '<mujoco><include file="cart.xml"/></mujoco>')
        with pytest.raises(RobotError, match=r"cart\.xml"):
            read_file(scene)

    def test_no_wrong_line_is_told_of_an_included_element(self, tmp_path: Path) -> None:
        robot = plain_robot()
        joint = robot.find(".//joint[@name='left_axle']")
        assert joint is not None
        joint.set("stiffness", "1")
        written(tmp_path, "cart.xml", text_of(robot))
        scene = written(tmp_path, "scene.xml", '<mujoco><include file="cart.xml"/></mujoco>')
        with pytest.raises(RobotError) as caught:
            read_file(scene)
        assert "left_axle" in str(caught.value)
        assert "line 0" not in str(caught.value)


class TestMeshes:
    def test_one_that_touches_is_asked_for(self, tmp_path: Path) -> None:
        robot = text_of(plain_robot()).replace('type="ellipsoid" size="0.05 0.01 0.05"', 'type="mesh" mesh="tyre"')
        robot = robot.replace("<worldbody>", '<asset><mesh name="tyre" file="tyre.stl"/></asset><worldbody>')
        with pytest.raises(RobotError, match=re.escape(str(tmp_path / "tyre.stl"))):
            read_file(written(tmp_path, "robot.xml", robot))

    def test_a_drawing_that_is_missing_is_left_out_and_told(self, tmp_path: Path) -> None:
        reading = read_file(written(tmp_path, "cart.urdf", urdf()), WHEELS)
        assert reading.model.mass == pytest.approx(2.6)
        assert any("shell.stl" in note for note in reading.notes)

    def test_a_package_is_found_around_the_file(self, tmp_path: Path) -> None:
        shell(tmp_path, "cart_description/meshes/shell.stl")
        reading = read_file(written(tmp_path, "cart_description/urdf/cart.urdf", urdf()), WHEELS)
        assert not any("shell.stl" in note for note in reading.notes)
        assert "shell.stl" in reading.mjcf


class TestUrdf:
    def test_its_wheels_are_named(self, tmp_path: Path) -> None:
        drive = read_file(written(tmp_path, "cart.urdf", urdf()), WHEELS).model
        assert (drive.wheel_radius, drive.half_separation, drive.mass) == pytest.approx((0.05, 0.1, 2.6))
        assert drive.com == pytest.approx((-0.04 / 2.6, 0.0, 0.05 + 0.02 / 2.6), abs=1e-6)
        assert len(drive.casters) == 1
        assert drive.motor.torque_limit == pytest.approx(1.5)

    def test_without_names_it_says_what_to_name(self, tmp_path: Path) -> None:
        with pytest.raises(RobotError, match="left_axle, right_axle"):
            read_file(written(tmp_path, "cart.urdf", urdf()))

    def test_a_name_that_is_none_of_its_joints(self, tmp_path: Path) -> None:
        with pytest.raises(RobotError, match="left_axle"):
            read_file(written(tmp_path, "cart.urdf", urdf()), Hints(wheels=("left_axel", "right_axle")))

    def test_the_attribute_that_xacro_leaves_behind_is_none(self, tmp_path: Path) -> None:
        text = urdf().replace("<robot ", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" ')
        assert read_file(written(tmp_path, "cart.urdf", text), WHEELS).model.mass == pytest.approx(2.6)

    @pytest.mark.parametrize("name", ["cart.urdf.xacro", "cart.xacro", "cart.urdf"])
    def test_xacro_is_refused_with_the_command_that_expands_it(self, name: str, tmp_path: Path) -> None:
        text = urdf().replace("<robot ", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" ')
        text = text.replace('<mass value="2"/>', '<mass value="${2 * m}"/><xacro:property name="m" value="1"/>')
        with pytest.raises(RobotError) as caught:
            read_file(written(tmp_path, name, text), WHEELS)
        command = re.search(r"`xacro (\S+) > (\S+)`", str(caught.value))
        assert command is not None
        assert command[1] == name
        assert command[2] != name


class TestNone:
    @pytest.mark.parametrize(
        ("text", "told"),
        [
            ("", "robot.xml"),
            ("hello", "robot.xml"),
            ("<mujoco><worldbody></mujoco>", "robot.xml"),
            ("<sdf/>", "<sdf>"),
            ("<mujoco/>", "robot.xml"),
            ("<mujoco><worldbody><body><geom size='x'/></body></worldbody></mujoco>", "robot.xml"),
        ],
    )
    def test_what_is_no_robot_is_told_with_its_file(self, text: str, told: str, tmp_path: Path) -> None:
        with pytest.raises(RobotError, match=re.escape(told)):
            read_file(written(tmp_path, "robot.xml", text))

    def test_no_such_file(self, tmp_path: Path) -> None:
        with pytest.raises(RobotError, match=r"nowhere\.xml"):
            read_file(tmp_path / "nowhere.xml")
