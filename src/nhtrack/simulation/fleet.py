"""Many robots from the text of one: a scene's MJCF, and its compiled model in a time that hardly grows faster."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import groupby
from xml.sax.saxutils import escape

import mujoco

__all__ = ["ROBOT", "Blueprint", "Robot", "compile_blueprint", "make_blueprint"]

ROBOT, _COLOUR = "__robot__", "__colour__"  # stand for a robot's name and its colour in the text of the one
_SHARED = "robot"  # prefix of the materials that all robots share

# MuJoCo lists all of a scene anew for every element it reads into a body (mjCModel::MakeTreeLists), a cost that grows
# with the square of the scene. So a large one is read in groups of so many robots, which are attached to the arena.
_GROUP = 64
_WORTHWHILE = 8  # robots in a group, on average, from which attaching it is cheaper than reading on
# Parts of a robot that are known to come out of attached groups as they come out of one text.
_GROUPED = {"asset", "worldbody", "actuator", "sensor", "custom", "contact", "equality", "tendon"}


@dataclass(frozen=True)
class Robot:
    """A robot's name, and the colour of its accents as red, green, blue and opacity."""

    name: str
    colour: tuple[float, float, float, float]


@dataclass(frozen=True)
class _Section:
    """A top-level element of MJCF: its text before and after what robots have in it, together and each for itself."""

    tag: str
    head: str
    once: str = ""
    rows: str = ""
    tail: str = ""

    def repeated(self, robots: tuple[Robot, ...], skipped: int = 0) -> str:
        """Returns the rows of some robots, their names without the first `skipped` letters."""
        names = (escape(robot.name[skipped:], {'"': "&quot;"}) for robot in robots)
        return "".join(
            _in_colour(self.rows.replace(ROBOT + "/", name + "/"), robot)
            for name, robot in zip(names, robots, strict=True)
        )


@dataclass(frozen=True)
class Blueprint:
    """A scene's MJCF with one robot in it, and the robots that it stands for.

    Attributes:
        sections: the top-level elements.
        robots: those with a body, in order.
        assets: the files that the text speaks of, by name.
    """

    sections: tuple[_Section, ...] = field(repr=False)
    robots: tuple[Robot, ...]
    assets: Mapping[str, bytes] = field(repr=False)

    @property
    def xml(self) -> str:
        """The scene's MJCF."""
        return _document(each.head + each.once + each.repeated(self.robots) + each.tail for each in self.sections)

    @property
    def arena(self) -> str:
        """The MJCF of the scene without robots."""
        return _document(each.head + each.tail for each in self.sections)

    def groups(self) -> Iterator[tuple[Robot, ...]]:
        """Yields the robots in order, in groups whose names begin with one letter."""
        for _, run in groupby(self.robots, key=lambda robot: robot.name[:1]):
            alike = tuple(run)
            yield from (alike[k : k + _GROUP] for k in range(0, len(alike), _GROUP))

    def group_xml(self, robots: tuple[Robot, ...], *, is_first: bool) -> str:
        """Returns the MJCF of a group alone, in a frame, names without their first letter.

        Args:
            robots: the group.
            is_first: whether it is the first whose names begin so, and brings what all of these share.
        """
        parts = []
        for each in self.sections:
            if not each.rows and not each.once:
                parts.append(each.head if each.tag not in _GROUPED else "")  # options and classes, as the scene's
                continue
            inner = (each.once if is_first else "") + each.repeated(robots, skipped=1)
            inner = f"<frame>{inner}</frame>" if each.tag == "worldbody" else inner
            parts.append(f"<{each.tag}>{inner}</{each.tag}>")
        return _document(parts)

    @property
    def is_read_in_groups(self) -> bool:
        """Whether groups of robots are compiled alike and sooner than one text."""
        simple = not self.assets and all(each.tag in _GROUPED for each in self.sections if each.rows)
        large = len(self.robots) > _GROUP
        return simple and large and len(self.robots) >= _WORTHWHILE * sum(1 for _ in self.groups())


