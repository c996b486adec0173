"""Where the tyres of two driven wheels touch the floor, from the shape of whatever the file draws them with."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from nhtrack.arrays import Array
from nhtrack.robots.contract import Refusal
from nhtrack.robots.diff_drive.joints import touching, turning
from nhtrack.robots.reading.shapes import vertices
from nhtrack.robots.reading.source import Source

__all__ = ["Axle", "Tyre", "read_axle", "read_tyre"]

_ANGLES = np.linspace(0, 2 * np.pi, 128, endpoint=False)
_ROUND, _ROUND_MESH = 1e-3, 2e-2  # how far from a circle a tyre may be, over its radius; meshes have corners
_ASKEW = np.radians(0.5)  # how far an axis may turn from the axle: files write half a turn as 1.57
_BESIDE = 2e-3  # how far from the axle a wheel may stand, over their separation
_UNEQUAL = 1e-3  # how much radii may differ, over the radius


@dataclass(frozen=True)
class Tyre:
    """One wheel as its geoms draw it.

    Attributes:
        joint: its hinge.
        geoms: that roll.
        axis: of the hinge, world frame, shape (3,).
        centre: of the tread, on the axis, world frame [m], shape (3,).
        radius: [m].
    """

    joint: int
    geoms: tuple[int, ...]
    axis: Array
    centre: Array
    radius: float


@dataclass(frozen=True)
class Axle:
    """The two wheels, left and right, and the level frame between them.

    Attributes:
        left: the left one.
        right: the right one.
        centre: midpoint, world frame [m], shape (3,).
        frame: rows ahead, left, up in the world frame, shape (3, 3).
        radius: of both tyres [m].
        notes: what is assumed.
    """

    left: Tyre
    right: Tyre
    centre: Array
    frame: Array
    radius: float
    notes: tuple[str, ...]


def read_tyre(source: Source, joint: int) -> tuple[Tyre | None, list[Refusal]]:
    """Returns the tyre that a hinge turns, or why it does not roll.

    The radius is the reach of all that turns with it across the axis, h(phi) = max d(phi) . p; a tyre is round where h
    is the same in all directions.
    """
    geoms = touching(source, turning(source, joint))
    if not geoms:
        return None, [Refusal(source.element("joint", joint), "nothing that it turns has a shape to roll on")]
    axis, anchor = source.axis(joint), source.anchor(joint)
    reaches = np.array([source.reach(g, _ring(axis), anchor) for g in geoms])
    profile = reaches.max(axis=0)
    # An axis may lean a little from what it turns, which is then level; and without the rounding of directions.
    level = np.array([axis[0], axis[1], 0.0]) / np.hypot(axis[0], axis[1])
    farthest = min(max(_farthest(source, g, each, anchor) for g in geoms) for each in (axis, level))
    radius = float(f"{farthest:.12g}")
    treads = [g for g, each in zip(geoms, reaches, strict=True) if each.max() >= (1 - _ROUND_MESH) * radius]
    meshes = any(source.model.geom_type[g] == mujoco.mjtGeom.mjGEOM_MESH for g in treads)
    refusals = list(_out_of_round(source, treads[0], profile, _ROUND_MESH if meshes else _ROUND))
    sides = np.array([_sides(source, g, axis, anchor, radius) for g in treads])
    middle = (sides[:, 0].min() + sides[:, 1].max()) / 2
    return Tyre(joint, tuple(geoms), axis, anchor + middle * axis, radius), refusals


def _out_of_round(source: Source, geom: int, profile: Array, tolerance: float) -> Iterator[Refusal]:
    radius = profile.max()
    eccentric = 2 * abs(np.mean(profile * np.exp(-1j * _ANGLES)))
    if eccentric > tolerance * radius:
        yield Refusal(
            source.element("geom", geom),
            f"the tyre is eccentric: its middle is {eccentric:.3g} m off the wheel's axis; put it on the axis",
        )
    elif profile.max() - profile.min() > tolerance * radius:
        yield Refusal(
            source.element("geom", geom),
            f"the tyre is not round about the wheel's axis: it reaches from {profile.min():.4g} to {radius:.4g} m; "
            "use a cylinder, an ellipsoid or a sphere turned with the axis",
        )


def _ring(axis: Array) -> Array:
    """Returns directions all around an axis, shape (k, 3)."""
    first = np.cross(axis, [1.0, 0, 0] if abs(axis[0]) < 0.7 else [0, 1.0, 0])
    first /= np.linalg.norm(first)
    return np.asarray(np.cos(_ANGLES)[:, None] * first + np.sin(_ANGLES)[:, None] * np.cross(axis, first))


def _farthest(source: Source, geom: int, axis: Array, anchor: Array) -> float:
    """Returns how far from an axis a geom reaches: a mesh to its corners, which lie on what it stands for [m]."""
    if source.model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_MESH:
        return float(source.reach(geom, _ring(axis), anchor).max())
    _, out = _about(source, geom, axis, anchor)
    return float(out.max())


def _about(source: Source, geom: int, axis: Array, anchor: Array) -> tuple[Array, Array]:
    """Returns how far along and how far from an axis the corners of a mesh lie [m], shape (k,)."""
    centre, rotation = source.place(geom)
    points = vertices(source.model, geom) @ rotation.T + centre - anchor
    along = points @ axis
    return along, np.linalg.norm(points - along[:, None] * axis, axis=1)


def _sides(source: Source, geom: int, axis: Array, anchor: Array, radius: float) -> tuple[float, float]:
    """Returns from where to where along the axis the tread of a geom reaches [m]."""
    if source.model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
        along, out = _about(source, geom, axis, anchor)
        tread = along[out >= (1 - _ROUND_MESH) * radius]
        return (float(tread.min()), float(tread.max())) if tread.size else (0.0, 0.0)
    ahead, back = source.reach(geom, np.stack([axis, -axis]), anchor)
    return -float(back), float(ahead)


def read_axle(source: Source, root: int, tyres: Sequence[Tyre]) -> tuple[Axle, list[Refusal]]:
    """Returns the axle that two tyres share, or why they share none."""
    one, two = tyres
    line = two.centre - one.centre
    length = float(np.linalg.norm(line))
    across = line / length if length else one.axis
    refusals = list(_aside(source, tyres, across, length))
    notes = list[str]()
    if abs(one.radius - two.radius) > _UNEQUAL * one.radius:
        other = source.element("geom", one.geoms[0])
        refusals.append(
            Refusal(
                source.element("geom", two.geoms[0]),
                f"the wheels' radii differ: {two.radius:.6g} m, and {one.radius:.6g} m of {other}",
            )
        )
    across = np.array([across[0], across[1], 0.0]) / max(float(np.hypot(across[0], across[1])), 1e-12)
    ahead, said = _ahead(source, root, np.cross(across, [0.0, 0.0, 1.0]), tyres)
    notes += said
    frame = np.stack([ahead, np.cross([0.0, 0.0, 1.0], ahead), [0.0, 0.0, 1.0]])
    left, right = (one, two) if frame[1] @ (one.centre - two.centre) > 0 else (two, one)
    askew = max(float(np.linalg.norm(np.cross(tyre.axis, frame[1]))) for tyre in tyres)
    if askew > 1e-5 and not refusals:
        notes.append(f"wheel axes that turn from the axle by up to {np.degrees(askew):.2g} degrees are put straight")
    return Axle(
        left, right, (one.centre + two.centre) / 2, frame, (one.radius + two.radius) / 2, tuple(notes)
    ), refusals


def _aside(source: Source, tyres: Sequence[Tyre], across: Array, length: float) -> Iterator[Refusal]:
    """Yields why two wheels do not turn about one horizontal axle."""
    one, two = tyres
    toe = float(np.linalg.norm(np.cross(one.axis, two.axis)))
    if toe > 2 * _ASKEW:
        yield Refusal(
            "",
            f"the wheels' axes ({source.element('joint', one.joint)}, {source.element('joint', two.joint)}) make an "
            f"angle of {np.degrees(np.arcsin(min(toe, 1.0))):.3g} degrees: toed-in or leaning wheels scrub; make them "
            "parallel",
        )
        return
    for tyre in tyres:
        if abs(tyre.axis[2]) > _ASKEW:
            yield Refusal(
                source.element("joint", tyre.joint),
                f"its axis leans by {np.degrees(np.arcsin(abs(tyre.axis[2]))):.3g} degrees from the floor",
            )
    off = float(np.linalg.norm(np.cross(one.axis, two.centre - one.centre)))
    if off > _BESIDE * max(length, 1e-9):
        yield Refusal(
            source.element("joint", two.joint),
            f"its wheel is {off:.4g} m off the axis of {source.element('joint', one.joint)}: two driven wheels must "
            "share one axle",
        )


def _ahead(source: Source, root: int, either: Array, tyres: Sequence[Tyre]) -> tuple[Array, list[str]]:
    """Returns which of two horizontal directions is ahead: nearest to +x of the base; across it, as wheels turn."""
    axes = np.array(source.data.xmat[root]).reshape(3, 3).T
    given = source.hints.forward
    if given:
        wanted = axes["xy".index(given[-1])] * (-1 if given.startswith("-") else 1)
        return either * (1.0 if either @ wanted >= 0 else -1.0), [f"ahead is {given} of the base, as the scenario says"]
    along = [float(either @ axis) for axis in axes]
    if abs(along[0]) >= 0.5:
        return either * np.sign(along[0]), []
    rolls = [float(either @ np.cross(tyre.axis, [0.0, 0.0, 1.0])) for tyre in tyres]
    sign = np.sign(rolls[0]) if rolls[0] * rolls[1] > 0 else np.sign(along[1]) or 1.0
    way = ("+" if sign * along[1] > 0 else "-") + "y"
    said = f"the axle lies along x of the base: ahead is its {way}, where wheels roll that turn forward"
    return either * sign, [f"{said}; `robot: forward:` turns it"]
