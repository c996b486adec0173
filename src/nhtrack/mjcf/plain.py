"""MJCF as a tree of elements, with the names of `dm_control.mjcf` for what one does with it.

Text is kept as it was read, and numbers are written so that they are read back to the last bit.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from nhtrack.mjcf.attach import attached
from nhtrack.mjcf.files import read, read_text

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["Element", "Root", "from_path", "from_text"]

# Elements whose children are asked for by their tag, and made where there are none; all of them, or some.
_PARENTS: dict[str, frozenset[str] | None] = {
    "mujoco": None,
    "visual": None,
    "default": None,
    "option": frozenset({"flag"}),
    "compiler": frozenset({"lengthrange"}),
}
_SECTIONS = ("actuator", "sensor", "equality", "tendon")  # whose elements are one kind, whatever their tags
_TAGS = {"joint": ("joint", "freejoint")}  # of a kind, where there are several


def from_path(file: Path) -> Root:
    """Returns the root element of an MJCF file.

    Args:
        file: an MJCF file; what it includes is read with it.

    Raises:
        RobotError: it is no MJCF, or has elements that cannot be attached under another name.
        OSError: the file, or one that it speaks of, cannot be read.
    """
    return Root(*read(file))


def from_text(text: str) -> Root:
    """Returns the root element of an MJCF text, whose files have full paths; raises as `from_path`."""
    return Root(*read_text(text))


class Element:
    """An element of MJCF, whose attributes are Python's: text, a number, an array of them, or None where there is none.

    Children of `mujoco`, `visual`, `default` and some others are found so, too: `root.option.flag`.
    """

    def __init__(self, node: ET.Element, parent: Element) -> None:
        self.__dict__.update(node=node, parent=parent, root=parent.__dict__["root"])

    @property
    def tag(self) -> str:
        """Its name in MJCF."""
        return str(self.node.tag)

    @property
    def dclass(self) -> Element | None:
        """The default class that it names itself, or None."""
        name = self.node.get("class")
        classes = (each for each in self.root.walk() if each.tag == "default" and name is not None)
        return next((each for each in classes if each.node.get("class") == name), None)

    def walk(self) -> Iterator[Element]:
        """Yields the element and all below it."""
        yield self
        for node in self.node:
            yield from Element(node, self).walk()

    def add(self, tag: str, **attributes: Any) -> Element:
        """Returns a new last child.

        Args:
            tag: its name in MJCF.
            attributes: text, numbers, truth values, arrays, or elements, whose name is written.
        """
        child = Element(ET.SubElement(self.node, tag), self)
        for name, value in attributes.items():
            setattr(child, name, value)
        return child

    def get_children(self, tag: str) -> Any:
        """Returns the children with a tag; of `freejoint` the one that there may be, or None."""
        found = [Element(node, self) for node in self.node.findall(tag)]
        return next(iter(found), None) if tag == "freejoint" else found

    def remove(self) -> None:
        """Takes the element out of its parent."""
        self.parent.node.remove(self.node)

    def attach(self, robot: Root) -> Element:
        """Returns a new body in which all of a robot hangs, its names after that of its model and a slash.

        Args:
            robot: the root of its MJCF; it may still be edited.
        """
        frame = self.add("body")
        self.root.robots.append((frame.node, robot))
        return frame

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        name = name.rstrip("_")
        tags = _PARENTS.get(self.tag, frozenset())
        if name in ("model", "class") or (tags is not None and name not in tags):
            return _value(self.node.get(name))
        child = self.node.find(name)
        return Element(ET.SubElement(self.node, name) if child is None else child, self)

    def __setattr__(self, name: str, value: Any) -> None:
        self.node.set("class" if name == "dclass" else name.rstrip("_"), _text(value))


class Root(Element):
    """The element `mujoco`, the files that it speaks of and the robots that hang in it."""

    def __init__(self, node: ET.Element, assets: dict[str, bytes]) -> None:
        self.__dict__.update(node=node, root=self, assets=assets, robots=[])

    def find(self, kind: str, name: str) -> Element | None:
        """Returns the element that has a name among those of a kind, or None.

        Args:
            kind: its tag, or the section that holds it: `actuator`, `sensor`, `equality`, `tendon`.
            name: its name.
        """
        if kind in _SECTIONS:
            among = (Element(node, getattr(self, kind)) for node in self.node.findall(f"{kind}/*"))
        else:
            tags = _TAGS.get(kind, (kind,))
            among = (each for part in (self.worldbody, self.asset) for each in part.walk() if each.tag in tags)
        return next((each for each in among if each.node.get("name") == name), None)

    def get_assets(self) -> dict[str, bytes]:
        """Returns the files that the text speaks of, by name."""
        roots = (self, *(robot for _, robot in self.robots))
        return {name: data for root in roots for name, data in root.assets.items()}

    def to_xml_string(self) -> str:
        """Returns the MJCF, with the robots that hang in it.

        Raises:
            RobotError: settings of a robot and of the scene contradict each other.
        """
        robots = [(frame, robot.node) for frame, robot in self.robots]
        return ET.tostring(attached(self.node, robots), encoding="unicode")


def _value(text: str | None) -> Any:
    if text is None:
        return None
    try:
        numbers = [float(word) for word in text.split()]
    except ValueError:
        return text
    return numbers[0] if len(numbers) == 1 else np.array(numbers)


def _text(value: Any) -> str:
    if isinstance(value, Element):
        return str(value.node.attrib["name"])
    if isinstance(value, str):
        return value
    if isinstance(value, bool):
        return "true" if value else "false"
    return " ".join(f"{number:.17g}" for number in np.atleast_1d(value))
