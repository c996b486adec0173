"""What a robot is that is no differential drive, in words."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import mujoco
import numpy as np

from nhtrack.robots.contract import Refusal
from nhtrack.robots.diff_drive.actuators import pulls_of
from nhtrack.robots.diff_drive.joints import UPRIGHT, is_hinge, reaches_floor, touching
from nhtrack.robots.reading.source import Source

__all__ = ["hung_badly", "led_by", "not_two_wheels", "with_rollers"]

_JOINTS = mujoco.mjtJoint


def led_by(source: Source, root: int) -> Iterator[Refusal]:
    """Yields the joints by which a base is led along the floor: in a body, or one in each of several within another."""
    body = root
    while True:
        joints = [j for j in source.joints_of(body) if source.model.jnt_type[j] != _JOINTS.mjJNT_FREE]
        if not joints:
            return
        for joint in joints:
            kind = _JOINTS(int(source.model.jnt_type[joint])).name.removeprefix("mjJNT_").lower()
            yield Refusal(
                source.element("joint", joint),
                f"a {kind} joint leads the base, not its wheels; give the base a free joint and motors on two wheels",
            )
        within = [b for b in range(source.model.nbody) if int(source.model.body_parentid[b]) == body and b != body]
        if len(within) != 1 or source.geoms_of([body]):
            return
        body = within[0]


def not_two_wheels(source: Source, rolling: Sequence[int], driven: Sequence[int]) -> Iterator[Refusal]:
    """Yields why the driven joints are not those of a differential drive."""
    steering = False
    for joint in driven:
        if joint not in rolling and is_hinge(source, joint, upright=True) and _carries_wheel(source, joint):
            steering = True
            yield Refusal(
                source.element("joint", joint),
                "this steers: it turns what rolls on the floor about an upright axis; only two driven wheels on one "
                "axle can be driven",
            )
    names = ", ".join(source.element("joint", j) for j in rolling)
    if len(rolling) > 2 and not steering:
        axes = [source.axis(j) for j in rolling]
        apart = any(np.linalg.norm(np.cross(axes[0], axis)) > UPRIGHT for axis in axes[1:])
        kind = "omnidirectional wheels" if apart else "skid steer, whose wheels scrub sideways when it turns"
        yield Refusal("", f"{len(rolling)} driven wheels ({names}): {kind}; only two on one axle can be driven")
    elif len(rolling) < 2 and not steering:
        found = f"only one driven wheel, {names}" if rolling else "no driven wheel"
        yield Refusal(
            "",
            f"{found}: expected two hinges with one horizontal axis, each with an actuator and a tyre on the floor"
            + _actuators(source, rolling),
        )


def _actuators(source: Source, rolling: Sequence[int]) -> str:
    """Returns what each actuator does instead of driving a wheel."""
    model = source.model
    if not model.nu:
        joints = ", ".join(source.name("joint", j) for j in range(model.njnt) if is_hinge(source, j, upright=False))
        return (
            f"; the file has no actuators: name its wheel joints under `robot: wheels:` (horizontal hinges: {joints})"
        )
    said = []
    for a in range(model.nu):
        moved = [pull.joint for pull in pulls_of(source) if pull.actuator == a]
        if not any(j in rolling for j in moved):
            said.append(f"{source.element('actuator', a)} {_instead(source, moved)}")
    return f"; {'; '.join(said)}" if said else ""


def _instead(source: Source, moved: Sequence[int]) -> str:
    if not moved:
        return "acts on no joint"
    kind = source.model.jnt_type[moved[0]]
    name = source.name("joint", moved[0])
    if kind == _JOINTS.mjJNT_SLIDE:
        return f"moves {name!r}, which slides"
    if kind != _JOINTS.mjJNT_HINGE:
        return f"moves {name!r}, which is no hinge"
    if is_hinge(source, moved[0], upright=True):
        return f"turns {name!r} about an upright axis"
    if is_hinge(source, moved[0], upright=False):
        return f"turns {name!r}, whose body does not reach the floor"
    return f"turns {name!r}, whose axis is neither horizontal nor upright"


def _carries_wheel(source: Source, joint: int) -> bool:
    """Whether a hinge lies below a joint whose body is as low as any of the robot."""
    body = int(source.model.jnt_bodyid[joint])
    below = [j for each in source.subtree(body) for j in source.joints_of(each) if j != joint]
    top = list(source.chain(body))[-1]
    lowest = min((source.bottom(g) for g in touching(source, source.subtree(top))), default=0.0)
    return any(is_hinge(source, j, upright=False) and reaches_floor(source, j, lowest) for j in below)


def hung_badly(source: Source, root: int, rolling: Sequence[int]) -> Iterator[Refusal]:
    """Yields the joints between a wheel and the base, which spring, steer or swing it, and a body with two hinges."""
    for wheel in rolling:
        body = int(source.model.jnt_bodyid[wheel])
        for each in source.chain(body):
            for joint in source.joints_of(each) if each != root else []:
                if joint == wheel:
                    continue
                does = (
                    "steers"
                    if is_hinge(source, joint, upright=True)
                    else "springs"
                    if source.model.jnt_type[joint] == _JOINTS.mjJNT_SLIDE
                    else "swings"
                )
                yield Refusal(
                    source.element("joint", joint),
                    f"it {does} the wheel of {source.element('joint', wheel)}; a driven wheel must hang on the base "
                    "by its axle alone",
                )


def with_rollers(source: Source, rolling: Sequence[int]) -> Iterator[Refusal]:
    """Yields the driven wheels that have joints of their own."""
    for wheel in rolling:
        body = int(source.model.jnt_bodyid[wheel])
        below = [j for each in source.subtree(body)[1:] for j in source.joints_of(each)]
        if below:
            yield Refusal(
                source.element("joint", wheel),
                f"its wheel has {len(below)} joints of its own ({source.element('joint', below[0])}, ...): a wheel "
                "with rollers moves sideways",
            )
