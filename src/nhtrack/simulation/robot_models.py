"""What is read from the file of a robot, once for a run: its standard form and its reduced models."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import mujoco

from nhtrack import assets
from nhtrack.errors import RobotError, did_you_mean
from nhtrack.files.carried import read_at
from nhtrack.mjcf import parse_mjcf
from nhtrack.robots.contract import Hints, Parts, is_robot_file
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.robots.diff_drive.identification import identify
from nhtrack.robots.kind import Reading
from nhtrack.robots.registry import read_file
from nhtrack.simulation.spec import SceneSpec


@dataclass(frozen=True)
class RobotModels:
    """What is known of the robots of a spec.

    Attributes:
        spec: theirs, of which robot, hints, effects and compensation count.
        reading: what was read from their file.
        nominal: the reduced model of one as its file has it, under effects that change no masses.
        plant: the reduced model of the robots as they are, with what they carry.
    """

    spec: SceneSpec
    reading: Reading
    nominal: DiffDrive
    plant: DiffDrive

    @property
    def parts(self) -> Parts:
        """Names of the parts of a robot."""
        return self.reading.parts

    @property
    def drive(self) -> DiffDrive:
        """The reduced model that wheel torques are computed with."""
        return self.plant if self.spec.compensation == "actual" else self.nominal

    def require(self, spec: SceneSpec) -> None:
        """Raises ValueError where this was not read for the robots of a spec."""
        for name in ("robot", "hints", "effects", "compensation"):
            if getattr(self.spec, name) != getattr(spec, name):
                wanted, known = getattr(spec, name), getattr(self.spec, name)
                raise ValueError(f"robot: {name} is {wanted!r} here, and was {known!r} when the robot was read")


def robot_path(robot: str) -> Path:
    """Returns the file of a robot named by its folder in models/, by its path or by that of its folder.

    Raises:
        RobotError: no such robot; the message lists those there are.
    """
    if robot in assets.robots():
        return assets.find_robot(robot)
    if not is_robot_file(robot):
        raise RobotError(f"no robot {robot!r}; {did_you_mean(robot, assets.robots())}, or the path of a robot's file")
    return Path(robot)


def full_name(robot: str) -> str:
    """Returns a robot's name as `robot_path` understands it in every working directory."""
    return os.path.abspath(robot) if robot not in assets.robots() and is_robot_file(robot) else robot


def load_robot(robot: str, hints: Hints | None = None) -> Reading:
    """Returns what is read from the file of a robot.

    Args:
        robot: folder in models/, or path to a file.
        hints: what that cannot say itself.

    Raises:
        RobotError: it cannot be found, compiled or driven.
    """
    return read_file(read_at(robot_path(robot)), hints)


def read_robot(spec: SceneSpec) -> RobotModels:
    """Returns what is known of the robots of a spec under its effects.

    Raises:
        RobotError: the robot cannot be found, compiled or driven.
    """
    reading = load_robot(spec.robot, spec.hints)
    nominal = plant = _under_effects(reading.model, spec)
    if any(effect.weighs for effect in spec.effects):
        plant = _under_effects(identify(_laden(spec, reading, nominal), reading.parts, reading.model.motor), spec)
    return RobotModels(spec, reading, nominal, plant)


def _under_effects(model: DiffDrive, spec: SceneSpec) -> DiffDrive:
    for effect in spec.effects:
        model = effect.model(model)
    return model


def _laden(spec: SceneSpec, reading: Reading, nominal: DiffDrive) -> mujoco.MjModel:
    """Returns the compiled model of one robot alone with all that changes its masses."""
    robot = parse_mjcf(reading.mjcf)
    for effect in spec.effects:
        if effect.weighs:
            effect.edit_robot(robot, reading.parts, nominal)
    try:
        return mujoco.MjModel.from_xml_string(robot.to_xml_string(), robot.get_assets())
    except ValueError as error:
        raise RobotError(f"{spec.robot!r} under its effects does not compile: {error}") from error
