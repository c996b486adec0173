"""Whether robots can stand as a scenario has them: with their payload, on its slope."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import ValidationError

from nhtrack.config.physics import Physics
from nhtrack.config.scenario import Scenario
from nhtrack.config.tree import Path, lookup
from nhtrack.errors import RobotError

if TYPE_CHECKING:
    from nhtrack.experiment.build import Experiment
    from nhtrack.robots.diff_drive import DiffDrive

_PAYLOAD: Path = ("physics", "payload")


def stability_findings(tree: Mapping[str, Any], robot: str) -> Iterator[tuple[Path, str]]:
    """Yields why robots of a raw tree could not stand, as path and message; skips what it cannot understand.

    Args:
        tree: the raw tree.
        robot: a bundled robot, or the path of an MJCF file.
    """
    try:
        physics = Physics.model_validate(lookup(tree, ("physics",), {}))
    except ValidationError:
        return
    if physics.base == "planar" and physics.wheel_mismatch:
        yield (
            ("physics", "wheel_mismatch"),
            f"wheels that differ by {physics.wheel_mismatch:g} make a robot lean, and `base: planar` holds it level; "
            "use `base: free`",
        )
    payload = physics.payload
    if payload is None:
        return
    if payload.height < payload.size[2] / 2:
        yield (
            (*_PAYLOAD, "height"),
            f"a payload {payload.size[2]:g} m high with its centre {payload.height:g} m above the floor reaches into "
            "it",
        )
    elif physics.base == "free":
        yield from _payload_findings(physics, robot)


def _payload_findings(physics: Physics, robot: str) -> Iterator[tuple[Path, str]]:
    """Yields that a payload tips its robot."""
    # MuJoCo takes a while to import, and only a payload needs it here.
    from nhtrack.experiment.build import make_payload
    from nhtrack.simulation.scene import SceneSpec, reduced_models

    try:
        plant = reduced_models(SceneSpec(("robot",), robot, payload=make_payload(physics.payload)))[1]
    except RobotError:
        return  # the robot's fault, reported as such
    lifted = [name for name, load in support_loads(plant).items() if load <= 0]
    if lifted:
        x, y = plant.com[:2]
        yield (
            _PAYLOAD,
            f"it tips the robot: with it the centre of mass lies at ({x:.3g}, {y:.3g}) m from the axle's middle, "
            f"outside wheels and caster, and the {' and the '.join(lifted)} would lift",
        )


def support_loads(plant: DiffDrive) -> dict[str, float]:
    """Returns the loads [N] on left wheel, right wheel and caster of a robot that stands on a level floor."""
    still = (np.zeros(()),) * 4
    left, right = plant.wheel_loads(*still)
    return {"left wheel": float(left), "right wheel": float(right), "caster": float(plant.caster_load(*still))}


def stability_warnings(scenario: Scenario, experiment: Experiment, plant: DiffDrive) -> tuple[str, ...]:
    """Returns what a slope will do to robots that merely stand on it, in sentences."""
    ground = experiment.scene.ground
    if ground.slope == 0.0:
        return ()
    told = []
    if ground.slope > math.atan(ground.friction):
        told.append(
            f"the slope of {ground.slope:.3g} rad is steeper than the friction angle of "
            f"{math.atan(ground.friction):.3g} rad (friction {ground.friction:g}): nothing on it stays where it is"
        )
    zero = np.zeros(len(scenario.parents))
    gravity = ground.gravity_at(experiment.start.g[:, 2])
    loads = np.column_stack([plant.wheel_loads(*(zero,) * 4, gravity), plant.caster_load(*(zero,) * 4, gravity)])
    for name, row in zip(scenario.parents, loads, strict=True):
        if name in experiment.scene.bodies and row.min() < 0 and scenario.physics.base == "free":
            part = ("left wheel", "right wheel", "caster")[int(row.argmin())]
            told.append(f"{name} starts on a slope too steep to stand on: held there, it would lift its {part}")
    return tuple(told)
