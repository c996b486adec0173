"""A scenario to start from, with a robot that was inspected."""

from __future__ import annotations

import os
from pathlib import Path

from nhtrack import assets
from nhtrack.config.robot_section import RobotSection
from nhtrack.config.starter import pace_within, starter_with
from nhtrack.errors import RefusedError
from nhtrack.experiment.limits import agile_limits
from nhtrack.files.atomic import atomic_path
from nhtrack.ground import Ground
from nhtrack.robots.diff_drive import DiffDrive

__all__ = ["write_scenario"]


def write_scenario(
    robot: RobotSection, drive: DiffDrive, target: Path, friction: float, utilisation: float
) -> Path:
    """Writes a commented scenario with a robot whose leader leaves its follower room to catch up, and returns its file.

    Args:
        robot: which, as a scenario has it; its file is told from where the scenario stands.
        drive: its reduced model.
        target: the file to write.
        friction: of the level floor [1].
        utilisation: share of it that may be used [1].

    Raises:
        RefusedError: the file exists.
    """
    if target.exists():
        raise RefusedError(f"{target} exists; choose another name, or remove it")
    file = robot.file
    if file not in assets.robots():
        file = Path(os.path.relpath(Path(file).resolve(), target.resolve().parent)).as_posix()
        file = file if "/" in file or Path(file).suffix else f"./{file}"
    limits = agile_limits(drive, Ground(friction), utilisation)
    pace = pace_within(limits, friction, utilisation)
    text = starter_with(target.stem, robot.model_copy(update={"file": file}), pace)
    with atomic_path(target) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return target
