"""What can be seen of a joint of a robot's file: which way it turns, what it turns, and how low that reaches."""

from __future__ import annotations

import mujoco
import numpy as np

from nhtrack.robots.reading.source import Source

__all__ = ["bottom_of", "is_ball", "is_coupled", "is_hinge", "reaches_floor", "touching", "turning"]

UPRIGHT = np.sin(np.radians(10.0))  # an axis whose rise is less is horizontal; one whose lean is less, upright
_LEVEL = 0.25  # of its radius: a wheel whose lowest point is that much higher than another's stands on nothing


def is_hinge(source: Source, joint: int, *, upright: bool) -> bool:
    """Whether a joint is a hinge with an upright axis, or with a horizontal one."""
    rise = abs(source.axis(joint)[2])
    steep = rise > np.sqrt(1 - UPRIGHT**2) if upright else rise < UPRIGHT
    return bool(source.model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE and steep)


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


def bottom_of(source: Source, joint: int) -> float:
    """Returns the height of the lowest point that moves with a joint [m]."""
    return min((source.bottom(g) for g in touching(source, turning(source, joint))), default=float("inf"))


def reaches_floor(source: Source, joint: int, floor: float) -> bool:
    """Whether the lowest point that turns with a joint is as low as a floor, within a share of its radius."""
    return bool(bottom_of(source, joint) - floor <= _LEVEL * max(source.anchor(joint)[2] - floor, 0.0))


def is_coupled(source: Source, joint: int) -> bool:
    """Whether an equality couples a joint to another."""
    model = source.model
    return any(
        model.eq_type[e] == mujoco.mjtEq.mjEQ_JOINT and joint in (int(model.eq_obj1id[e]), int(model.eq_obj2id[e]))
        for e in range(model.neq)
    )


def is_ball(source: Source, joint: int) -> bool:
    """Whether all that a hinge turns on the floor are spheres about its axis, which turn as in a socket."""
    shapes = [g for g in touching(source, turning(source, joint)) if source.collides(g)]
    for geom in shapes:
        centre, _ = source.place(geom)
        off = np.linalg.norm(np.cross(centre - source.anchor(joint), source.axis(joint)))
        if source.model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_SPHERE or off > 1e-3 * source.model.geom_size[geom, 0]:
            return False
    return bool(shapes)
