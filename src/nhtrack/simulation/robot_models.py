"""What is read from the MJCF of a robot, once for a run: its parts and its reduced models."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import mujoco

from nhtrack import assets
from nhtrack.errors import RobotError, did_you_mean
from nhtrack.mjcf import read_mjcf
from nhtrack.robots.diff_drive import DiffDrive, identify
from nhtrack.robots.diff_drive.identification import Parts, identify_parts
from nhtrack.simulation.spec import SceneSpec


@dataclass(frozen=True)
class RobotModels:
    """What is known of the robots of a spec.

    Attributes:
        spec: theirs, of which robot, effects and compensation count.
        file: MJCF of one of them.
        parts: names of its parts.
        nominal: the reduced model of one as its file has it.
        plant: the reduced model of the robots as they are, with what they carry.
    """

    spec: SceneSpec
    file: Path
    parts: Parts
    nominal: DiffDrive
    plant: DiffDrive

    @property
    def drive(self) -> DiffDrive:
        """The reduced model that wheel torques are computed with."""
        return self.plant if self.spec.compensation == "actual" else self.nominal

    def require(self, spec: SceneSpec) -> None:
        """Raises ValueError where this was not read for the robots of a spec."""
        for name in ("robot", "effects", "compensation"):
            if getattr(self.spec, name) != getattr(spec, name):
                wanted, known = getattr(spec, name), getattr(self.spec, name)
                raise ValueError(f"robot: {name} is {wanted!r} here, and was {known!r} when the robot was read")


def robot_path(robot: str) -> Path:
    """Returns the MJCF file of a robot named by its folder in models/ or by a path that ends in `.xml`.

    Raises:
        RobotError: no such robot; the message lists those there are.
    """
    if Path(robot).suffix == ".xml":
        if not Path(robot).is_file():
            raise RobotError(f"{robot}: no such MJCF file")
        return Path(robot)
    if robot not in assets.robots():
        raise RobotError(f"no robot {robot!r}; {did_you_mean(robot, assets.robots())}")
    return assets.find_robot(robot)


def load_robot(robot: str) -> mujoco.MjModel:
    """Returns the compiled model of one robot alone.

    Raises:
        RobotError: no such robot, or MuJoCo cannot compile it.
    """
    path = robot_path(robot)
    try:
        return mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        raise RobotError(f"{path}: MuJoCo cannot compile it: {error}") from error


def read_robot(spec: SceneSpec) -> RobotModels:
    """Returns what is known of the robots of a spec under its effects.

    Raises:
        RobotError: the robot cannot be found, compiled or driven.
    """
    alone = load_robot(spec.robot)
    file, parts = robot_path(spec.robot), identify_parts(alone)
    nominal = plant = _under_effects(identify(alone, parts), spec)
    if any(effect.weighs for effect in spec.effects):
        plant = _under_effects(identify(_laden(spec, file, parts, nominal)), spec)
    return RobotModels(spec, file, parts, nominal, plant)


def _under_effects(model: DiffDrive, spec: SceneSpec) -> DiffDrive:
    for effect in spec.effects:
        model = effect.model(model)
    return model


def _laden(spec: SceneSpec, file: Path, parts: Parts, nominal: DiffDrive) -> mujoco.MjModel:
    """Returns the compiled model of one robot alone with all that changes its masses."""
    robot = read_mjcf(file)
    for effect in spec.effects:
        if effect.weighs:
            effect.edit_robot(robot, parts, nominal)
    try:
        return mujoco.MjModel.from_xml_string(robot.to_xml_string(), robot.get_assets())
    except ValueError as error:
        raise RobotError(f"{spec.robot!r} under its effects does not compile: {error}") from error
