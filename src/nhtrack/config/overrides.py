"""Changes of a file from the command line: `law.kp=3`."""

from __future__ import annotations

import copy
from collections.abc import Iterable
from pathlib import Path as FilePath
from typing import Any

from ruamel.yaml.error import YAMLError

from nhtrack.config.tree import Path, dotted, parse_path, plain_value
from nhtrack.errors import Fault, ScenarioError


def apply_overrides(tree: Any, overrides: Iterable[str]) -> Any:
    """Returns a copy of a tree with `key.path=value` changes made, each value read as YAML.

    Sections on the way are made where they are missing; a list item must exist. The file of a law starts from the
    working directory.

    Raises:
        ScenarioError: a change that is not of that form, or whose place does not exist.
    """
    changed, faults = copy.deepcopy(tree), list[Fault]()
    for text in overrides:
        try:
            path, value = parse_override(text)
            _assign(changed, path, _from_here(path, value))
        except ValueError as error:
            faults.append(Fault(0, 0, "", f"--set {text}: {error}"))
    if faults:
        raise ScenarioError("command line", faults)
    return changed


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
        raise ValueError(f"{value!r} is not a YAML value") from None


def _from_here(path: Path, value: Any) -> Any:
    """Returns a value with the file of a law, if it is one, by its full path."""
    if path == ("law", "file") and isinstance(value, str) and value:
        return str(FilePath(value).resolve())
    if path == ("law",) and isinstance(value, dict) and "file" in value:
        return {**value, "file": _from_here(("law", "file"), value["file"])}
    return value


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
