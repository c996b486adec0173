"""Changes of a scenario before it is judged: `--set key=value` on the command line, keywords in Python."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path as FilePath
from typing import Any, Literal, TypeAlias, TypedDict

from ruamel.yaml.error import YAMLError

from nhtrack.config.law_sections import LawSection
from nhtrack.config.tree import Path, dotted, lookup, parse_path, plain_value
from nhtrack.errors import Fault, ScenarioError, clipped
from nhtrack.robots.contract import is_robot_file

# A law by its name, by its Python file, or written out with its gains, as a mapping or in YAML.
LawChoice: TypeAlias = str | FilePath | Mapping[str, Any] | LawSection


class ScenarioChanges(TypedDict, total=False):
    """What of a scenario may be changed by keyword; everything else by `set`.

    Attributes:
        law: a law's name, its Python file, or its section, such as `{"name": "kanayama", "k_x": 2}`.
        robot: a bundled robot, or an MJCF file.
        duration: how long the run lasts [scenario time].
        backend: `mujoco` or `ideal`.
        set: any keys with their values, `{"law.k": 5}`, or as on the command line, `["law.k=5"]`.
    """

    law: LawChoice
    robot: str | FilePath
    duration: float
    backend: Literal["mujoco", "ideal"]
    set: Mapping[str, Any] | Iterable[str]


def overrides_of(
    *,
    set: Mapping[str, Any] | Iterable[str] = (),
    law: LawChoice | None = None,
    robot: str | FilePath | None = None,
    duration: float | None = None,
    backend: str | None = None,
    seed: int | None = None,
) -> list[str]:
    """Returns changes as texts, `key=value`, that `apply_overrides` makes: those of `ScenarioChanges`, and the seed.

    What is None changes nothing. `set` comes first, so that keywords win.
    """
    given = [set] if isinstance(set, str) else set
    texts = [f"{key}={value_text(value)}" for key, value in given.items()] if isinstance(given, Mapping) else [*given]
    texts += [f"law={law}"] if _is_mapping(law) else [f"law={value_text(law)}"] if law is not None else []
    named = {"robot": robot, "duration": duration, "backend": backend, "seed": seed}
    return texts + [f"{key}={value_text(value)}" for key, value in named.items() if value is not None]


def value_text(value: Any) -> str:
    """Returns a value as YAML in one line: words as they are, all else as JSON, which is YAML."""
    if isinstance(value, LawSection):
        value = value.model_dump(mode="json")
    if isinstance(value, FilePath):
        value = str(value)
    if isinstance(value, str) and _is_word(value):
        return value
    return json.dumps(value, default=_plain)


def _is_mapping(law: object) -> bool:
    """Returns whether a law is written out as a YAML flow mapping, as it is on the command line."""
    return isinstance(law, str) and law.lstrip().startswith("{")


def _is_word(text: str) -> bool:
    """Returns whether a text is read as itself where it stands bare."""
    try:
        return bool(plain_value(text) == text)
    except YAMLError:
        return False


def _plain(value: Any) -> Any:
    """Returns an array, one of its numbers, a section or a path as plain values."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, FilePath):
        return str(value)
    raise TypeError(f"expected numbers, texts, lists and mappings, got {type(value).__name__}")


def apply_overrides(tree: Any, overrides: Iterable[str]) -> Any:
    """Returns a copy of a tree with `key.path=value` changes made, each value read as YAML.

    Sections on the way are made where they are missing; a list item must exist. A law may be named: `law=kanayama` is
    that law with its defaults, or the file's own where that has this name, and `law=my_law.py` the law of a file. Files
    of laws and robots start from the working directory.

    Raises:
        ScenarioError: a change that is not of that form, or whose place does not exist.
    """
    changed, faults = _copied(tree), list[Fault]()
    for text in overrides:
        try:
            path, value = parse_override(text)
            _assign(changed, path, _meant(path, value, changed))
        except ValueError as error:
            faults.append(Fault(0, 0, "", f"--set {clipped(text)}: {error}"))
    if faults:
        raise ScenarioError("command line", faults)
    return changed


def _copied(tree: Any) -> Any:
    """Returns a copy of a tree of plain values."""
    if isinstance(tree, dict):
        return {key: _copied(value) for key, value in tree.items()}
    return [_copied(value) for value in tree] if isinstance(tree, list) else tree


def parse_override(text: str) -> tuple[Path, Any]:
    """Returns the path and the value of a `key.path=value` text.

    Raises:
        ValueError: not of that form, or a value that is not YAML.
    """
    key, equals, value = text.partition("=")
    if not equals:
        raise ValueError("expected key.path=value")
    path = parse_path(key.strip())
    try:
        return path, plain_value(value)
    except YAMLError:
        raise ValueError(f"{clipped(value)!r} is not a YAML value") from None


def _meant(path: Path, value: Any, tree: Any) -> Any:
    """Returns a value as a file would have it: a law by its name or file as a section, files by their full paths."""
    if path == ("law",) and isinstance(value, str):
        if value.endswith(".py"):
            return {"file": _from_here(value)}
        own = lookup(tree, ("law",))
        return own if isinstance(own, dict) and own.get("name") == value else {"name": value}
    if path == ("law",) and isinstance(value, dict) and isinstance(value.get("file"), str):
        return {**value, "file": _from_here(value["file"])}
    if path == ("robot",) and isinstance(value, dict) and is_robot_file(str(value.get("file", ""))):
        return {**value, "file": _from_here(value["file"])}
    names_robot = path in (("robot",), ("robot", "file")) and isinstance(value, str) and is_robot_file(value)
    if path == ("law", "file") or names_robot:
        return _from_here(value)
    return value


def _from_here(value: Any) -> Any:
    """Returns the full path of a file, from the working directory."""
    return str(FilePath(value).resolve()) if isinstance(value, str) and value else value


def _assign(tree: Any, path: Path, value: Any) -> None:
    """Sets the value at a path of a tree, making sections on the way."""
    node = tree
    for i, step in enumerate(path):
        last = i == len(path) - 1
        where = dotted(path[:i]) or "the scenario"
        if isinstance(step, int):
            if not isinstance(node, list):
                raise ValueError(f"{where} is not a list")
            if step >= len(node):
                raise ValueError(f"{where} has {len(node)} items, counted from 0")
        elif not isinstance(node, dict):
            raise ValueError(f"{where} is not a section with keys")
        elif not last and not isinstance(node.get(step), (dict, list)):
            node[step] = {}
        if last:
            node[step] = value
        else:
            node = node[step]
