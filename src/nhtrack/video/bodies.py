"""How solid and of what colour each robot's body is drawn: the model's looks, changed from frame to frame."""

from __future__ import annotations

import mujoco
import numpy as np
from scipy.spatial import cKDTree

from nhtrack.colours import UTILISATION, rgb
from nhtrack.simulation.scene import Scene

__all__ = ["Bodies", "fading", "robot_scale", "utilisation_colour", "wheel_angles"]

_COINCIDENT, _CLEAR = 0.015, 0.06  # [m] nearer than the first robots are one to the eye, beyond the second apart
GHOST = 0.38  # opacity of an ideal twin
_NH_MINI = 0.06  # [m] from the axle midpoint to the side of nh_mini, for which lengths of this package are meant
HIDDEN = 5  # a group that MuJoCo does not draw
_DEFAULT = np.array([0.5, 0.5, 0.5, 1.0], np.float32)  # a geom of this colour has its material's


class Bodies:
    """The looks of a scene's robots; changes the scene's model.

    Args:
        scene: the compiled scene.
    """

    def __init__(self, scene: Scene) -> None:
        model = self._model = scene.model
        self._scale = robot_scale(scene)
        if scene.marker is not None:  # solid, as all that lies on the floor: see `floor`
            own = model.geom_bodyid == model.body(scene.spec.robots[0]).id
            model.geom_rgba[own, 3] = 1.0
        owner = owners(scene)
        self._geoms = np.flatnonzero(owner >= 0)
        self._owner = owner[self._geoms]
        looks = _looks(model)
        self._looks = looks[self._geoms]
        self._tyres = [[_drawn_tyre(model, int(tyre)) for tyre in pair] for pair in scene.addresses.tyres]
        first = self._tyres[0] if self._tyres else []  # robots are alike
        self._dark = [looks[tyre[0], :3] if tyre.size else np.zeros(3) for tyre in first]

    def show(self, positions: np.ndarray, utilisation: np.ndarray | None) -> None:
        """Draws robots solid, but for those that stand inside another, with tyres coloured by what they use.

        Args:
            positions: of the robots with a body [m], shape (p, 2).
            utilisation: share of friction that each wheel uses, shape (p, 2), or None for tyres as they are.
        """
        opacities = fading(positions / self._scale)
        self._draw(opacities)
        if utilisation is not None:
            self._colour_tyres(utilisation, opacities)

    def show_ghosts(self, positions: np.ndarray, twins: np.ndarray) -> bool:
        """Draws the twins of robots translucent, the fainter the nearer a twin is to its robot.

        Returns whether there is any to see.

        Args:
            positions: of the robots with a body [m], shape (p, 2).
            twins: of their twins, the same shape, NaN where they are unknown.
        """
        apart = np.linalg.norm(twins - positions, axis=-1) / self._scale
        shares = np.nan_to_num(np.clip((apart - _COINCIDENT) / (_CLEAR - _COINCIDENT), 0.0, 1.0))
        self._draw(GHOST * shares)
        return bool(shares.any())

    def leave_out(self, size: float) -> None:
        """Draws no parts that are smaller than a size [m]."""
        small = 2 * self._model.geom_rbound[self._geoms] < size
        self._model.geom_group[self._geoms[small]] = HIDDEN

    def _draw(self, opacities: np.ndarray) -> None:
        """Draws robots as they look, of some opacity (p,).

        Geoms get colours of their own, which count for more than those of their materials: robots share these.
        """
        self._model.geom_rgba[self._geoms, :3] = self._looks[:, :3]
        self._model.geom_rgba[self._geoms, 3] = opacities[self._owner] * self._looks[:, 3]

    def _colour_tyres(self, used: np.ndarray, opacities: np.ndarray) -> None:
        colours = [utilisation_colour(used[:, side], dark) for side, dark in enumerate(self._dark)]
        for place, (pair, opacity) in enumerate(zip(self._tyres, opacities, strict=True)):
            for side, tyre in enumerate(pair):
                self._model.geom_rgba[tyre, :3] = colours[side][place]
                self._model.geom_rgba[tyre, 3] = opacity


