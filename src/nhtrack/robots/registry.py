"""The kinds of robots there are: those of the folders of this room whose module `reading` defines one."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from pkgutil import iter_modules

from nhtrack.robots.contract import Hints, RefusedRobot
from nhtrack.robots.kind import Kind, Reading
from nhtrack.robots.reading.files import load_source

_ROOM = __name__.rpartition(".")[0]


@cache
def robot_kinds() -> tuple[Kind, ...]:
    """Returns the kinds, by name."""
    folders = [module.name for module in iter_modules(import_module(_ROOM).__path__) if module.ispkg]
    modules = [f"{_ROOM}.{folder}.reading" for folder in sorted(folders)]
    found = [getattr(import_module(name), "KIND", None) for name in modules if find_spec(name)]
    return tuple(kind for kind in found if isinstance(kind, Kind))


def read_file(file: Path, hints: Hints | None = None) -> Reading:
    """Returns the robot of a file as the first kind reads it that knows it.

    Args:
        file: an MJCF or URDF file, or a folder with one.
        hints: what it cannot say itself.

    Raises:
        RefusedRobot: no kind knows it; all reasons of the kind that has the fewest.
        RobotError: it cannot be found or compiled.
    """
    source, refused = load_source(file, hints or Hints()), list[RefusedRobot]()
    for kind in robot_kinds():
        try:
            return kind.read(source)
        except RefusedRobot as error:
            refused.append(error)
    raise min(refused, key=lambda error: len(error.refusals))
