"""A robot at rest as it is seen from above and from the side: outlines of its geoms, the nearest last."""

from __future__ import annotations

from typing import NamedTuple

import mujoco
import numpy as np

from nhtrack.arrays import Array
from nhtrack.robots.kind import Reading
from nhtrack.robots.reading.shapes import SOLID, outline, reach

__all__ = ["ABOVE", "SIDE", "Piece", "View", "silhouettes"]

_SEEN = 3  # geoms of the first groups are drawn; the others only touch


class View(NamedTuple):
    """A way to look at a robot: axes of the picture and towards the eye, in the chassis' frame."""

    across: tuple[float, float, float]
    up: tuple[float, float, float]
    eye: tuple[float, float, float]


ABOVE = View((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
SIDE = View((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0))  # from the right, so that it drives to the right


class Piece(NamedTuple):
    """A geom in a picture.

    Attributes:
        corners: of its outline, from the floor below the axle's middle [m], shape (k, 2).
        nearest: how near the eye it comes [m]; larger is nearer.
        moves: whether it turns with a wheel or a caster.
    """

    corners: Array
    nearest: float
    moves: bool


def silhouettes(reading: Reading, *views: View) -> list[list[Piece]]:
    """Returns what is seen of a robot each way, the nearest last."""
    model = mujoco.MjModel.from_xml_string(reading.mjcf)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    chassis = model.body(reading.parts.chassis).id
    origin = data.xpos[chassis] - [0.0, 0.0, reading.model.wheel_radius]
    solid = [g for g in range(model.ngeom) if mujoco.mjtGeom(int(model.geom_type[g])) in SOLID]
    seen = [g for g in solid if model.geom_group[g] < _SEEN and model.geom_rgba[g, 3] > 0] or solid
    pieces = [
        [_piece(model, data, g, origin, view, moves=int(model.geom_bodyid[g]) != chassis) for g in seen]
        for view in views
    ]
    return [sorted(each, key=lambda piece: piece.nearest) for each in pieces]


def _piece(
    model: mujoco.MjModel, data: mujoco.MjData, geom: int, origin: Array, view: View, *, moves: bool
) -> Piece:  # fmt: skip
    rotation = np.array(data.geom_xmat[geom]).reshape(3, 3)
    across, up, eye = (np.array(axis) @ rotation for axis in view)
    place = data.geom_xpos[geom] - origin
    corners = outline(model, geom, across, up) + np.array([place @ view.across, place @ view.up])
    return Piece(corners, float(place @ view.eye + reach(model, geom, eye)), moves)
