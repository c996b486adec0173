"""What the page on robots says that stops people is what they are told."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path

import pytest

from nhtrack.errors import RobotError
from nhtrack.robots.registry import read_file
from odd_robots.faults import FAULTS
from odd_robots.habits import HABITS
from odd_robots.plain import part, plain_robot, section, text_of

PAGE = (Path(__file__).parents[2] / "docs/how-to/own_robot.md").read_text(encoding="utf-8")
MESSAGES = re.findall(r"^\| \*(.+?)\* \|", PAGE, re.MULTILINE)


def a_mesh_that_is_missing(robot: ET.Element) -> None:
    section(robot, "asset").append(ET.Element("mesh", name="shell", file="shell.stl"))
    hull = part(robot, "hull")
    hull.set("type", "mesh")
    hull.set("mesh", "shell")
    del hull.attrib["size"]


def nothing(robot: ET.Element) -> None:
    """A plain robot has notes, too."""


CAUSES: dict[str, Callable[[ET.Element], None]] = {
    "cannot find mesh file": a_mesh_that_is_missing,
    "name its wheel joints under `robot: wheels:`": FAULTS["no_actuators"].change,
    "a wheel that stands on the floor and is not driven": FAULTS["a_passive_wheel"].change,
    "skid steer, whose wheels scrub sideways": FAULTS["four_driven_wheels"].change,
    "a position servo turns its wheel to an angle": FAULTS["position_servos"].change,
    "its dynamics (filter) delay the torque": FAULTS["delayed_motors"].change,
    "a spring holds the wheel": FAULTS["springs_on_wheels"].change,
    "stops the wheel": FAULTS["a_limited_wheel"].change,
    "it tips by itself": FAULTS["no_caster"].change,
    "the hull stands on the floor": FAULTS["a_hull_on_the_floor"].change,
    "no speed without load is stated": nothing,
    "no limit of torque is stated": HABITS["motors_without_limits"].change,
    "ahead is its -y": HABITS["ahead_is_minus_y"].change,
    "held:": HABITS["arm"].change,
    "casters swing freely": HABITS["swivel_caster"].change,
}


def told(file: Path) -> str:
    """Returns what is said of a robot's file: why it is refused, or its notes."""
    try:
        return "\n".join(read_file(file).notes)
    except RobotError as error:
        return str(error)


@pytest.mark.parametrize("message", MESSAGES)
def test_it_is_what_people_are_told(message: str, tmp_path: Path) -> None:
    robot, xacro = plain_robot(), message.startswith("a xacro file")
    if not xacro:
        CAUSES[message](robot)
    file = tmp_path / ("robot.urdf.xacro" if xacro else "robot.xml")
    file.write_text(text_of(robot), encoding="utf-8")
    assert message.strip() in told(file)


def test_every_cause_is_on_the_page() -> None:
    assert set(CAUSES) < set(MESSAGES)
    assert len(MESSAGES) == len(CAUSES) + 1
