"""A scenario to start from, with a robot that was inspected."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from nhtrack import assets
from nhtrack.config.starter import pace_within, starter_with
from nhtrack.errors import RefusedError
from nhtrack.experiment.limits import agile_limits
from nhtrack.files.atomic import atomic_path
from nhtrack.ground import Ground

if TYPE_CHECKING:
    from nhtrack.studies.inspect.result import Inspection

__all__ = ["write_scenario"]


def write_scenario(found: Inspection, target: Path) -> Path:
    """Writes a commented scenario with a robot whose leader leaves its follower room to catch up, and returns its file.

    Raises:
        RefusedError: the file exists, or there is no motion within friction and motors.
    """
    if target.exists():
        raise RefusedError(f"{target} exists; choose another name, or remove it")
    if found.limits is None:
        raise RefusedError("no scenario to start from: " + "; ".join(found.remarks))
    file = found.robot.file
    if file not in assets.robots():
        file = Path(os.path.relpath(Path(file).resolve(), target.resolve().parent)).as_posix()
        file = file if "/" in file or Path(file).suffix else f"./{file}"
    limits = agile_limits(found.drive, Ground(found.friction), found.utilisation)
    pace = pace_within(limits, found.friction, found.utilisation)
    text = starter_with(target.stem, found.robot.model_copy(update={"file": file}), pace)
    with atomic_path(target) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return target
