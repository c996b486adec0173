"""Whether a scenario's robot can be found and driven, and be as the physical effects have it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from nhtrack import assets
from nhtrack.config.checks import is_robot_file, positive
from nhtrack.config.physics import Physics
from nhtrack.config.scenario import Scenario
from nhtrack.config.tree import lookup
from nhtrack.effects import Effect, RobotsAtRest, Setting, effects_of
from nhtrack.errors import RobotError, did_you_mean
from nhtrack.section import Finding

if TYPE_CHECKING:
    from nhtrack.experiment.build import Experiment
    from nhtrack.robots.diff_drive import DiffDrive


def robot_findings(tree: Mapping[str, Any], directory: FilePath) -> Iterator[Finding]:
    """Yields why a tree's robot cannot be found, driven, or be as its physical effects have it."""
    robot = lookup(tree, ("robot",), Scenario.model_fields["robot"].default)
    if not isinstance(robot, str) or not robot:
        return
    if robot in assets.robots():
        yield from _findings(_effects_in(tree), robot)
    elif not is_robot_file(robot):
        yield (
            ("robot",),
            f"no robot {robot!r}; {did_you_mean(robot, assets.robots())}, or a path to an .xml file",
        )
    elif not (directory / robot).is_file():
        yield ("robot",), f"no MJCF file {str(directory / robot)!r}"
    else:
        yield from _findings(_effects_in(tree), str(directory / robot))


def _effects_in(tree: Mapping[str, Any]) -> tuple[Effect, ...]:
    """Returns the effects of a raw tree, none where its section `physics` cannot be understood."""
    try:
        physics = Physics.model_validate(lookup(tree, ("physics",), {}))
    except ValidationError:
        return ()
    return effects_of(physics, positive(lookup(tree, ("similarity", "length"))) or 1.0)


def _findings(effects: tuple[Effect, ...], robot: str) -> Iterator[Finding]:
    """Yields why an MJCF file is not a differential-drive robot, and what is wrong with effects on it."""

    @cache
    def plant() -> DiffDrive:
        # MuJoCo takes a while to import, and few effects and only a robot of the user's own need it here.
        from nhtrack.simulation.robot_models import read_robot
        from nhtrack.simulation.spec import SceneSpec

        return read_robot(SceneSpec(("robot",), robot, effects=effects)).plant

    if is_robot_file(robot):
        try:
            plant()
        except RobotError as error:
            yield ("robot",), " ".join(str(error).split())
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
