"""Machines that work for this one: what has to be the same there, asked before anything is run."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np

from nhtrack.errors import NhtrackError, RefusedError
from nhtrack.execution import Executor
from nhtrack.experiment.compile import compile_once
from nhtrack.files.temporary import made_folder, temporary_folder
from nhtrack.recording.versions import versions
from nhtrack.robots.contract import is_robot_file
from nhtrack.simulation.robot_models import load_robot

_PACKAGE = Path(__file__).parents[1]


class MachineError(RefusedError):
    """Machines that would not do what this one would, or not where it is looked for; nothing was run."""


class _Facts(NamedTuple):
    """What has to be the same on all machines."""

    sources: str
    versions: Mapping[str, str]
    files: Mapping[str, str]


def require_machines(executor: Executor, folder: Path | None, *trees: Any) -> None:
    """Raises where a machine that does tasks would do something else than this one, or could not keep it.

    Each machine compiles beforehand what is not compiled there.

    Args:
        executor: what is going to do tasks.
        folder: where tasks write, which all machines share; None where they do not.
        *trees: plain trees that may name files of laws and robots, by their full paths.

    Raises:
        MachineError: everything that is not the same, by machine.
    """
    if not executor.elsewhere:
        return
    files = tuple(sorted({file for tree in trees for file in files_in(tree)}))
    with nullcontext() if folder is None else made_folder(folder):  # which is no longer there where it is refused
        with nullcontext(None) if folder is None else temporary_folder(folder.absolute()) as shared:
            answers = executor.everywhere(partial(_look, files, shared))
        here, found = _facts(files), list[str]()
        for machine, (facts, writes) in answers:
            found += [f"{machine}: {fault}" for fault in _faults(here, facts)]
            if not writes:
                found.append(f"{machine}: cannot write into {folder}, which all machines share (docs/scaling.md)")
        if found:
            raise MachineError("\n".join(found))


def _look(files: tuple[str, ...], shared: Path | None) -> tuple[_Facts, bool]:
    """Returns what a machine has, and whether it can write into the folder that all share."""
    compile_once(None)
    return _facts(files), shared is None or _can_write(shared)


def _can_write(folder: Path) -> bool:
    if not folder.is_dir():  # with its name, which nobody else has
        return False
    try:
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


def _facts(files: tuple[str, ...]) -> _Facts:
    return _Facts(_sources(), versions(), {file: fingerprint(file) for file in files})


def _faults(here: _Facts, there: _Facts) -> Iterator[str]:
    """Yields what another machine has otherwise."""
    if there.sources != here.sources:
        yield "has other sources of nhtrack; install the same wheel there"
    for name, version in here.versions.items():
        if there.versions.get(name) != version:
            yield f"has {name} {there.versions.get(name, 'none')}, this machine has {version}"
    for file, fingerprint in here.files.items():
        if there.files[file] != fingerprint:
            yield f"{file} is {'not there' if not there.files[file] else 'another there'}"


def _sources() -> str:
    """Returns a hash of all of the package's modules."""
    digest = hashlib.sha256()
    for file in sorted(_PACKAGE.rglob("*.py")):
        digest.update(file.relative_to(_PACKAGE).as_posix().encode() + b"\0" + file.read_bytes() + b"\0")
    return digest.hexdigest()


def files_in(tree: Any) -> Iterator[str]:
    """Yields the files that a plain tree names by their full paths."""
    if isinstance(tree, Mapping):
        for value in tree.values():
            yield from files_in(value)
    elif isinstance(tree, list | tuple):
        for value in tree:
            yield from files_in(value)
    elif isinstance(tree, str) and os.path.isabs(tree) and "\0" not in tree and os.path.exists(tree):
        yield tree


def fingerprint(file: str) -> str:
    """Returns a hash of a file that runs depend on, of a robot's as it is compiled, meshes and all; empty of none."""
    try:
        if is_robot_file(file) and not file.endswith(".py"):
            return _compiled(load_robot(file).mjcf)
    except (NhtrackError, OSError, ValueError):
        pass  # read with hints only
    try:
        return hashlib.sha256(Path(file).read_bytes()).hexdigest()
    except OSError:
        return ""


def _compiled(mjcf: str) -> str:
    model = mujoco.MjModel.from_xml_string(mjcf)
    buffer = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return hashlib.sha256(buffer.tobytes()).hexdigest()
