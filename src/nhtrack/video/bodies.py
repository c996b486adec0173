"""How solid and of what colour each robot's body is drawn: the model's looks, changed from frame to frame."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from nhtrack.simulation.palette import UTILISATION, rgb
from nhtrack.simulation.scene import Scene

__all__ = ["Bodies", "fading", "robot_scale", "utilisation_colour", "wheel_angles"]

_COINCIDENT, _CLEAR = 0.015, 0.06  # [m] nearer than the first robots are one to the eye, beyond the second apart
_GHOST = 0.38  # opacity of an ideal twin
_NH_MINI = 0.06  # [m] from the axle midpoint to the side of nh_mini, for which lengths of this package are meant
_DEFAULT = np.array([0.5, 0.5, 0.5, 1.0], np.float32)  # a geom of this colour has its material's


@dataclass(frozen=True)
class _Parts:
    """What one robot is drawn with: ids of its materials, of its geoms without one, and of its two tyres' looks."""

    materials: np.ndarray
    plain: np.ndarray
    tyres: tuple[np.ndarray, np.ndarray]


class Bodies:
    """The looks of a scene's robots; changes the scene's model.

    Args:
        scene: the compiled scene.
    """

    def __init__(self, scene: Scene) -> None:
        self._model, self._scale = scene.model, robot_scale(scene)
        self._parts = _parts(scene)
        if scene.marker is not None:  # solid, as all that lies on the floor: see `floor`
            own = self._model.geom_bodyid == self._model.body(scene.spec.robots[0]).id
            self._model.geom_rgba[own, 3] = 1.0
        self._opaque = (self._model.mat_rgba[:, 3].copy(), self._model.geom_rgba[:, 3].copy())
        self._dark = [[_colour_of(self._model, tyre) for tyre in each.tyres] for each in self._parts]

    def show(self, positions: np.ndarray, utilisation: np.ndarray | None) -> None:
        """Draws robots solid, but for those that stand inside another, with tyres coloured by what they use.

        Args:
            positions: of the robots with a body [m], shape (p, 2).
            utilisation: share of friction that each wheel uses, shape (p, 2), or None for tyres as they are.
        """
        for place, opacity in enumerate(fading(positions / self._scale)):
            self._set_opacity(place, opacity)
            if utilisation is not None:
                self._colour_tyres(place, utilisation[place], opacity)

    def show_ghosts(self, positions: np.ndarray, twins: np.ndarray) -> bool:
        """Draws the twins of robots translucent, the fainter the nearer a twin is to its robot.

        Returns whether there is any to see.

        Args:
            positions: of the robots with a body [m], shape (p, 2).
            twins: of their twins, the same shape, NaN where they are unknown.
        """
        apart = np.linalg.norm(twins - positions, axis=-1) / self._scale
        shares = np.nan_to_num(np.clip((apart - _COINCIDENT) / (_CLEAR - _COINCIDENT), 0.0, 1.0))
        for place, share in enumerate(shares):
            self._set_opacity(place, _GHOST * float(share))
            for tyre in self._parts[place].tyres:
                self._model.geom_rgba[tyre] = _DEFAULT
        return bool(shares.any())

    def _set_opacity(self, place: int, opacity: float) -> None:
        parts = self._parts[place]
        self._model.mat_rgba[parts.materials, 3] = opacity * self._opaque[0][parts.materials]
        self._model.geom_rgba[parts.plain, 3] = opacity * self._opaque[1][parts.plain]

    def _colour_tyres(self, place: int, used: np.ndarray, opacity: float) -> None:
        for tyre, dark, share in zip(self._parts[place].tyres, self._dark[place], used, strict=True):
            self._model.geom_rgba[tyre, :3] = utilisation_colour(float(share), dark)
            self._model.geom_rgba[tyre, 3] = opacity


