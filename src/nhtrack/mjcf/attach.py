"""Robots hung into a scene: two MJCF trees made one, with the robot's names after the name of its model."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import Counter
from copy import deepcopy

from nhtrack.errors import RobotError

__all__ = ["REFERENCES", "attached"]

# Attributes whose value is the name of an element, whatever has them.
REFERENCES = (
    "actuator", "body", "body1", "body2", "camera", "childclass", "class", "cranksite", "flex", "geom", "geom1",
    "geom2", "hfield", "joint", "joint1", "joint2", "jointinparent", "material", "mesh", "name", "objname", "refname",
    "refsite", "sidesite", "site", "site1", "site2", "slidersite", "subtree1", "subtree2", "target", "tendon",
    "tendon1", "tendon2", "texture",
)  # fmt: skip
_SETTINGS = ("compiler", "option", "size", "statistic", "visual")  # there is one of each in a model
_WITH_CLASS = ("actuator", "equality", "tendon")  # sections whose elements all have a default class
_IN_WORLD = ("body", "camera", "freejoint", "geom", "joint", "light", "site")  # elements with names
_IN_SECTIONS = ("actuator", "contact", "equality", "sensor", "tendon")  # whose elements have names
_ALSO_WITH_CLASS = ("camera", "geom", "light", "material", "mesh", "pair", "site")


def attached(scene: ET.Element, robots: list[tuple[ET.Element, ET.Element]]) -> ET.Element:
    """Returns the root of a scene with robots in it; neither is changed.

    Args:
        scene: its root, which has no default classes.
        robots: the body of the scene that each hangs in, and the root of its MJCF.

    Raises:
        RobotError: settings contradict each other, or the scene has default classes, which a robot would inherit.
    """
    whole = deepcopy(scene)
    if robots and any(len(each) for each in scene.findall("default")):
        raise RobotError("a scene that robots hang in cannot have default classes: write them into its elements")
    twins = dict(zip(scene.iter(), whole.iter(), strict=True))
    _name(whole, "/")
    for frame, robot in robots:
        _hang(whole, twins[frame], deepcopy(robot))
    return whole


def _name(root: ET.Element, prefix: str) -> None:
    """Names what has no name after its place among its like, so that whoever speaks of it can say which."""
    counts: Counter[str] = Counter()
    named = [(section.tag, element) for section in root for element in section if section.tag in _IN_SECTIONS]
    for element in root.iterfind("worldbody//*"):
        if element.tag in _IN_WORLD:
            named.append((element.tag.removeprefix("free"), element))
    for kind, element in named:
        element.attrib.setdefault("name", f"{prefix}/unnamed_{kind}_{counts[kind]}")
        counts[kind] += 1


def _hang(scene: ET.Element, frame: ET.Element, robot: ET.Element) -> None:
    prefix = robot.get("model", "") + "/"
    _rename(robot, prefix)
    if scene.find("compiler") is not None:
        _section(robot, "compiler")  # what a robot leaves out has the default's value, not the scene's
    _name(robot, prefix)
    for joint in frame:
        joint.set("name", f"{prefix}{joint.attrib['name']}/")
    frame.set("name", prefix)
    for section in robot:
        if section.tag == "worldbody":
            frame.extend(section)
        elif section.tag == "default":
            _section(_section(scene, "default"), "default", prefix).extend(section)
        elif section.tag in _SETTINGS:
            _agree(_section(scene, section.tag), section, strict=section.tag == "compiler")
        else:
            _section(scene, section.tag).extend(section)


def _rename(robot: ET.Element, prefix: str) -> None:
    """Puts a prefix before all names of a robot, and gives its main default class to what names none."""
    main = {"main", *(each.get("class", "main") for each in robot.findall("default"))}
    for section in robot:
        if section.tag not in _SETTINGS:  # where `joint` may be a colour
            for element in section.iter():
                for name in set(REFERENCES) & set(element.attrib):
                    value = element.attrib[name]
                    if name in ("class", "childclass") and value in main:
                        element.set(name, prefix)
                    elif value != "world":
                        element.set(name, prefix + value)
        for element in section:
            if section.tag == "worldbody" and element.tag in ("body", "frame"):
                element.attrib.setdefault("childclass", prefix)
            elif section.tag in _WITH_CLASS or (element.tag in _ALSO_WITH_CLASS and section.tag != "default"):
                element.attrib.setdefault("class", prefix)


def _section(parent: ET.Element, tag: str, of_class: str | None = None) -> ET.Element:
    """Returns the child with a tag, and with a class where one is asked for; a new one where there is none."""
    found = next((each for each in parent.findall(tag) if each.get("class") == of_class), None)
    if found is None:
        found = ET.SubElement(parent, tag, {} if of_class is None else {"class": of_class})
    return found


def _agree(ours: ET.Element, theirs: ET.Element, *, strict: bool) -> None:
    """Takes settings of a robot into the scene's.

    Args:
        ours: the scene's.
        theirs: the robot's.
        strict: whether the robot must have all that the scene has, since its own default would be another.

    Raises:
        RobotError: they contradict each other.
    """
    for name in sorted({*theirs.attrib, *(ours.attrib if strict else ())}):
        mine, its = ours.get(name), theirs.get(name)
        if mine is not None and mine != its:
            said = "leaves it out" if its is None else f"has {its!r}"
            raise RobotError(f"<{ours.tag}> {name}: the scene has {mine!r}, the robot {said}")
        ours.set(name, str(its))
    for child in theirs:
        _agree(_section(ours, child.tag), child, strict=strict)
