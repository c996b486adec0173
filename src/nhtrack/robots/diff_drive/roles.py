"""Which joints of a robot's file are its driven wheels and its casters, and why there may be none such."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from nhtrack.errors import did_you_mean
from nhtrack.robots.contract import Refusal, RefusedRobot
from nhtrack.robots.diff_drive.actuators import Pull, pulls_of
from nhtrack.robots.reading.source import Source

__all__ = ["Roles", "find_roles", "touching", "turning"]

_JOINTS = mujoco.mjtJoint
_UPRIGHT = np.sin(np.radians(10.0))  # an axis whose rise is less is horizontal; one whose lean is less, vertical
_LEVEL = 0.25  # of its radius: a wheel whose lowest point is that much higher than another's stands on nothing


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
    led = list(_base(source, root))
    if led:
        raise RefusedRobot(source.file, led)
    refusals = list(_driven(source, rolling, driven))
    if len(rolling) == 2:
        refusals += _between(source, root, rolling)
    inside = source.subtree(root)
    others = [
        j for body in inside for j in source.joints_of(body) if j not in rolling and not _is_base(source, j, root)
    ]
    floor = min((_bottom(source, j) for j in rolling), default=0.0)
    swivels, passive = _casters(source, others, driven, floor)
    refusals += [*passive, *(_rollers(source, rolling) if len(rolling) > 1 else ())]
    if refusals:
        raise RefusedRobot(source.file, _once(refusals))
    held = tuple(j for j in others if j not in swivels)
    return Roles(root, (rolling[0], rolling[1]), tuple(swivels), held, tuple(pulls))


def _once(refusals: Sequence[Refusal]) -> list[Refusal]:
    return list(dict.fromkeys(refusals))


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


def _is_hinge(source: Source, joint: int, *, upright: bool) -> bool:
    rise = abs(source.axis(joint)[2])
    steep = rise > np.sqrt(1 - _UPRIGHT**2) if upright else rise < _UPRIGHT
    return bool(source.model.jnt_type[joint] == _JOINTS.mjJNT_HINGE and steep)


def turning(source: Source, joint: int) -> list[int]:
    """Returns the body of a joint and what hangs on it without a joint of its own."""
    body = int(source.model.jnt_bodyid[joint])
    group = [body]
    for each in source.subtree(body)[1:]:
        if int(source.model.body_parentid[each]) in group and not source.joints_of(each):
            group.append(each)
    return group


def touching(source: Source, bodies: list[int]) -> list[int]:
    """Returns the geoms that bodies touch with; those that are only seen, where there are no others."""
    geoms = source.geoms_of(bodies)
    return [g for g in geoms if source.collides(g)] or geoms


def _bottom(source: Source, joint: int) -> float:
    """Returns the height of the lowest point that moves with a joint [m]."""
    return min((source.bottom(g) for g in touching(source, turning(source, joint))), default=float("inf"))


def _rolling(source: Source, driven: Sequence[int]) -> list[int]:
    """Returns the driven hinges whose bodies reach the floor with a horizontal axis: wheels."""
    lying = [j for j in driven if _is_hinge(source, j, upright=False) and np.isfinite(_bottom(source, j))]
    floor = min((_bottom(source, j) for j in lying), default=0.0)
    return [j for j in lying if _bottom(source, j) - floor <= _LEVEL * max(source.anchor(j)[2] - floor, 0.0)]


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


def _is_base(source: Source, joint: int, root: int) -> bool:
    return bool(source.model.jnt_bodyid[joint] == root)


def _base(source: Source, root: int) -> Iterator[Refusal]:
    """Yields the joints by which a base is led along the floor."""
    for joint in source.joints_of(root):
        if source.model.jnt_type[joint] != _JOINTS.mjJNT_FREE:
            kind = _JOINTS(int(source.model.jnt_type[joint])).name.removeprefix("mjJNT_").lower()
            yield Refusal(
                source.element("joint", joint),
                f"a {kind} joint leads the base, not its wheels; give the base a free joint and motors on two wheels",
            )


def _driven(source: Source, rolling: Sequence[int], driven: Sequence[int]) -> Iterator[Refusal]:
    """Yields why the driven joints are not those of a differential drive."""
    steering = False
    for joint in driven:
        if joint not in rolling and _is_hinge(source, joint, upright=True) and _carries_wheel(source, joint):
            steering = True
            yield Refusal(
                source.element("joint", joint),
                "this steers: it turns what rolls on the floor about an upright axis; only two driven wheels on one "
                "axle can be driven",
            )
    names = ", ".join(source.element("joint", j) for j in rolling)
    if len(rolling) > 2 and not steering:
        axes = [source.axis(j) for j in rolling]
        apart = any(np.linalg.norm(np.cross(axes[0], axis)) > _UPRIGHT for axis in axes[1:])
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
        joints = ", ".join(source.name("joint", j) for j in range(model.njnt) if _is_hinge(source, j, upright=False))
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
    if _is_hinge(source, moved[0], upright=True):
        return f"turns {name!r} about an upright axis"
    if _is_hinge(source, moved[0], upright=False):
        return f"turns {name!r}, whose body does not reach the floor"
    return f"turns {name!r}, whose axis is neither horizontal nor upright"


def _carries_wheel(source: Source, joint: int) -> bool:
    """Whether a hinge lies below a joint whose body is as low as any of the robot."""
    body = int(source.model.jnt_bodyid[joint])
    below = [j for each in source.subtree(body) for j in source.joints_of(each) if j != joint]
    top = list(source.chain(body))[-1]
    lowest = min((source.bottom(g) for g in touching(source, source.subtree(top))), default=0.0)
    return any(
        _is_hinge(source, j, upright=False)
        and _bottom(source, j) - lowest <= _LEVEL * max(source.anchor(j)[2] - lowest, 0.0)
        for j in below
    )


def _between(source: Source, root: int, rolling: Sequence[int]) -> Iterator[Refusal]:
    """Yields the joints between a wheel and the base, which spring, steer or swing it, and a body with two hinges."""
    for wheel in rolling:
        body = int(source.model.jnt_bodyid[wheel])
        for each in source.chain(body):
            for joint in source.joints_of(each) if each != root else []:
                if joint == wheel:
                    continue
                does = (
                    "steers"
                    if _is_hinge(source, joint, upright=True)
                    else "springs"
                    if source.model.jnt_type[joint] == _JOINTS.mjJNT_SLIDE
                    else "swings"
                )
                yield Refusal(
                    source.element("joint", joint),
                    f"it {does} the wheel of {source.element('joint', wheel)}; a driven wheel must hang on the base "
                    "by its axle alone",
                )


def _rollers(source: Source, rolling: Sequence[int]) -> Iterator[Refusal]:
    for wheel in rolling:
        body = int(source.model.jnt_bodyid[wheel])
        below = [j for each in source.subtree(body)[1:] for j in source.joints_of(each)]
        if below:
            yield Refusal(
                source.element("joint", wheel),
                f"its wheel has {len(below)} joints of its own ({source.element('joint', below[0])}, ...): a wheel "
                "with rollers moves sideways",
            )


def _casters(
    source: Source, others: Sequence[int], driven: Sequence[int], floor: float
) -> tuple[list[int], list[Refusal]]:
    """Returns the joints that move with swivel casters, and what rolls on the floor without being one."""
    model, swivels, refusals = source.model, list[int](), list[Refusal]()
    sliding = _named(source, source.hints.casters)

    def stands(joint: int) -> bool:
        shapes = touching(source, turning(source, joint))
        return any(
            source.collides(g) and source.bottom(g) - floor <= _LEVEL * max(source.place(g)[0][2] - floor, 0.0)
            for g in shapes
        )

    for joint in others:
        if model.jnt_type[joint] != _JOINTS.mjJNT_HINGE or joint in swivels or joint in sliding:
            continue
        above = [j for each in source.chain(int(model.jnt_bodyid[joint])) for j in source.joints_of(each)]
        if _is_hinge(source, joint, upright=True):
            below = [
                j for each in source.subtree(int(model.jnt_bodyid[joint])) for j in source.joints_of(each) if j != joint
            ]
            wheels = [j for j in below if j in others and _is_hinge(source, j, upright=False) and stands(j)]
            if wheels or stands(joint):
                if joint in driven:
                    continue  # told: it steers
                if model.jnt_limited[joint] or _is_coupled(source, joint):
                    refusals.append(
                        Refusal(
                            source.element("joint", joint), "this steers: a caster turns freely about its upright axis"
                        )
                    )
                if not all(_is_ball(source, j) for j in (joint, *wheels)):
                    swivels += [joint, *wheels]
        elif stands(joint) and not _is_ball(source, joint) and not any(j in swivels for j in above):
            if not any(_is_hinge(source, j, upright=True) for j in above if j in driven):
                refusals.append(
                    Refusal(
                        source.element("joint", joint),
                        "a wheel that stands on the floor and is not driven: it scrubs when the robot turns; hang it "
                        "on an upright hinge (swivel caster), or name it under `robot: casters:` to let it slide",
                    )
                )
    return swivels, refusals


def _is_coupled(source: Source, joint: int) -> bool:
    model = source.model
    return any(
        model.eq_type[e] == mujoco.mjtEq.mjEQ_JOINT and joint in (int(model.eq_obj1id[e]), int(model.eq_obj2id[e]))
        for e in range(model.neq)
    )


def _is_ball(source: Source, joint: int) -> bool:
    """Whether all that a hinge turns on the floor are spheres about its axis, which turn as in a socket."""
    shapes = [g for g in touching(source, turning(source, joint)) if source.collides(g)]
    for geom in shapes:
        centre, _ = source.place(geom)
        off = np.linalg.norm(np.cross(centre - source.anchor(joint), source.axis(joint)))
        if source.model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_SPHERE or off > 1e-3 * source.model.geom_size[geom, 0]:
            return False
    return bool(shapes)
