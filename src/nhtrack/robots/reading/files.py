"""Finds and compiles a robot's file: MJCF, URDF, or a folder that holds one of them."""

from __future__ import annotations

import os
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco

from nhtrack.errors import RobotError, did_you_mean
from nhtrack.files.carried import read_at
from nhtrack.robots.contract import ROBOT_FILES, Hints, Refusal, RefusedRobot
from nhtrack.robots.reading.bounds import bounded_text
from nhtrack.robots.reading.missing import leave_out_missing
from nhtrack.robots.reading.source import LISTS, Source
from nhtrack.robots.reading.urdf import urdf_text

__all__ = ["find_file", "load_source"]


def find_file(path: Path) -> Path:
    """Returns the file of a robot: the path itself, or the one model in a folder.

    Raises:
        RobotError: there is none, or several and none is called `robot`.
    """
    if path.is_dir():
        models = sorted(each for each in path.iterdir() if each.suffix.lower() in ROBOT_FILES[:3])
        named = [each for each in models if each.stem.lower() == "robot"]
        found = named if len(named) == 1 else [each for each in models if is_model(each)]
        if len(found) != 1:
            names = ", ".join(each.name for each in models) or "none"
            raise RobotError(f"{path}: expected a folder with one robot; its models: {names}")
        return found[0]
    if not path.is_file():
        raise RobotError(f"{path}: no such robot file")
    return path


def is_model(file: Path) -> bool:
    """Whether a file is a model by itself, and no scene around one."""
    try:
        root = ET.parse(file).getroot()
    except (ET.ParseError, OSError):
        return False
    return root.tag in ("mujoco", "robot") and next(root.iter("include"), None) is None


def load_source(path: Path, hints: Hints) -> Source:
    """Returns the file of a robot, compiled, in the pose in which its arms are held.

    Raises:
        RobotError: it cannot be found, read or compiled.
    """
    file = find_file(path)
    spec, lines, notes = _spec(file)
    unnamed = frozenset(_name_all(spec))
    for pair in (*spec.pairs, *spec.excludes):
        spec.delete(pair)  # contacts are the scene's; a robot's file may speak of a floor that it does not have
    spec.compiler.fusestatic = spec.compiler.discardvisual = False
    _take_copies(spec)
    notes = (*notes, *leave_out_missing(spec, file))
    try:
        model = spec.compile()
    except ValueError as error:
        raise RobotError(f"{file}: MuJoCo cannot compile it: {_one_line(error)}") from error
    data = mujoco.MjData(model)
    notes = (*notes, *_hold(file, spec, model, data, hints))
    mujoco.mj_forward(model, data)
    return Source(file, hints, spec, model, data, lines, unnamed, notes)


def _spec(file: Path) -> tuple[Any, dict[tuple[str, str], int], tuple[str, ...]]:
    """Returns the elements of a file, lines of those that MuJoCo gives none for, and what was left out."""
    text = bounded_text(file)
    said = re.sub(r"<!--(?:.*?-->|.*)", "", text, flags=re.DOTALL)
    if file.suffix.lower() == ".xacro" or re.search(r"<xacro:(?!arg|property)", said):
        raise _xacro(file)
    root = re.search(r"<(\w[\w:.-]*)", said)
    if root is not None and root[1] not in ("mujoco", "mujocoinclude", "robot"):
        raise RobotError(f"{file}: expected <mujoco> (MJCF) or <robot> (URDF), got <{root[1]}>")
    try:
        if root is None or root[1] != "robot":
            # MuJoCo reads what is not quite XML, such as comments with two dashes, but goes by one ending only.
            known = file.absolute().with_suffix(".xml")
            return mujoco.MjSpec.from_file(str(known), include={known.name: text.encode()}), {}, ()
        urdf, notes = urdf_text(ET.fromstring(text), file)
        if re.search(r"\$[{(]", urdf):
            raise _xacro(file)
        return mujoco.MjSpec.from_string(urdf), _urdf_lines(text), notes
    except ET.ParseError as error:
        line, column = error.position
        raise RobotError(f"{file}:{line}:{column + 1}: no XML: {error}") from error
    except ValueError as error:
        raise RobotError(f"{file}: MuJoCo cannot read it: {_one_line(error)}") from error


def _take_copies(spec: Any) -> None:
    """Lets what is named by a full path be read at its copy; the others lie beside the copy of the robot's file."""
    for each, names in [(spec, ("meshdir", "texturedir")), *((each, ("file",)) for each in _with_files(spec))]:
        for name in names:
            if os.path.isabs(getattr(each, name)):
                setattr(each, name, str(read_at(Path(getattr(each, name)))))


def _with_files(spec: Any) -> tuple[Any, ...]:
    return (*spec.meshes, *spec.textures, *spec.hfields)


def _xacro(file: Path) -> RobotError:
    plain = file.name.removesuffix(".xacro").removesuffix(".urdf") + "_plain.urdf"
    return RobotError(
        f"{file}: a xacro file is a program that writes a URDF; run `xacro {file.name} > {plain}` where its packages "
        f"are installed and name {plain}"
    )


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())


def _urdf_lines(text: str) -> dict[tuple[str, str], int]:
    found: dict[tuple[str, str], int] = {}
    for number, line in enumerate(text.splitlines(), start=1):
        for tag, name in re.findall(r"<(link|joint)\s[^>]*?name\s*=\s*[\"']([^\"']+)", line):
            found.setdefault(("body" if tag == "link" else "joint", name), number)
    return found


def _name_all(spec: Any) -> Iterator[tuple[str, str]]:
    """Gives a name to every element that has none; yields those."""
    for kind, where in LISTS.items():
        elements = list(getattr(spec, where))
        taken, count = {each.name for each in elements}, 0
        for each in elements:
            if not each.name and not (kind == "mesh" and each.file):
                while f"{kind}_{count}" in taken:
                    count += 1
                each.name = f"{kind}_{count}"
                taken.add(each.name)
                yield kind, each.name


def _hold(file: Path, spec: Any, model: mujoco.MjModel, data: mujoco.MjData, hints: Hints) -> Iterator[str]:
    """Puts all joints into the pose in which they are held; yields which key that is."""
    keys = {model.key(k).name: k for k in range(model.nkey)}
    if hints.pose and hints.pose not in keys:
        raise RefusedRobot(file, [Refusal("", f"no key {hints.pose!r}; {did_you_mean(hints.pose, list(keys))}")])
    chosen = hints.pose or ("home" if "home" in keys else next(iter(keys), "") if len(keys) == 1 else "")
    if not (chosen or keys) or chosen not in keys:
        return
    moved = False
    for joint in range(model.njnt):
        kind, at = model.jnt_type[joint], int(model.jnt_qposadr[joint])
        if mujoco.mjtJoint(int(kind)) in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE):
            moved |= bool(abs(model.key_qpos[keys[chosen], at] - data.qpos[at]) > 1e-9)
            data.qpos[at] = model.key_qpos[keys[chosen], at]
    if moved:
        yield f"joints stand as in the key {chosen!r}"
