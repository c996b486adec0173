"""Which joints of a robot's file are its driven wheels and its casters, and why there may be none such."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from nhtrack.errors import did_you_mean
from nhtrack.robots.contract import Refusal, RefusedRobot
from nhtrack.robots.diff_drive.actuators import Pull, pulls_of
from nhtrack.robots.diff_drive.instead import hung_badly, led_by, not_two_wheels, with_rollers
from nhtrack.robots.diff_drive.joints import bottom_of, is_ball, is_coupled, is_hinge, reaches_floor
from nhtrack.robots.reading.source import Source

__all__ = ["Roles", "find_roles"]

_JOINTS = mujoco.mjtJoint


@dataclass(frozen=True)
class Roles:
    """What the joints of a robot do.

    Attributes:
        root: body that all others hang on.
        wheels: joints of the two driven wheels, in the file's order.
        swivels: joints that move with the casters: upright ones, and those of the wheels below them.
        held: all others, which are held.
        pulls: what the actuators do to the driven wheels.
    """

    root: int
    wheels: tuple[int, int]
    swivels: tuple[int, ...]
    held: tuple[int, ...]
    pulls: tuple[Pull, ...]

    def link_of(self, source: Source, body: int) -> int:
        """Returns the moving joint that a body moves with, or -1 for the chassis."""
        moving = {*self.wheels, *self.swivels}
        for each in source.chain(body):
            for joint in reversed(source.joints_of(each)):
                if joint in moving:
                    return joint
        return -1


def find_roles(source: Source) -> Roles:
    """Returns what the joints of a differential drive do.

    Raises:
        RefusedRobot: it is none: what it is instead, joint by joint.
    """
    pulls = pulls_of(source)
    driven = _named(source, source.hints.wheels) or sorted({pull.joint for pull in pulls})
    rolling = _rolling(source, driven)
    root = _root(source, rolling, driven)
    led = list(led_by(source, root))
    if led:
        raise RefusedRobot(source.file, led)
    others = [j for body in source.subtree(root)[1:] for j in source.joints_of(body) if j not in rolling]
    floor = min((bottom_of(source, j) for j in rolling), default=0.0)
    swivels, passive = _casters(source, others, driven, floor)
    refusals = [*not_two_wheels(source, rolling, driven), *(passive if driven else ())]
    if len(rolling) > 1:
        refusals += with_rollers(source, rolling)
    if len(rolling) == 2:
        refusals += hung_badly(source, root, rolling)
    if refusals:
        raise RefusedRobot(source.file, list(dict.fromkeys(refusals)))
    held = tuple(j for j in others if j not in swivels)
    return Roles(root, (rolling[0], rolling[1]), tuple(swivels), held, tuple(pulls))


def _named(source: Source, given: Sequence[str]) -> list[int]:
    """Returns the joints that the scenario names.

    Raises:
        RefusedRobot: the file has no such joints.
    """
    names = {source.name("joint", j): j for j in range(source.model.njnt)}
    unknown = [
        Refusal("", f"no joint {name!r}; {did_you_mean(name, list(names))}") for name in given if name not in names
    ]
    if unknown:
        raise RefusedRobot(source.file, unknown)
    return [names[name] for name in given]


def _rolling(source: Source, driven: Sequence[int]) -> list[int]:
    """Returns the driven hinges whose bodies reach the floor with a horizontal axis: wheels."""
    lying = [j for j in driven if is_hinge(source, j, upright=False) and np.isfinite(bottom_of(source, j))]
    floor = min((bottom_of(source, j) for j in lying), default=0.0)
    return [j for j in lying if reaches_floor(source, j, floor)]


def _root(source: Source, rolling: Sequence[int], driven: Sequence[int]) -> int:
    """Returns the body below the world that carries the wheels, or else most bodies."""
    model = source.model
    tops = [body for body in range(1, model.nbody) if model.body_parentid[body] == 0]
    if not tops:
        raise RefusedRobot(source.file, [Refusal("", "it has no body")])
    for joint in (*rolling, *driven):
        return next(body for body in source.chain(int(model.jnt_bodyid[joint])) if model.body_parentid[body] == 0)
    return max(tops, key=lambda body: (_is_free(source, body), len(source.subtree(body))))


def _is_free(source: Source, body: int) -> bool:
    return any(source.model.jnt_type[j] == _JOINTS.mjJNT_FREE for j in source.joints_of(body))


def _casters(
    source: Source, others: Sequence[int], driven: Sequence[int], floor: float
) -> tuple[list[int], list[Refusal]]:
    """Returns the joints that move with swivel casters, and what rolls on the floor without being one."""
    swivels, refusals = list[int](), list[Refusal]()
    sliding = _named(source, source.hints.casters)

    def stands(joint: int) -> bool:
        return source.model.jnt_type[joint] == _JOINTS.mjJNT_HINGE and reaches_floor(source, joint, floor)

    for joint in [j for j in others if j not in sliding]:
        body = int(source.model.jnt_bodyid[joint])
        if is_hinge(source, joint, upright=True):
            below = [j for each in source.subtree(body) for j in source.joints_of(each) if j != joint and j in others]
            wheels = [j for j in below if is_hinge(source, j, upright=False) and stands(j)]
            if joint in driven or not (wheels or stands(joint)):
                continue  # it steers, which is told elsewhere, or carries nothing that rolls
            if source.model.jnt_limited[joint] or is_coupled(source, joint):
                said = "this steers: a caster turns freely about its upright axis"
                refusals.append(Refusal(source.element("joint", joint), said))
            if not all(is_ball(source, j) for j in (joint, *wheels)):
                swivels += [joint, *wheels]
        elif stands(joint) and joint not in swivels and not is_ball(source, joint):
            above = [j for each in source.chain(body) for j in source.joints_of(each)]
            if not any(j in swivels or (j in driven and is_hinge(source, j, upright=True)) for j in above):
                refusals.append(
                    Refusal(
                        source.element("joint", joint),
                        "a wheel that stands on the floor and is not driven: it scrubs when the robot turns; hang it "
                        "on an upright hinge (swivel caster), or name it under `robot: casters:` to let it slide",
                    )
                )
    return swivels, refusals
