"""Robots whose hulls overlap where they are placed, by the geometry that their contacts are found with."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import mujoco
import numpy as np
from scipy.spatial import KDTree

from nhtrack.arrays import Array
from nhtrack.simulation.robot_models import RobotModels
from nhtrack.simulation.scene import Scene, make_scene
from nhtrack.simulation.spec import SceneSpec

_ROUNDING = 1e-6  # [m] overlap that is none
_HALVINGS = 24  # of the way in which two robots are apart for certain


class Overlap(NamedTuple):
    """Two robots that overlap: their places among those with a body, and by how much [m]."""

    first: int
    second: int
    depth: float


def overlaps(spec: SceneSpec, robot: RobotModels, pose: Array) -> Iterator[Overlap]:
    """Yields every two robots whose hulls overlap, and the way straight apart on which they do: their overlap.

    Args:
        spec: of all robots.
        robot: what is known of them.
        pose: poses of those with a body, shape (p, 3).
    """
    pair = replace(spec, robots=("one", "other"), colours=(0, 1), virtual_root=False, robot_contact=True)
    scene = make_scene(pair, robot)
    data = mujoco.MjData(scene.model)
    reach = _reach(scene, data)
    near = KDTree(pose[:, :2]).query_pairs(2 * reach, output_type="ndarray")
    for first, second in sorted(map(tuple, near.tolist())):
        depth = _depth(scene, data, pose[[first, second]], 2 * reach)
        if depth > _ROUNDING:
            yield Overlap(first, second, depth)


def _reach(scene: Scene, data: mujoco.MjData) -> float:
    """Returns how far a robot's hull reaches from the middle of its axle, at most [m]."""
    data.qpos = scene.qpos_of(np.zeros((2, 3)), np.zeros((2, 2)))
    mujoco.mj_kinematics(scene.model, data)
    touching = np.flatnonzero((scene.model.geom_bodyid > 0) & (scene.model.geom_conaffinity > 0))
    return float((np.hypot(*data.geom_xpos[touching, :2].T) + scene.model.geom_rbound[touching]).max())


def _depth(scene: Scene, data: mujoco.MjData, pose: Array, farthest: float) -> float:
    """Returns how far the second of two robots must be moved straight away from the first [m].

    Args:
        scene: of the two.
        data: of the scene; changed.
        pose: of the two, shape (2, 3); where they are in one place, the way is along the heading of the first.
        farthest: distance at which they are apart for certain [m].
    """
    apart = pose[1, :2] - pose[0, :2]
    distance = float(np.hypot(*apart))
    ahead = np.array([np.cos(pose[0, 2]), np.sin(pose[0, 2])])
    way = apart / distance if distance > 0 else ahead
    moved, low, high = pose.copy(), 0.0, farthest
    if not _touch(scene, data, moved):
        return 0.0
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        moved[1, :2] = pose[1, :2] + middle * way
        low, high = (middle, high) if _touch(scene, data, moved) else (low, middle)
    return low


def _touch(scene: Scene, data: mujoco.MjData, pose: Array) -> bool:
    """Returns whether the hulls of the two robots of a scene touch each other at poses, shape (2, 3)."""
    data.qpos = scene.qpos_of(pose, np.zeros((2, 2)))
    mujoco.mj_kinematics(scene.model, data)
    mujoco.mj_collision(scene.model, data)
    own = scene.model.body_rootid[scene.model.geom_bodyid[data.contact.geom]]
    return bool(((own > 0).all(axis=-1) & (own[:, 0] != own[:, 1])).any())
