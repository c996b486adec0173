"""How far a geom of any type reaches in a direction, and where it touches a floor."""

from __future__ import annotations

import mujoco
import numpy as np

from nhtrack.arrays import Array

_TYPES = mujoco.mjtGeom
#: Geoms that stand on one point wherever they are turned.
ROUND = (_TYPES.mjGEOM_SPHERE, _TYPES.mjGEOM_ELLIPSOID)
#: Geoms whose extent is known.
SOLID = (*ROUND, _TYPES.mjGEOM_CAPSULE, _TYPES.mjGEOM_CYLINDER, _TYPES.mjGEOM_BOX, _TYPES.mjGEOM_MESH)

_TANGENTS = 180  # of an outline


def reach(model: mujoco.MjModel, geom: int, direction: Array) -> Array:
    """Returns how far a geom reaches from its centre, max over its points p of d . p [m], shape (...).

    Args:
        model: the compiled model.
        geom: id of a solid one.
        direction: d in the geom's frame, unit vectors, shape (..., 3).
    """
    size, kind = model.geom_size[geom], _TYPES(int(model.geom_type[geom]))
    if kind == _TYPES.mjGEOM_SPHERE:
        return np.full(direction.shape[:-1], size[0])
    if kind == _TYPES.mjGEOM_ELLIPSOID:
        return np.asarray(np.linalg.norm(direction * size, axis=-1))
    if kind == _TYPES.mjGEOM_CAPSULE:
        return np.asarray(size[0] + size[1] * np.abs(direction[..., 2]))
    if kind == _TYPES.mjGEOM_CYLINDER:
        across = np.linalg.norm(direction[..., :2], axis=-1)
        return np.asarray(size[0] * across + size[1] * np.abs(direction[..., 2]))
    if kind == _TYPES.mjGEOM_BOX:
        return np.asarray(np.abs(direction) @ size)
    return np.asarray((direction @ vertices(model, geom).T).max(axis=-1))


def outline(model: mujoco.MjModel, geom: int, across: Array, up: Array) -> Array:
    """Returns the outline of a geom's convex hull in a plane, from its centre [m], shape (k, 2).

    The lines that touch it, d_i . p = h(d_i) for directions d_i all around, meet each other at its corners.

    Args:
        model: the compiled model.
        geom: id of a solid one.
        across: first axis of the plane in the geom's frame, shape (3,).
        up: second one.
    """
    angles = np.linspace(0, 2 * np.pi, _TANGENTS, endpoint=False)
    normals = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    touched = reach(model, geom, normals @ np.stack([across, up]))
    pairs = np.stack([normals, np.roll(normals, -1, axis=0)], axis=1)
    return np.asarray(np.linalg.solve(pairs, np.stack([touched, np.roll(touched, -1)], axis=-1)[..., None])[..., 0])


def vertices(model: mujoco.MjModel, geom: int) -> Array:
    """Returns the vertices of a mesh geom in its frame [m], shape (k, 3)."""
    mesh = int(model.geom_dataid[geom])
    first = int(model.mesh_vertadr[mesh])
    return np.asarray(model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])], dtype=float)


def lowest_points(model: mujoco.MjModel, geom: int, rotation: Array, tolerance: float) -> Array:
    """Returns points that span where a geom touches a level floor below it, from its centre [m], shape (k, 3).

    Args:
        model: the compiled model.
        geom: id of a solid one.
        rotation: from its frame to the level one, shape (3, 3).
        tolerance: how much higher than the lowest a point may lie and still touch [m].
    """
    points = _extreme_points(model, geom, rotation) @ rotation.T
    return np.asarray(points[points[:, 2] <= points[:, 2].min() + tolerance])


def _extreme_points(model: mujoco.MjModel, geom: int, rotation: Array) -> Array:
    """Returns points of a geom, in its frame, among which are all that may be its lowest."""
    size, kind, down = model.geom_size[geom], model.geom_type[geom], -rotation[2]
    if kind == _TYPES.mjGEOM_SPHERE:
        return np.asarray((size[0] * down)[None])
    if kind == _TYPES.mjGEOM_ELLIPSOID:
        return np.asarray((size**2 * down / np.linalg.norm(size * down))[None])
    if kind == _TYPES.mjGEOM_MESH:
        return vertices(model, geom)
    signs: Array = np.array([-1.0, 1.0])
    if kind == _TYPES.mjGEOM_BOX:
        return np.stack(np.meshgrid(*(signs * edge for edge in size)), axis=-1).reshape(-1, 3)
    ends: Array = np.zeros((2, 3))
    ends[:, 2] = signs * size[1]
    if kind == _TYPES.mjGEOM_CAPSULE:
        return np.asarray(ends + size[0] * down)
    across = np.array([down[0], down[1], 0.0])
    if np.linalg.norm(across) > 1e-6:
        return np.asarray(ends + size[0] * across / np.linalg.norm(across))
    angle = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    rim = size[0] * np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=-1)
    return np.asarray((ends[:, None] + rim).reshape(-1, 3))
