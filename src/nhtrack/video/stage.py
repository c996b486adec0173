"""Draws frames: the scene at recorded coordinates, trails on the floor, light where the robots are."""

from __future__ import annotations

import itertools
from types import TracebackType

import mujoco
import numpy as np

from nhtrack import gl, se2
from nhtrack.errors import RenderError
from nhtrack.simulation.scene import Scene
from nhtrack.video.camera import CameraPath
from nhtrack.video.timeline import Timeline

__all__ = ["Stage", "fading", "robot_scale"]

_SPARE_GEOMS = 200  # room for what MuJoCo itself adds to a scene
_TRAIL_HEIGHT, _TRAIL_WIDTH = 0.002, 2.5  # [m], [pixels at 480 lines]
_COINCIDENT, _CLEAR = (
    0.015,
    0.06,
)  # [m] robots nearer than the first are one to the eye, beyond the second they are apart
_DISC, _FAR_DISC = 0.085, 0.016  # [m] radius of the root's disc; of all discs, per metre from the camera
_CHEVRON = np.array([[1.05, 0.6], [1.7, 0.0], [1.05, -0.6]])  # ahead of a disc of unit radius, nose along +x
_LINE_SHADE = np.array(
    [0.5, 0.5, 0.5, 1.0], np.float32
)  # lines catch all the light at once: this gives their colour back
_NH_MINI = 0.06  # [m] from the axle midpoint to the side of nh_mini, for which lengths above are meant
_LIT_WIDTH = 1.1  # [m] half width of the floor that the key light reaches from its own height


class Stage:
    """An open off-screen renderer of one film; use as a context manager, which frees the OpenGL context.

    Args:
        scene: the compiled scene; its model's picture quality and light are changed.
        timeline: the film.
        camera: the camera's path.
        size: width and height of the picture [pixels].

    Raises:
        RenderError: nothing draws.
    """

    def __init__(self, scene: Scene, timeline: Timeline, camera: CameraPath, size: tuple[int, int]) -> None:
        self._scene, self._timeline, self._path, self._size = scene, timeline, camera, size
        model = scene.model
        self._looks, self._scale = _looks(scene), robot_scale(scene)
        _set_quality(scene, size, camera.distance)
        self._opaque = (model.mat_rgba[:, 3].copy(), model.geom_rgba[:, 3].copy())
        self._data = mujoco.MjData(model)
        trail = sum(each.time.size + 4 for each in timeline.trails)
        self._visual = mujoco.MjvScene(model, model.ngeom + trail + _SPARE_GEOMS)
        self._visual.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = len(scene.spec.robots) <= 20
        self._camera, self._options = mujoco.MjvCamera(), mujoco.MjvOption()
        self._key, self._key_offset = _key_light(model)
        self._context = gl.make_context(*size)
        try:
            self._render = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
            mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._render)
            if self._render.currentBuffer != mujoco.mjtFramebuffer.mjFB_OFFSCREEN:
                raise RenderError(f"this OpenGL has no off-screen buffer of {size[0]} x {size[1]} pixels")
        except BaseException:
            self._context.free()
            raise

    def __enter__(self) -> Stage:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._render.free()
        self._context.free()

    def draw(self, frame: int) -> np.ndarray:
        """Returns the picture of one frame, bytes of shape (height, width, 3)."""
        model, data, visual = self._scene.model, self._data, self._visual
        self._pose(frame)
        self._path.place(self._camera, frame)
        everything = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(model, data, self._options, None, self._camera, everything, visual)
        self._add_trails(frame)
        self._add_pointers(frame)
        width, height = self._size
        picture = np.empty((height, width, 3), np.uint8)
        view = mujoco.MjrRect(0, 0, width, height)
        self._context.make_current()
        mujoco.mjr_render(view, visual, self._render)
        mujoco.mjr_readPixels(picture, None, view, self._render)
        return np.asarray(picture[::-1])  # OpenGL counts rows from below

    def _pose(self, frame: int) -> None:
        """Puts bodies, marker and light where they are in a frame; kinematics only, no physics."""
        model, data = self._scene.model, self._data
        data.qpos[:] = self._timeline.qpos[frame]
        if self._scene.marker is not None:
            x, y, theta = self._timeline.pose[frame, 0]
            data.mocap_pos[self._scene.marker] = (x, y, 0.0)
            data.mocap_quat[self._scene.marker] = (np.cos(theta / 2), 0.0, 0.0, np.sin(theta / 2))
        if self._key is not None:
            # The further the camera, the higher the light: the patch it lights grows with the picture
            height = max(1.0, 0.6 * float(self._path.distance[frame]) / _LIT_WIDTH)
            model.light_pos[self._key] = self._path.lookat[frame] + height * self._key_offset
        self._fade(frame)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_camlight(model, data)

    def _fade(self, frame: int) -> None:
        model = self._scene.model
        first = len(self._scene.spec.robots) - len(self._looks)
        opacity = fading(self._timeline.pose[frame, first:, :2] / self._scale)
        for (materials, geoms), alpha in zip(self._looks, opacity, strict=True):
            model.mat_rgba[materials, 3] = alpha * self._opaque[0][materials]
            model.geom_rgba[geoms, 3] = alpha * self._opaque[1][geoms]

    def _add_trails(self, frame: int) -> None:
        """Adds where each robot has been, followers above their leader."""
        width, now = _TRAIL_WIDTH * self._size[1] / 480, self._timeline.time[frame]
        for place, trail in enumerate(self._timeline.trails):
            so_far = int(np.searchsorted(trail.time, now, side="right"))
            way = np.vstack([trail.points[:so_far], self._timeline.pose[frame, place, :2]])
            height = np.full((len(way), 1), self._scale * (_TRAIL_HEIGHT + 0.0002 * place))
            self._add_line(np.hstack([way, height]), self._rgba(place, 1.0), 1.6 * width if place == 0 else width)

    def _add_pointers(self, frame: int) -> None:
        """Adds discs and chevrons on the floor: where small robots are and head, and whose place the root holds."""
        scale, radius = self._scale, _FAR_DISC * float(self._path.distance[frame])
        share = float(np.clip((radius / scale - 0.022) / 0.02, 0.0, 1.0))
        width = _TRAIL_WIDTH * self._size[1] / 480
        poses = self._timeline.pose[frame]
        shares = share * fading(poses[:, :2] / scale)
        shares[0] = 1.0 if self._scene.marker is not None else shares[0]  # a marker's heading is its chevron's
        self._add_disc(poses[0], max(scale * _DISC, 1.15 * radius), scale * 0.0006, self._rgba(0, 0.55))
        size = max(scale * _NH_MINI, radius)
        for place in map(int, np.flatnonzero(shares)):
            if place:
                height = scale * (0.0008 + 0.0002 * place)
                self._add_disc(poses[place], size, height, self._rgba(place, 0.5 * shares[place]))
            points = np.column_stack([se2.act(poses[place][None], size * _CHEVRON), np.full(3, scale * _TRAIL_HEIGHT)])
            self._add_line(points, self._rgba(place, shares[place]), 1.6 * width)

    def _add_disc(self, pose: np.ndarray, radius: float, height: float, rgba: np.ndarray) -> None:
        size, centre = np.array([radius, 0.0002, 0.0]), np.array([pose[0], pose[1], height])
        geom = self._next_geom()
        mujoco.mjv_initGeom(geom, mujoco.mjtGeom.mjGEOM_CYLINDER, size, centre, np.eye(3).ravel(), rgba)
        geom.category, geom.emission, geom.specular = mujoco.mjtCatBit.mjCAT_DECOR, 0.0, 0.0

    def _add_line(self, points: np.ndarray, rgba: np.ndarray, width: float) -> None:
        line, identity, nothing = mujoco.mjtGeom.mjGEOM_LINE, np.eye(3).ravel(), np.zeros(3)
        for start, end in itertools.pairwise(points):
            geom = self._next_geom()
            mujoco.mjv_initGeom(geom, line, nothing, nothing, identity, rgba * _LINE_SHADE)
            geom.category, geom.emission, geom.specular = mujoco.mjtCatBit.mjCAT_DECOR, 0.0, 0.0
            mujoco.mjv_connector(geom, line, width, start, end)

    def _rgba(self, place: int, alpha: float) -> np.ndarray:
        colour = self._scene.spec.colour(place)
        return np.array([*(int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)), alpha], np.float32)

    def _next_geom(self) -> mujoco.MjvGeom:
        self._visual.ngeom += 1
        return self._visual.geoms[self._visual.ngeom - 1]


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
    own = [g for g in range(model.ngeom) if model.geom(g).name.startswith(f"{name}/") and model.geom_group[g] == 3]
    half = np.abs(data.geom_xpos[own, :2] - data.body(f"{name}/").xpos[:2]) + model.geom_aabb[own, 3:5]
    return float(half.max() / _NH_MINI)