def utilisation_colour(share: float | np.ndarray, dark: np.ndarray) -> np.ndarray:
    """Returns the colour of wheels that use a share of their friction: as dark as they are, then ever brighter.

    Args:
        share: any shape; what is infinite is all, what is unknown is none.
        dark: colour of wheels that use none, shape (3,).

    Returns:
        Colours, shape (..., 3).
    """
    stops = np.vstack([dark, [rgb(colour) for colour in UTILISATION]])
    known = np.clip(np.nan_to_num(share, nan=0.0, posinf=1.0, neginf=0.0), 0.0, 1.0)
    at = np.linspace(0.0, 1.0, len(stops))
    return np.stack([np.interp(known, at, stops[:, k]) for k in range(3)], axis=-1)


def fading(positions: np.ndarray) -> np.ndarray:
    """Returns the opacity of robots of nh_mini's size, shape (n, 2) -> (n,): where they coincide, the last is solid.

    Without contact between robots a follower ends in its leader's place, and two like bodies in one place flicker.
    """
    hidden_by = np.full(len(positions), np.inf)
    known = np.flatnonzero(np.isfinite(positions).all(axis=1))
    pairs = known[cKDTree(positions[known]).query_pairs(_CLEAR, output_type="ndarray")]  # the earlier one first
    np.minimum.at(hidden_by, pairs[:, 0], np.linalg.norm(positions[pairs[:, 0]] - positions[pairs[:, 1]], axis=-1))
    return np.asarray(np.clip((hidden_by - _COINCIDENT) / (_CLEAR - _COINCIDENT), 0.0, 1.0))


def robot_scale(scene: Scene) -> float:
    """Returns the size of a scene's robots over that of nh_mini, from what they may collide with."""
    if not scene.spec.bodies:
        return 1.0
    model, data = scene.model, mujoco.MjData(scene.model)
    mujoco.mj_kinematics(model, data)
    name = scene.spec.bodies[0]
    all_own = np.flatnonzero(owners(scene) == 0)
    solid = all_own[model.geom_group[all_own] == 3]
    own = solid if solid.size else all_own
    half = np.abs(data.geom_xpos[own, :2] - data.body(f"{name}/").xpos[:2]) + model.geom_aabb[own, 3:5]
    return float(half.max() / _NH_MINI)


def wheel_angles(pose: np.ndarray, wheel_radius: float, half_separation: float) -> np.ndarray:
    """Returns the wheel angles [rad] of robots that roll along poses (f, n, 3) without slip, shape (f, n, 2)."""
    step = np.diff(pose, axis=0, prepend=pose[:1])
    heading = pose[..., 2] - step[..., 2] / 2
    ahead = step[..., 0] * np.cos(heading) + step[..., 1] * np.sin(heading)
    turn = half_separation * step[..., 2]
    return np.asarray(np.cumsum(np.stack([ahead - turn, ahead + turn], axis=-1), axis=0) / wheel_radius)


def owners(scene: Scene) -> np.ndarray:
    """Returns whose each geom is, as the robot's place among those with a body, or -1; shape (ngeom,)."""
    model = scene.model
    place = np.full(model.nbody, -1)
    place[[model.body(f"{name}/").id for name in scene.spec.bodies]] = np.arange(len(scene.spec.bodies))
    return np.asarray(place[model.body_rootid[model.geom_bodyid]])


def _looks(model: mujoco.MjModel) -> np.ndarray:
    """Returns red, green, blue and opacity of every geom: its own, or by default its material's; shape (ngeom, 4)."""
    by_material = (model.geom_matid >= 0) & (model.geom_rgba == _DEFAULT).all(axis=1)
    return np.asarray(np.where(by_material[:, None], model.mat_rgba[model.geom_matid], model.geom_rgba))


def _drawn_tyre(model: mujoco.MjModel, tyre: int) -> np.ndarray:
    """Returns the ids of the geoms that show a tyre: those of its wheel which look like its largest one."""
    shown = np.flatnonzero((model.geom_bodyid == model.geom_bodyid[tyre]) & (model.geom_group == 2))
    if not shown.size:
        return shown
    largest = shown[np.argmax(model.geom_rbound[shown])]
    return np.asarray(shown[model.geom_matid[shown] == model.geom_matid[largest]])