def utilisation_colour(share: float, dark: np.ndarray) -> np.ndarray:
    """Returns the colour (3,) of a wheel that uses a share of its friction: as dark as it is, then ever brighter."""
    stops = np.vstack([dark, [rgb(colour) for colour in UTILISATION]])
    known = min(max(share, 0.0), 1.0) if np.isfinite(share) else float(share > 0)
    at = np.linspace(0.0, 1.0, len(stops))
    return np.array([np.interp(known, at, stops[:, k]) for k in range(3)])


def fading(positions: np.ndarray) -> np.ndarray:
    """Returns the opacity of robots of nh_mini's size, shape (n, 2) -> (n,): where they coincide, the last is solid.

    Without contact between robots a follower ends in its leader's place, and two like bodies in one place flicker.
    """
    count = len(positions)
    distance = np.linalg.norm(positions[:, None] - positions[None], axis=-1)
    hidden_by = np.where(np.triu(np.ones((count, count), bool), 1), distance, np.inf).min(axis=1)
    return np.asarray(np.clip((hidden_by - _COINCIDENT) / (_CLEAR - _COINCIDENT), 0.0, 1.0))


def robot_scale(scene: Scene) -> float:
    """Returns the size of a scene's robots over that of nh_mini, from what they may collide with."""
    if not scene.spec.bodies:
        return 1.0
    model, data = scene.model, mujoco.MjData(scene.model)
    mujoco.mj_kinematics(model, data)
    name = scene.spec.bodies[0]
    all_own = [g for g in range(model.ngeom) if model.geom(g).name.startswith(f"{name}/")]
    own = [g for g in all_own if model.geom_group[g] == 3] or all_own
    half = np.abs(data.geom_xpos[own, :2] - data.body(f"{name}/").xpos[:2]) + model.geom_aabb[own, 3:5]
    return float(half.max() / _NH_MINI)


def wheel_angles(pose: np.ndarray, wheel_radius: float, half_separation: float) -> np.ndarray:
    """Returns the wheel angles [rad] of robots that roll along poses (f, n, 3) without slip, shape (f, n, 2)."""
    step = np.diff(pose, axis=0, prepend=pose[:1])
    heading = pose[..., 2] - step[..., 2] / 2
    ahead = step[..., 0] * np.cos(heading) + step[..., 1] * np.sin(heading)
    turn = half_separation * step[..., 2]
    return np.asarray(np.cumsum(np.stack([ahead - turn, ahead + turn], axis=-1), axis=0) / wheel_radius)


def _parts(scene: Scene) -> list[_Parts]:
    model = scene.model
    found = []
    for name, tyres in zip(scene.spec.bodies, scene.addresses.tyres, strict=True):
        own = np.array([model.geom(k).name.startswith(f"{name}/") for k in range(model.ngeom)])
        left, right = (_drawn_tyre(model, int(tyre)) for tyre in tyres)
        plain = np.flatnonzero(own & (model.geom_matid < 0))
        found.append(_Parts(np.unique(model.geom_matid[own & (model.geom_matid >= 0)]), plain, (left, right)))
    return found


def _drawn_tyre(model: mujoco.MjModel, tyre: int) -> np.ndarray:
    """Returns the ids of the geoms that show a tyre: those of its wheel which look like its largest one."""
    shown = np.flatnonzero((model.geom_bodyid == model.geom_bodyid[tyre]) & (model.geom_group == 2))
    if not shown.size:
        return shown
    largest = shown[np.argmax(model.geom_rbound[shown])]
    return np.asarray(shown[model.geom_matid[shown] == model.geom_matid[largest]])


def _colour_of(model: mujoco.MjModel, geoms: np.ndarray) -> np.ndarray:
    """Returns the colour (3,) of the first of some geoms, black where there is none."""
    if not geoms.size:
        return np.zeros(3)
    material = model.geom_matid[geoms[0]]
    return np.array(model.mat_rgba[material, :3] if material >= 0 else model.geom_rgba[geoms[0], :3])
