"""What is said of a robot's file: hints for it, reasons why it is refused, names of parts in its standard form."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from nhtrack.errors import RobotError

__all__ = ["ROBOT_FILES", "Hints", "Parts", "Refusal", "RefusedRobot", "is_robot_file"]

#: Endings, in small letters, by which the file of a robot is known.
ROBOT_FILES = (".xml", ".mjcf", ".urdf", ".xacro")


def is_robot_file(robot: str) -> bool:
    """Returns whether a text is the path of a robot's file or folder, rather than a name."""
    return robot.lower().endswith(ROBOT_FILES) or "/" in robot or robot in (".", "..")


@dataclass(frozen=True)
class Hints:
    """What a scenario says of a robot's file that the file cannot say itself.

    Attributes:
        wheels: joints of the driven wheels, for a file without actuators.
        casters: joints of wheels that are not driven and slide as ball casters do.
        forward: `x`, `-x`, `y` or `-y`: the axis of the file's chassis that points ahead; empty to read it.
        pose: the key in which joints other than the wheels' are held; empty for `home`, the only one, or the zero pose.
    """

    wheels: tuple[str, ...] = ()
    casters: tuple[str, ...] = ()
    forward: str = ""
    pose: str = ""


@dataclass(frozen=True)
class Refusal:
    """One reason why a robot cannot be driven.

    Attributes:
        element: of its file, with its line, such as `joint 'steer' (line 12)`; empty for the whole robot.
        message: what is wrong, and what to do.
    """

    element: str
    message: str

    def __str__(self) -> str:
        """Returns both as one sentence."""
        return f"{self.element}: {self.message}" if self.element else self.message


class RefusedRobot(RobotError):
    """A robot that cannot be driven, and every reason for it.

    Attributes:
        file: its file.
        refusals: the reasons.
    """

    def __init__(self, file: str | Path, refusals: Sequence[Refusal]) -> None:
        self.file, self.refusals = str(file), tuple(refusals)
        super().__init__("\n".join(f"{self.file}: {each}" for each in self.refusals))

    def __reduce__(self) -> tuple[type[RefusedRobot], tuple[str, tuple[Refusal, ...]]]:
        """Returns how to make the error anew, so that it can cross from a worker process."""
        return type(self), (self.file, self.refusals)


@dataclass(frozen=True)
class Parts:
    """Names of the parts of a robot in its standard form; pairs are (left, right)."""

    chassis: str
    wheel_joints: tuple[str, str]
    motors: tuple[str, str]
    tyres: tuple[str, str]
    casters: tuple[str, ...]
    collision_geoms: tuple[str, ...]
    rolling_casters: tuple[str, ...] = ()  # those of the casters that are wheels of swivels, and grip the floor
