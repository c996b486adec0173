"""A plain robot, as elements of its MJCF, and what moves a body's frame without moving what is in it."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

SIDES = ("left", "right")

#: What is read of the plain robot [m, kg, N m].
RADIUS, HALF_SEPARATION, MASS, TORQUE = 0.05, 0.1, 2.6, 1.0

_TAGS = {
    "actuator": "motor|velocity|position|general",
    "equality": "joint|connect|weld",
    "tendon": "spatial|fixed",
}

_PLAIN = """
<mujoco model="plain">
  <worldbody>
    <body name="chassis" pos="0 0 0.05">
      <freejoint name="root"/>
      <inertial mass="2" pos="-0.02 0 0.01" diaginertia="0.006 0.009 0.012"/>
      <geom name="hull" type="box" size="0.09 0.07 0.03" pos="-0.02 0 0.03"/>
      <geom name="caster" type="sphere" size="0.02" pos="-0.08 0 -0.03"/>
      <body name="left_wheel" pos="0 0.1 0">
        <inertial mass="0.3" pos="0 0 0" diaginertia="2e-4 4e-4 2e-4"/>
        <joint name="left_axle" axis="0 1 0"/>
        <geom name="left_tyre" type="ellipsoid" size="0.05 0.01 0.05"/>
      </body>
      <body name="right_wheel" pos="0 -0.1 0">
        <inertial mass="0.3" pos="0 0 0" diaginertia="2e-4 4e-4 2e-4"/>
        <joint name="right_axle" axis="0 1 0"/>
        <geom name="right_tyre" type="ellipsoid" size="0.05 0.01 0.05"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor name="left_motor" joint="left_axle" ctrllimited="true" ctrlrange="-1 1"/>
    <motor name="right_motor" joint="right_axle" ctrllimited="true" ctrlrange="-1 1"/>
  </actuator>
</mujoco>
"""


def plain_robot() -> ET.Element:
    """Returns the root of a new plain robot."""
    return ET.fromstring(_PLAIN)


def text_of(robot: ET.Element) -> str:
    """Returns a robot as text, an element a line."""
    ET.indent(robot)
    return ET.tostring(robot, encoding="unicode") + "\n"


def line_of(text: str, kind: str, name: str) -> int:
    """Returns the line on which the element of a kind with a name stands, from 1."""
    tags = {
        "actuator": "motor|velocity|position|general",
        "equality": "joint|connect|weld",
        "tendon": "spatial|fixed",
    }.get(kind, kind)
    found = [n for n, line in enumerate(text.splitlines(), 1) if re.match(rf'\s*<({tags}) name="{name}"', line)]
    assert len(found) == 1, (kind, name, found)
    return found[0]


def part(robot: ET.Element, name: str, tag: str = "*") -> ET.Element:
    """Returns the one element below the world, or among the actuators, with a name."""
    sections = (robot.find("worldbody"), robot.find("actuator"))
    found = [each for one in sections if one is not None for each in one.findall(f".//{tag}[@name='{name}']")]
    assert len(found) == 1, (name, found)
    return found[0]


def section(robot: ET.Element, tag: str) -> ET.Element:
    """Returns a section of a robot, made where there is none."""
    found = robot.find(tag)
    if found is None:
        found = ET.Element(tag)
        robot.insert(0, found)
    return found


def add(parent: ET.Element, markup: str) -> ET.Element:
    """Returns an element written as markup after it is put at the end of another."""
    child = ET.fromstring(markup)
    parent.append(child)
    return child


def turn(axis: str, degrees: float) -> Rotation:
    """Returns a rotation about `x`, `y` or `z`."""
    return Rotation.from_euler(axis, degrees, degrees=True)


def reframe(body: ET.Element, pos: Sequence[float] = (0, 0, 0), rotation: Rotation | None = None) -> None:
    """Moves the frame of a body, given in the old one; what is in it stays where it is."""
    moved, shift = rotation or Rotation.identity(), np.asarray(pos, dtype=float)
    for child in body:
        if child.tag in ("geom", "body", "site", "camera", "inertial", "frame", "joint"):
            if not (child.tag == "joint" and child.get("type") == "free"):
                _put(child, moved.inv().apply(_pos(child) - shift))
        if child.tag in ("geom", "body", "site", "camera", "inertial", "frame"):
            _orient(child, moved.inv() * _rotation(child))
        if child.tag == "joint" and child.get("axis"):
            child.set("axis", _numbers(moved.inv().apply(_floats(child.get("axis", "")))))
    _put(body, _pos(body) + _rotation(body).apply(shift))
    _orient(body, _rotation(body) * moved)


def _floats(text: str) -> np.ndarray:
    return np.array(text.split(), dtype=float)


def _numbers(values: Sequence[float] | np.ndarray) -> str:
    return " ".join(repr(float(value) + 0.0) for value in values)


def _pos(element: ET.Element) -> np.ndarray:
    return _floats(element.get("pos", "0 0 0"))


def _put(element: ET.Element, pos: np.ndarray) -> None:
    if element.get("pos") or np.abs(pos).max() > 0:
        element.set("pos", _numbers(pos))


def _rotation(element: ET.Element) -> Rotation:
    return Rotation.from_quat(_floats(element.get("quat", "1 0 0 0")), scalar_first=True)


def _orient(element: ET.Element, rotation: Rotation) -> None:
    quat = rotation.as_quat(scalar_first=True)
    if element.get("quat") or np.abs(quat[1:]).max() > 1e-15:
        element.set("quat", _numbers(quat))
