"""Habits of writing: names, units, defaults, frames, replicas, files within files."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
from scipy.spatial.transform import Rotation

from odd_robots.habit import habit
from odd_robots.plain import SIDES, add, part, section

_NAMED = ("body", "joint", "freejoint", "geom", "site", "camera", "light", "motor", "velocity", "general", "position",
          "mesh", "fixed", "pair", "exclude")  # fmt: skip
_REFERENCES = (
    "joint",
    "jointinparent",
    "joint1",
    "joint2",
    "tendon",
    "body1",
    "body2",
    "geom1",
    "geom2",
    "site",
    "mesh",
)


def _rename(robot: ET.Element, change: dict[str, str]) -> None:
    for each in robot.iter():
        if each.tag in _NAMED and each.get("name") in change:
            each.set("name", change[each.get("name", "")])
        for key in _REFERENCES:
            if each.get(key) in change and each.tag != "default":
                each.set(key, change[each.get(key, "")])


@habit("names")
def names_with_slashes(robot: ET.Element) -> None:
    asset, chassis = section(robot, "asset"), next(robot.iter("body"))
    for name in ("paint_a", "paint/a"):
        add(asset, f'<texture name="{name}" type="2d" builtin="flat" width="4" height="4" rgb1="1 0 0"/>')
        add(asset, f'<material name="{name}" texture="{name}"/>')
    add(asset, '<mesh name="spoiler/left" vertex="0 0 0 0.02 0 0 0 0.02 0 0 0 0.02"/>')
    add(
        chassis,
        '<geom type="mesh" mesh="spoiler/left" material="paint/a" pos="0 0 0.1" mass="0" contype="0" conaffinity="0"/>',
    )
    names = {each.get("name", "") for each in robot.iter() if each.tag in _NAMED and each.get("name")}
    _rename(robot, {name: f"robot/{name}" for name in names})


@habit("names")
def names_with_spaces_and_umlauts(robot: ET.Element) -> None:
    _rename(
        robot,
        {name: name.replace("_", " ") + " Größe ${ns}" for side in SIDES for name in (f"{side}_axle", f"{side}_wheel")},
    )


@habit("names")
def no_names(robot: ET.Element) -> None:
    used = {each.get(key) for each in robot.iter() for key in _REFERENCES}
    for each in robot.iter():
        if each.tag in _NAMED and each.tag != "mesh" and each.get("name") not in used:
            each.attrib.pop("name", None)


@habit("names")
def names_of_ours(robot: ET.Element) -> None:
    # What the standard form calls its parts is called so here, elsewhere: nothing may be mixed up.
    pairs = [("left_axle", "right_wheel"), ("right_axle", "left_wheel"), ("left_tyre", "right_tyre")]
    pairs += [("left_motor", "right_motor")]
    swapped = {"hull": "caster_1", "caster": "chassis"} | dict(pairs) | {b: a for a, b in pairs}
    for each in robot.iter():
        for key in ("name", *_REFERENCES):
            if each.get(key) in swapped and not (key == "name" and each.tag not in _NAMED):
                each.set(key, swapped[each.get(key, "")])


@habit("spelling")
def angles_in_degrees(robot: ET.Element) -> None:
    for each in robot.iter():
        quat = each.get("quat")
        if quat:
            turned = Rotation.from_quat(np.array(quat.split(), dtype=float), scalar_first=True).as_rotvec(degrees=True)
            angle = float(np.linalg.norm(turned))
            del each.attrib["quat"]
            if angle > 0:
                each.set("axisangle", " ".join(repr(float(value)) for value in (*(turned / angle), angle)))


@habit("spelling")
def angles_in_radians(robot: ET.Element) -> None:
    robot.insert(0, ET.fromstring('<compiler angle="radian"/>'))
    for each in robot.iter():
        if each.get("euler"):
            angles = np.radians(np.array(each.get("euler", "").split(), dtype=float))
            each.set("euler", " ".join(repr(float(angle)) for angle in angles))
        if each.tag == "joint" and each.get("range") and each.get("type") != "slide":
            each.set("range", "-1.7 1.7")


@habit("defaults")
def defaults(robot: ET.Element) -> None:
    top = ET.fromstring(
        '<default><geom rgba="0.5 0.5 0.5 1" friction="0.7 0.1 0.1" condim="4" margin="0.001" solref="0.01 1"/>'
        '<default class="wheel"><geom group="3"/><site size="0.01"/></default></default>'
    )
    robot.insert(0, top)
    for side in SIDES:
        part(robot, f"{side}_wheel").set("childclass", "wheel")
    add(section(robot, "custom"), '<text name="author" data="somebody"/>')


@habit("structure")
def frames(robot: ET.Element) -> None:
    holder = next(each for each in robot.iter() if part(robot, "left_wheel") in each)
    for side in SIDES:
        wheel = part(robot, f"{side}_wheel")
        outer = ET.Element("frame", {"pos": wheel.attrib.pop("pos", "0 0 0")})
        holder.insert(list(holder).index(wheel), outer)
        holder.remove(wheel)
        outer.append(wheel)


@habit("structure")
def replicas(robot: ET.Element) -> None:
    rack = add(part(robot, "chassis"), '<replicate count="6" euler="0 0 60"/>')
    pillar = add(rack, '<geom name="pillar" type="cylinder" size="0.003 0.02" pos="0.03 0 0.08" mass="0"/>')
    pillar.attrib |= {"contype": "0", "conaffinity": "0"}
    add(rack, '<site name="ray" pos="0.05 0 0.1"/>')
    sensors = robot.find("sensor")
    if sensors is None:
        sensors = ET.Element("sensor")
        robot.append(sensors)
    add(sensors, '<rangefinder name="left_tyre" site="ray"/>')