def _looks(scene: Scene) -> list[tuple[np.ndarray, np.ndarray]]:
    """Returns for each robot with a body the ids of its materials and of its geoms without one."""
    model = scene.model
    looks = []
    for name in scene.spec.bodies:
        own = np.array([model.geom(k).name.startswith(f"{name}/") for k in range(model.ngeom)])
        materials = np.unique(model.geom_matid[own & (model.geom_matid >= 0)])
        looks.append((materials, np.flatnonzero(own & (model.geom_matid < 0))))
    return looks


def _set_quality(scene: Scene, size: tuple[int, int], distance: np.ndarray) -> None:
    """Sets what a software renderer can draw at film speed, and clipping planes that hold the whole scene.

    Beyond the share of the far plane at which haze begins the floor is drawn over what lies flat on it: robots, however
    far from the camera, have to be nearer. The near plane keeps the digits of depth.
    """
    model, robots = scene.model, len(scene.spec.robots)
    quality, picture, planes = model.vis.quality, model.vis.global_, model.vis.map
    quality.offsamples = 4
    quality.shadowsize = 1024
    quality.numslices, quality.numstacks, quality.numquads = (20, 3, 1) if robots <= 20 else (12, 3, 1)
    if any(patch.disc is not None for patch in scene.spec.patches):
        quality.numslices = 48  # a disc on the floor is many times larger than a wheel, and its corners show
    picture.offwidth, picture.offheight = max(picture.offwidth, size[0]), max(picture.offheight, size[1])
    planes.znear = max(planes.znear, 0.1 * float(distance.min()) / model.stat.extent)
    planes.zfar = max(planes.zfar, 6 * float(distance.max()) / model.stat.extent)


def _key_light(model: mujoco.MjModel) -> tuple[int | None, np.ndarray]:
    """Returns the light that casts shadows, or None, and its offset from what it is to light."""
    casting = np.flatnonzero(model.light_castshadow)
    if casting.size == 0:
        return None, np.zeros(3)
    return int(casting[0]), model.light_pos[casting[0]].copy()
