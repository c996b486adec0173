"""The files that a scenario or campaign names: robots, laws, the leader's input."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path as FilePath
from typing import Any

from pydantic import ValidationError

from nhtrack import assets
from nhtrack.config.checks import INPUT
from nhtrack.config.tree import Path, lookup
from nhtrack.references import FileFaults, ReferenceInputError, input_kind
from nhtrack.robots.contract import is_robot_file
from nhtrack.section import Finding


def with_named_files(tree: Any, directory: FilePath, problems: list[Finding]) -> Any:
    """Returns the tree with the files it names found: robot and law by full paths, those of the input read."""
    if not isinstance(tree, dict):
        return tree
    resolved = {**tree, **_law_files(tree, directory), **_robot_file(tree, directory)}
    if isinstance(lookup(tree, INPUT), dict):
        resolved["leader"] = _with_start(_with_input(tree["leader"], ("leader",), directory, problems))
    if isinstance(families := tree.get("families"), list):
        resolved["families"] = [
            _with_input(family, ("families", i), directory, problems) for i, family in enumerate(families)
        ]
    return resolved


def _with_input(section: Any, at: Path, directory: FilePath, problems: list[Finding]) -> Any:
    """Returns a raw section with what its input's file holds, if it has an input and this a file."""
    given = lookup(section, ("input",))
    if not isinstance(given, dict):
        return section
    kind = input_kind(given)
    try:
        return {**section, "input": kind.resolved(given, directory)}
    except FileFaults as found:
        problems += [((*at, "input", kind.key), fault) for fault in found.faults]
        return section


def _with_start(leader: Mapping[str, Any]) -> Mapping[str, Any]:
    """Returns a leader's raw section with the start that its input asks for, where it gives none of its own."""
    try:
        start = input_kind(leader["input"]).model_validate(leader["input"]).start()
    except (ValidationError, ReferenceInputError, TypeError):
        return leader  # told where the input is judged
    if start is None or not isinstance(given := leader.get("start", {}), Mapping):
        return leader
    return {**leader, "start": {"pose": list(start.pose or (0.0, 0.0, 0.0)), "twist": list(start.twist), **given}}


def _robot_file(tree: Mapping[str, Any], directory: FilePath) -> dict[str, Any]:
    """Returns the robot of a tree with the full path of its file, where it is one of the user's own."""
    robot = tree.get("robot")
    file = robot.get("file") if isinstance(robot, dict) else robot
    if not isinstance(file, str) or file in assets.robots() or not is_robot_file(file):
        return {}
    found = str((directory / file).resolve())
    return {"robot": {**robot, "file": found} if isinstance(robot, dict) else found}


def _law_files(tree: Mapping[str, Any], directory: FilePath) -> dict[str, Any]:
    """Returns the laws of a tree that are files, with their full paths: `law` of a scenario, `laws` of a campaign."""

    def found(law: Any) -> Any:
        if isinstance(law, dict) and isinstance(law.get("file"), str) and law["file"]:
            return {**law, "file": str((directory / law["file"]).resolve())}
        return law

    several = tree.get("laws")
    resolved = {"law": found(tree["law"])} if "law" in tree else {}
    if isinstance(several, dict):
        resolved["laws"] = {label: found(law) for label, law in several.items()}
    return resolved
