"""Reads a robot's file and says what was found."""

from __future__ import annotations

from pathlib import Path

from nhtrack.errors import FeasibilityError
from nhtrack.experiment.limits import motion_limits
from nhtrack.ground import Ground
from nhtrack.simulation.robot_models import load_robot
from nhtrack.studies.inspect.result import Inspection


def inspect(robot: str | Path, *, friction: float = 1.0, utilisation: float = 0.5) -> Inspection:
    """Returns what is read from a robot's file: geometry, masses, reduced model, limits of motors and of motion.

    Args:
        robot: a bundled robot, or an MJCF file.
        friction: of the level floor that limits of motion are for [1].
        utilisation: share of it that wheels may use, in (0, 1].

    Raises:
        RobotError: no such robot, or none that can be driven: what is missing, doubled or of the wrong kind.
    """
    reading = load_robot(str(robot))
    path, drive = reading.file.resolve(), reading.model
    try:
        limits = motion_limits(drive, Ground(friction), utilisation)
    except FeasibilityError:
        limits = None
    name = path.parent.name if path.name == "robot.xml" else path.stem
    return Inspection(name, path, reading.parts, drive, limits, friction, utilisation)
