"""A YAML file as a plain tree that remembers where every key stands, and the paths into such trees.

The file is composed to ruamel's node graph and walked here, rather than constructed to objects, so that
duplicate keys, anchors and tags are faults with a place, and all of them are found at once.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from ruamel.yaml import YAML
from ruamel.yaml.composer import MaxDepthExceededError
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from nhtrack.errors import Fault

Path: TypeAlias = tuple[str | int, ...]  # keys of mappings and indices of lists, from the root
Position: TypeAlias = tuple[int, int]  # one-based line and column

_PLAIN_TAGS = {f"tag:yaml.org,2002:{name}" for name in ("null", "bool", "int", "float", "str", "map", "seq")}
DEEPEST = 40  # lists and sections within each other; keeps a hostile text from exhausting Python's stack
_STEP = re.compile(r"(?:^|\.)(?P<key>[^.\[\]]+)|\[(?P<index>\d+)\]")


# What has no place in a name of a file or on a screen: controls other than tabs and line ends, halves of letters.
_NUMBER = re.compile(r"-?[0-9]{1,300}(?:\.[0-9]+)?(?:[eE][-+]?[0-9]{1,3})?")
_UNWRITABLE = re.compile(r"[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\U0010ffff]")


@dataclass
class Document:
    """A parsed file.

    Attributes:
        tree: plain dicts, lists and scalars.
        positions: where each key and list item stands; the root is ().
        faults: what was wrong with the YAML itself.
        unreadable: where None stands for something that could not be read.
    """

    tree: Any = None
    positions: dict[Path, Position] = field(default_factory=dict)
    faults: list[Fault] = field(default_factory=list)
    unreadable: set[Path] = field(default_factory=set)


def dotted(path: Iterable[str | int]) -> str:
    """Returns a path as people write it: `followers[0].start.pose`."""
    text = ""
    for step in path:
        text += f"[{step}]" if isinstance(step, int) else f".{step}" if text else str(step)
    return text


def parse_path(text: str) -> Path:
    """Returns the path of its dotted form.

    Raises:
        ValueError: not a dotted path.
    """
    steps: list[str | int] = []
    end = 0
    for match in _STEP.finditer(text):
        if match.start() != end:
            break
        end = match.end()
        steps.append(int(match["index"]) if match["key"] is None else match["key"].strip())
    if not steps or end != len(text):
        raise ValueError(f"expected a key such as law.kp or followers[0].start.pose, got {text!r}")
    return tuple(steps)


def lookup(tree: Any, path: Iterable[str | int], default: Any = None) -> Any:
    """Returns what stands at a path of a tree, or `default`."""
    for step in path:
        if isinstance(tree, Mapping) and step in tree:
            tree = tree[step]
        elif isinstance(tree, list) and isinstance(step, int) and 0 <= step < len(tree):
            tree = tree[step]
        else:
            return default
    return tree


def parse_yaml(text: str) -> Document:
    """Returns the tree of a YAML 1.2 text with the place of every key; what is wrong is in its `faults`."""
    yaml = YAML(typ="safe", pure=True)
    yaml.max_depth = DEEPEST
    yaml.composer.warn_double_anchors = False  # they are a fault by themselves
    document = Document()
    try:
        root = yaml.compose(text)
    except YAMLError as error:
        document.faults.append(_syntax_fault(text, error))
        return document
    if root is None:
        document.faults.append(Fault(0, 0, "", "the file is empty; `nhtrack init` writes a scenario to start from"))
        return document
    document.positions[()] = (1, 1)
    document.tree = _Walk(yaml, document).plain(root, ())
    return document


class _Walk:
    """Turns composed nodes into plain values, noting positions and faults in a document."""

    def __init__(self, yaml: YAML, document: Document) -> None:
        self._yaml, self._document, self._seen = yaml, document, set[int]()

    def plain(self, node: Node, path: Path) -> Any:
        if id(node) in self._seen:
            # ruamel hands out the anchored node itself, so the place is the nearest key's.
            positions = self._document.positions
            position = next(positions[here] for here in ancestors(path) if here in positions)
            message = "aliases (*name) are not part of a scenario; write the value out"
            return self._unreadable(position, path, message)
        self._seen.add(id(node))
        if str(node.tag) not in _PLAIN_TAGS:
            message = f"a scenario holds text, numbers, lists and sections, not {_short_tag(node)}"
            return self._unreadable(_position(node), path, message)
        if isinstance(node, MappingNode):
            return self._mapping(node, path)
        if isinstance(node, SequenceNode):
            return self._sequence(node, path)
        try:
            value = self._yaml.constructor.construct_object(node, deep=True)
        except (YAMLError, ValueError, LookupError):  # of a tag that its text does not fit
            return self._unreadable(_position(node), path, f"{node.value!r} cannot be read as {_short_tag(node)}")
        if isinstance(value, str) and (strange := _UNWRITABLE.search(value)):
            message = f"a text holds letters, not the control character {strange.group()!r}"
            return self._unreadable(_position(node), path, message)
        return value

    def _mapping(self, node: MappingNode, path: Path) -> dict[str, Any]:
        tree: dict[str, Any] = {}
        for key_node, value_node in node.value:
            if not isinstance(key_node, ScalarNode):
                self._fault(_position(key_node), path, "a key must be a plain word")
                continue
            here = (*path, str(key_node.value))
            if here[-1] in tree:
                first = self._document.positions[here][0]
                message = f"key is given twice, first on line {first}; keep one"
                self._fault(_position(key_node), here, message)
            else:
                self._document.positions[here] = _position(key_node)
                tree[str(here[-1])] = self.plain(value_node, here)
        return tree

    def _sequence(self, node: SequenceNode, path: Path) -> list[Any]:
        for i, item in enumerate(node.value):
            if id(item) not in self._seen:
                self._document.positions[*path, i] = _position(item)
        return [self.plain(item, (*path, i)) for i, item in enumerate(node.value)]

    def _unreadable(self, position: Position, path: Path, message: str) -> None:
        """Notes that nothing stands at a path because it cannot be read."""
        self._fault(position, path, message)
        self._document.unreadable.add(path)

    def _fault(self, position: Position, path: Path, message: str) -> None:
        self._document.faults.append(Fault(*position, dotted(path), message))


def _position(node: Node) -> Position:
    return node.start_mark.line + 1, node.start_mark.column + 1


def _short_tag(node: Node) -> str:
    return str(node.tag).replace("tag:yaml.org,2002:", "!!")


def _syntax_fault(text: str, error: YAMLError) -> Fault:
    """Returns the fault of a text that is not YAML, at the mark the parser left."""
    if isinstance(error, MarkedYAMLError):
        mark = error.problem_mark or error.context_mark
        detail = " ".join(part for part in (error.context, error.problem) if part)
        if isinstance(error, MaxDepthExceededError):
            detail = f"lists and sections within each other, more than {DEEPEST} deep"
        line, column = (mark.line + 1, mark.column + 1) if mark else (0, 0)
        return Fault(line, column, "", f"not valid YAML: {detail}")
    position = int(getattr(error, "position", 0))
    line = text.count("\n", 0, position) + 1
    column = position - (text.rfind("\n", 0, position) + 1) + 1
    return Fault(line, column, "", "not valid YAML: a character that text files do not hold")


def plain_value(text: str) -> Any:
    """Returns the plain value of a YAML text, such as one given on the command line.

    Raises:
        YAMLError: not YAML, or more than plain values.
    """
    if not text.strip():
        return None
    if _NUMBER.fullmatch(text):  # as YAML reads it, in a thousandth of the time
        return int(text) if text.removeprefix("-").isdigit() else float(text)
    document = parse_yaml(text)
    if document.faults:
        raise YAMLError(document.faults[0].message)
    return document.tree


def ancestors(path: Path) -> Iterator[Path]:
    """Yields a path and every shorter one, down to the root ()."""
    for length in range(len(path), -1, -1):
        yield path[:length]
