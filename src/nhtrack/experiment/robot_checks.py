"""Whether a scenario's robot can be found and driven, and be as the physical effects have it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

from pydantic import TypeAdapter, ValidationError

from nhtrack import assets
from nhtrack.config.checks import positive
from nhtrack.config.physics import Physics
from nhtrack.config.robot_section import RobotChoice, RobotSection
from nhtrack.config.tree import Path, lookup
from nhtrack.effects import Effect, RobotsAtRest, Setting, effects_of
from nhtrack.errors import RobotError, did_you_mean
from nhtrack.robots.contract import Hints, is_robot_file
from nhtrack.section import Finding

if TYPE_CHECKING:
    from nhtrack.experiment.build import Experiment
    from nhtrack.robots.diff_drive import DiffDrive


def robot_findings(tree: Mapping[str, Any], directory: FilePath) -> Iterator[Finding]:
    """Yields why a tree's robot cannot be found, driven, or be as its physical effects have it."""
    try:
        robot = TypeAdapter(RobotChoice).validate_python(lookup(tree, ("robot",), "nh_mini"))
    except ValidationError:
        return  # told where the section is judged
    at: Path = ("robot", "file") if isinstance(tree.get("robot"), Mapping) else ("robot",)
    if robot.file in assets.robots():
        yield from _findings(_effects_in(tree), robot, at)
    elif not is_robot_file(robot.file):
        yield at, f"no robot {robot.file!r}; {did_you_mean(robot.file, assets.robots())}, or the path of a robot's file"
    elif not (directory / robot.file).exists():
        yield at, f"no robot file {str(directory / robot.file)!r}"
    else:
        yield from _findings(_effects_in(tree), robot.model_copy(update={"file": str(directory / robot.file)}), at)


def _effects_in(tree: Mapping[str, Any]) -> tuple[Effect, ...]:
    """Returns the effects of a raw tree, none where its section `physics` cannot be understood."""
    try:
        physics = Physics.model_validate(lookup(tree, ("physics",), {}))
    except ValidationError:
        return ()
    return effects_of(physics, positive(lookup(tree, ("similarity", "length"))) or 1.0)


def _findings(effects: tuple[Effect, ...], robot: RobotSection, at: Path) -> Iterator[Finding]:
    """Yields why a file is no robot that can be driven, each reason by itself, and what is wrong with effects on it."""

    @cache
    def plant() -> DiffDrive:
        # MuJoCo takes a while to import, and few effects and only a robot of the user's own need it here.
        from nhtrack.simulation.robot_models import read_robot
        from nhtrack.simulation.spec import SceneSpec

        return read_robot(SceneSpec(("robot",), robot.file, hints=robot.hints, effects=effects)).plant

    if is_robot_file(robot.file) or robot.hints != Hints():
        try:
            plant()
        except RobotError as error:
            for line in str(error).splitlines():
                yield at, line
    for effect in effects:
        try:
            found = list(effect.findings(Setting(effects, plant)))
        except RobotError:
            continue  # told above; bundled robots can be read
        yield from ((("physics", effect.key, *path), message) for path, message in found)


def effect_warnings(experiment: Experiment) -> tuple[str, ...]:
    """Returns what the effects will do to robots that merely stand where they begin, in sentences."""
    spec = experiment.scene
    heading = experiment.start.g[spec.first_body :, 2]
    robots = RobotsAtRest(spec.bodies, heading, experiment.robot.plant, spec.ground)
    return tuple(warning for effect in spec.effects for warning in effect.warnings(robots))
