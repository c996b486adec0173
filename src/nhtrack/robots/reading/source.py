"""A robot's file as MuJoCo compiles it, in the pose in which its arms are held, with the way back to its elements."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from nhtrack.arrays import Array
from nhtrack.robots.contract import Hints
from nhtrack.robots.reading.shapes import SOLID, lowest_points, reach

__all__ = ["Source"]

#: Where a spec keeps the elements of a kind.
LISTS = {
    "body": "bodies", "joint": "joints", "geom": "geoms", "actuator": "actuators", "tendon": "tendons",
    "equality": "equalities", "camera": "cameras", "mesh": "meshes",
}  # fmt: skip


@dataclass(frozen=True)
class Source:
    """A robot's file, compiled.

    Attributes:
        file: the file.
        hints: what it cannot say itself.
        spec: its elements, all of them named.
        model: what MuJoCo makes of it.
        data: in the pose in which all joints are held that do not roll.
        lines: of elements that MuJoCo gives none for, by kind and name.
        unnamed: elements that have their names from us, by kind and name.
        notes: what was left out so far, a sentence each.
    """

    file: Path
    hints: Hints
    spec: Any
    model: mujoco.MjModel
    data: mujoco.MjData
    lines: dict[tuple[str, str], int]
    unnamed: frozenset[tuple[str, str]]
    notes: tuple[str, ...]

    def name(self, kind: str, index: int) -> str:
        """Returns the name of an element by its id in the model."""
        return str(getattr(self.model, kind)(index).name)

    def element(self, kind: str, index: int) -> str:
        """Returns what an element is called in messages: its kind, its name, its line."""
        name = self.name(kind, index)
        where = self._line(kind, index, name)
        if (kind, name) not in self.unnamed:
            return f"{kind} {name!r}{where}"
        if kind in ("geom", "joint"):
            body = int(getattr(self.model, "geom_bodyid" if kind == "geom" else "jnt_bodyid")[index])
            return f"a {kind} without a name in body {self.name('body', body)!r}{where}"
        return f"a {kind} without a name{where}"

    def _line(self, kind: str, index: int, name: str) -> str:
        info = next((each.info for each in getattr(self.spec, LISTS[kind]) if each.id == index), "")
        if not info and (kind, name) in self.lines:
            info = f"line {self.lines[kind, name]}"
        return f" ({info})" if info and info != "line 0" else ""  # 0 in what another file was attached by

    def subtree(self, body: int) -> list[int]:
        """Returns the ids of a body and all below it."""
        inside = {body}
        for each in range(body + 1, self.model.nbody):
            if int(self.model.body_parentid[each]) in inside:
                inside.add(each)
        return sorted(inside)

    def chain(self, body: int) -> Iterator[int]:
        """Yields a body and the bodies it hangs on, up to but without the world."""
        while body:
            yield body
            body = int(self.model.body_parentid[body])

    def joints_of(self, body: int) -> list[int]:
        """Returns the ids of a body's joints."""
        first = int(self.model.body_jntadr[body])
        return list(range(first, first + int(self.model.body_jntnum[body])))

    def geoms_of(self, bodies: list[int]) -> list[int]:
        """Returns the ids of the solid geoms of some bodies."""
        inside, kinds = set(bodies), set(SOLID)
        return [
            g
            for g in range(self.model.ngeom)
            if int(self.model.geom_bodyid[g]) in inside and mujoco.mjtGeom(int(self.model.geom_type[g])) in kinds
        ]

    def collides(self, geom: int) -> bool:
        """Whether a geom can touch anything."""
        return bool(self.model.geom_contype[geom] or self.model.geom_conaffinity[geom])

    def anchor(self, joint: int) -> Array:
        """Returns where a joint turns, world frame [m], shape (3,)."""
        return np.array(self.data.xanchor[joint])

    def axis(self, joint: int) -> Array:
        """Returns the axis of a joint, world frame, shape (3,)."""
        return np.array(self.data.xaxis[joint])

    def place(self, geom: int) -> tuple[Array, Array]:
        """Returns the centre of a geom, shape (3,), and its rotation, shape (3, 3), in the world frame."""
        return np.array(self.data.geom_xpos[geom]), np.array(self.data.geom_xmat[geom]).reshape(3, 3)

    def reach(self, geom: int, direction: Array, origin: Array) -> Array:
        """Returns how far a geom reaches from an origin in directions, world frame [m], shape (...)."""
        centre, rotation = self.place(geom)
        return np.asarray((centre - origin) @ np.moveaxis(direction, -1, 0)) + reach(
            self.model, geom, direction @ rotation
        )

    def bottom(self, geom: int) -> float:
        """Returns the height of a geom's lowest point, world frame [m]."""
        return -float(self.reach(geom, np.array([0.0, 0.0, -1.0]), np.zeros(3)))

    def lowest_points(self, geom: int, rotation: Array, tolerance: float) -> Array:
        """Returns where a geom would touch a floor, in the frame whose rows are `rotation`, [m], shape (k, 3)."""
        centre, own = self.place(geom)
        return np.asarray(rotation @ centre + lowest_points(self.model, geom, rotation @ own, tolerance))

    def mass_of(self, bodies: Sequence[int]) -> tuple[float, Array]:
        """Returns the mass of some bodies [kg] and its centre, world frame [m], shape (3,)."""
        masses = self.model.body_mass[list(bodies)]
        total = float(masses.sum())
        return total, np.asarray(masses @ self.data.xipos[list(bodies)] / max(total, 1e-300))

    def inertia_about(self, bodies: Sequence[int], point: Array) -> Array:
        """Returns the inertia of some bodies about a point, world frame [kg m^2], shape (3, 3)."""
        inertia = np.zeros((3, 3))
        for body in bodies:
            turned, off = np.array(self.data.ximat[body]).reshape(3, 3), self.data.xipos[body] - point
            inertia += turned @ np.diag(self.model.body_inertia[body]) @ turned.T
            inertia += self.model.body_mass[body] * (off @ off * np.eye(3) - np.outer(off, off))
        return inertia
