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
from nhtrack.config.scenario import Scenario
from nhtrack.config.tree import Path, lookup
from nhtrack.effects import Effect, RobotsAtRest, Setting, effects_of
from nhtrack.errors import RobotError, did_you_mean
from nhtrack.experiment.driven import patches_met
from nhtrack.files.carried import read_at
from nhtrack.files.text import exists
from nhtrack.robots.contract import Hints, is_robot_file
from nhtrack.section import Finding

_ROBOT: TypeAdapter[RobotSection] = TypeAdapter(RobotChoice)
_SWINGING = 0.01  # how much less or more a push may do before it is told

if TYPE_CHECKING:
    from nhtrack.experiment.build import Experiment
    from nhtrack.robots.diff_drive import DiffDrive
    from nhtrack.simulation.robot_models import RobotModels


def robot_findings(tree: Mapping[str, Any], directory: FilePath) -> Iterator[Finding]:
    """Yields why a tree's robot cannot be found, driven, or be as its physical effects have it."""
    try:
        robot = _ROBOT.validate_python(lookup(tree, ("robot",), "nh_mini"))
    except ValidationError:
        return  # told where the section is judged
    at: Path = ("robot", "file") if isinstance(tree.get("robot"), Mapping) else ("robot",)
    if robot.file in assets.robots():
        yield from _findings(_effects_in(tree), robot, at)
    elif not is_robot_file(robot.file):
        yield at, f"no robot {robot.file!r}; {did_you_mean(robot.file, assets.robots())}, or the path of a robot's file"
    elif not exists(read_at(directory / robot.file)):
        yield at, f"no robot file {str(directory / robot.file)!r}"
    else:
        yield from _findings(_effects_in(tree), robot.model_copy(update={"file": str(directory / robot.file)}), at)
    if lookup(tree, ("physics", "robot_contact")) is True:
        yield from _start_findings(tree)


def _start_findings(tree: Mapping[str, Any]) -> Iterator[Finding]:
    """Yields the followers whose hulls overlap other robots' at the start, in a scenario in which robots collide."""
    try:
        scenario = Scenario.model_validate(tree)
    except ValidationError:
        return  # told where sections are judged, or it is a campaign
    if scenario.backend == "ideal":
        return
    # What looks at hulls needs MuJoCo.
    from nhtrack.experiment.build import make_scene_spec, start_poses
    from nhtrack.simulation.overlaps import Overlap, overlaps
    from nhtrack.simulation.robot_models import read_robot

    spec, worst = make_scene_spec(scenario), dict[int, Overlap]()
    try:
        found = list(overlaps(spec, read_robot(spec), start_poses(scenario)[spec.first_body :]))
    except RobotError:
        return  # told above
    for overlap in found:
        if overlap.second not in worst or overlap.depth > worst[overlap.second].depth:
            worst[overlap.second] = overlap
    for second, (first, _, depth) in sorted(worst.items()):
        follower = second - 1 + spec.first_body
        yield (
            ("followers", follower, "start"),
            f"the hulls of {spec.bodies[second]!r} and {spec.bodies[first]!r} overlap by {1e3 * depth:.3g} mm at the "
            "start, and robots collide (physics.robot_contact): start them farther apart",
        )


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
        from nhtrack.simulation.guard import read_sound_robot
        from nhtrack.simulation.spec import SceneSpec

        return read_sound_robot(SceneSpec(("robot",), robot.file, hints=robot.hints, effects=effects)).plant

    own = is_robot_file(robot.file) or robot.hints != Hints()
    if own:
        try:
            plant()
        except RobotError as error:
            for line in str(error).splitlines():
                yield at, line
    for effect in effects:
        try:
            found = list(effect.findings(Setting(effects, plant)))
        except RobotError as error:
            if effect.weighs and not own:  # else told above; bundled robots can be read, but not with any inertia
                yield ("physics", effect.key), "; ".join(str(error).splitlines())
            continue
        yield from ((("physics", effect.key, *path), message) for path, message in found)


def robot_notes(experiment: Experiment) -> tuple[str, ...]:
    """Returns what was read otherwise than the file of a robot has it, or left out, in sentences."""
    reading = experiment.robot.reading
    return tuple(f"{reading.file.name}: {note}" for note in reading.notes)


def robot_warnings(scenario: Scenario, experiment: Experiment) -> tuple[str, ...]:
    """Returns what will part robots from their reduced model, and what effects do to robots at rest, in sentences."""
    spec, robot = experiment.scene, experiment.robot
    heading = experiment.start.g[spec.first_body :, 2]
    met = patches_met(scenario, spec.ground, robot.plant.half_separation)
    at_rest = RobotsAtRest(spec.bodies, heading, robot.plant, spec.ground, met)
    return (*_swinging(robot), *(warning for effect in spec.effects for warning in effect.warnings(at_rest)))


def _swinging(robot: RobotModels) -> Iterator[str]:
    """Yields what swivel casters make of a short push from rest, which the reduced model does not know of."""
    if not robot.parts.rolling_casters:
        return
    from nhtrack.simulation.guard import examine

    for figure in examine(robot.reading):
        if figure.expected > 0 and abs(figure.found / figure.expected - 1) > _SWINGING and figure.unit in ("m", "rad"):
            made = f"{figure.quantity} is {100 * figure.found / figure.expected:.0f} % of what it says"
            yield f"casters swing, which the reduced model does not know of: the {made}, and wheels leave their twin"
