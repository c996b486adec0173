"""Whether a scenario's robot can be found, driven, and stand where it is put."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path as FilePath
from typing import Any

from nhtrack import assets
from nhtrack.config.checks import Finding, is_robot_file
from nhtrack.config.scenario import Scenario
from nhtrack.config.tree import lookup
from nhtrack.errors import RobotError, did_you_mean
from nhtrack.experiment.stability import stability_findings


def robot_findings(tree: Mapping[str, Any], directory: FilePath) -> Iterator[Finding]:
    """Yields why a tree's robot cannot be found, driven, or stand on its ground."""
    robot = lookup(tree, ("robot",), Scenario.model_fields["robot"].default)
    if not isinstance(robot, str) or not robot:
        return
    if robot in assets.robots():
        yield from stability_findings(tree, robot)
    elif not is_robot_file(robot):
        yield (
            ("robot",),
            f"no robot {robot!r}; {did_you_mean(robot, assets.robots())}, or a path to an .xml file",
        )
    elif not (directory / robot).is_file():
        yield ("robot",), f"no MJCF file {str(directory / robot)!r}"
    else:
        yield from _robot_file_findings(directory / robot)
        yield from stability_findings(tree, str(directory / robot))


def _robot_file_findings(path: FilePath) -> Iterator[Finding]:
    """Yields why an MJCF file is not a differential-drive robot."""
    # MuJoCo takes a while to import, and only a robot of the user's own needs it here.
    from nhtrack.robots.diff_drive import identify
    from nhtrack.simulation.scene import load_robot

    try:
        identify(load_robot(str(path)))
    except RobotError as error:
        yield ("robot",), " ".join(str(error).split())
