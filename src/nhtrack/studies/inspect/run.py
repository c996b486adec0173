"""Reads a robot's file and says what was found."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import cast

from nhtrack.config.robot_section import FORWARD, Forward, RobotSection
from nhtrack.errors import FeasibilityError, RobotError
from nhtrack.experiment.limits import motion_limits
from nhtrack.ground import Ground
from nhtrack.simulation.guard import examine
from nhtrack.simulation.robot_models import read_robot
from nhtrack.simulation.spec import SceneSpec
from nhtrack.studies.inspect.result import Inspection


def inspect(
    robot: str | Path, *, wheels: Iterable[str] = (), casters: Iterable[str] = (), forward: str = "", pose: str = "",
    friction: float = 1.0, utilisation: float = 0.5,
) -> Inspection:  # fmt: skip
    """Returns what is read from a robot's file: elements, geometry, masses, reduced model, limits, guard, drawing.

    Args:
        robot: a bundled robot, an MJCF or URDF file, or a folder with one.
        wheels: joints of the two driven wheels, for a file without actuators.
        casters: joints of wheels that are not driven and slide on the floor as ball casters do.
        forward: the axis of the file's base that points ahead: `x`, `-x`, `y`, `-y`; empty to read it.
        pose: the key whose joint angles arms are held at.
        friction: of the level floor that limits of motion are for [1].
        utilisation: share of it that wheels may use, in (0, 1].

    Raises:
        RefusedRobot: it cannot be driven: every reason, with its element.
        RobotError: no such robot, or none that can be compiled.
    """
    if forward not in FORWARD:
        raise RobotError(f"forward: expected one of {', '.join(FORWARD[1:])}, got {forward!r}")
    section = RobotSection(
        file=str(robot), wheels=tuple(wheels), casters=tuple(casters), forward=cast(Forward, forward), pose=pose
    )
    found = read_robot(SceneSpec(("robot",), section.file, hints=section.hints))
    remarks = list[str]()
    try:
        limits = motion_limits(found.plant, Ground(friction), utilisation)
    except FeasibilityError as error:
        limits = None
        remarks.append(f"no limits of motion: {error}")
    path = found.reading.file.resolve()
    name = path.parent.name if path.name == "robot.xml" else path.stem
    guard = examine(found.reading)
    return Inspection(name, section, found.reading, guard, limits, friction, utilisation, tuple(remarks))