def make_blueprint(
    xml: str, assets: Mapping[str, bytes], robots: tuple[Robot, ...], accent: str, *, share_materials: bool = False
) -> Blueprint:
    """Returns the blueprint of a scene.

    Args:
        xml: its MJCF with one robot, called `ROBOT`.
        assets: the files that the text speaks of, by name.
        robots: those that the one stands for.
        accent: the robot's material that has each robot's colour.
        share_materials: whether robots have one set of materials, with an accent of each colour.
    """
    root = ET.fromstring(xml)
    for material in root.iterfind(f"asset/material[@name='{ROBOT}/{accent}']"):
        material.set("rgba", _COLOUR)
    _drop_classes(root)
    once = _share_materials(root, robots) if share_materials else ""
    sections = (_section(element, once if element.tag == "asset" else "") for element in root)
    return Blueprint(tuple(sections), robots, assets)


def compile_blueprint(blueprint: Blueprint) -> mujoco.MjModel:
    """Returns the compiled model of a scene.

    The marker of a virtual root stands after the robots, in a scene that is read in groups before them.

    Raises:
        ValueError: MuJoCo cannot compile it.
    """
    if not blueprint.is_read_in_groups:
        return mujoco.MjModel.from_xml_string(blueprint.xml, dict(blueprint.assets))
    scene = mujoco.MjSpec.from_string(blueprint.arena)
    letters: set[str] = set()
    for robots in blueprint.groups():
        letter = robots[0].name[:1]
        group = mujoco.MjSpec.from_string(blueprint.group_xml(robots, is_first=letter not in letters))
        # The names' first letter, which the group's text leaves out: MuJoCo warns of attaching without a prefix.
        scene.worldbody.attach_frame(group.worldbody.first_frame(), letter, "")
        letters.add(letter)
    return scene.compile()


def _document(sections: Iterable[str]) -> str:
    return '<mujoco model="arena">\n  ' + "".join(sections) + "</mujoco>\n"


def _section(element: ET.Element, once: str) -> _Section:
    rows = [ET.tostring(child, encoding="unicode") for child in element]
    of_robot = [ROBOT in row for row in rows]
    if not any(of_robot) and not once:
        return _Section(element.tag, ET.tostring(element, encoding="unicode"))
    first = of_robot.index(True) if any(of_robot) else len(rows)
    own = "".join(row for row, its in zip(rows, of_robot, strict=True) if its)
    after = "".join(row for row, its in zip(rows[first:], of_robot[first:], strict=True) if not its)
    space = element.text or ""
    head = f"<{element.tag}>{space}{''.join(rows[:first])}"
    return _Section(element.tag, head, once, own, f"{after}</{element.tag}>{element.tail}")


def _drop_classes(root: ET.Element) -> None:
    """Takes out the robot's default class, which is empty in its standard form, and the names of it.

    MuJoCo would read one for each robot.
    """
    for classes in root.findall("default"):
        for own in classes.findall(f"default[@class='{ROBOT}/']"):
            classes.remove(own)
    for element in root.iter():
        for name in ("class", "childclass"):
            if element.get(name, "").startswith(f"{ROBOT}/"):
                del element.attrib[name]


def _share_materials(root: ET.Element, robots: tuple[Robot, ...]) -> str:
    """Takes the robot's materials out of a scene and returns them as text, the accent in each colour of the robots.

    A robot whose materials have textures of its own keeps them.
    """
    assets = root.find("asset")
    own = (
        [] if assets is None else [each for each in assets if each.tag == "material" and ROBOT in each.get("name", "")]
    )
    if assets is None or any(ROBOT in each.get("texture", "") or len(each) for each in own):
        return ""
    names = {each.attrib["name"]: each.attrib["name"].replace(ROBOT, _SHARED, 1) for each in own}
    for each in own:
        assets.remove(each)
        if each.get("rgba") == _COLOUR:
            names[each.attrib["name"]] += " " + _COLOUR
        each.set("name", names[each.attrib["name"]])
    for element in root.iter():
        if element.get("material") in names:
            element.set("material", names[element.attrib["material"]])
    rows = [ET.tostring(each, encoding="unicode") for each in own]
    return "".join(dict.fromkeys(_in_colour(row, robot) for row in rows for robot in robots))


def _in_colour(text: str, robot: Robot) -> str:
    return text.replace(_COLOUR, " ".join(f"{value:.17g}" for value in robot.colour))
