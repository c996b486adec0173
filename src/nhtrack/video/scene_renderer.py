"""Draws frames: the scene at recorded coordinates, its ghosts, the floor's marks, light where the robots are."""

from __future__ import annotations

from types import TracebackType

import mujoco
import numpy as np

from nhtrack import gl
from nhtrack.errors import RenderError
from nhtrack.simulation.scene import Scene
from nhtrack.video.bodies import Bodies, robot_scale, wheel_angles
from nhtrack.video.camera import CameraPath
from nhtrack.video.floor import FloorLines
from nhtrack.video.render_options import FLEET, MANY, QUALITIES, Quality
from nhtrack.video.timeline import Timeline

__all__ = ["SceneRenderer"]

_SPARE_GEOMS = 200  # room for what MuJoCo itself adds to a scene
_OUT_OF_SIGHT = (0.0, 0.0, -100.0)  # [m]
_SHADOWED = 0.2  # share of the key light's angle in which it casts shadows: the picture's width of floor
_VISIBLE = 2.0  # [pixels] smallest part that is drawn of each of a fleet's robots, where they are nearest
_LIT_WIDTH = 1.1  # [m] half width of the floor that the key light reaches from its own height


class SceneRenderer:
    """An open off-screen renderer of one film; use as a context manager, which frees the OpenGL context.

    Args:
        scene: the compiled scene; its model's picture quality, light and colours are changed.
        timeline: the film.
        camera: the camera's path.
        size: width and height of the picture [pixels].
        quality: what to spend on it.
        backend: an OpenGL backend that is known to draw; by default one is looked for.

    Raises:
        RenderError: nothing draws.
    """

    def __init__(
        self,
        scene: Scene,
        timeline: Timeline,
        camera: CameraPath,
        size: tuple[int, int],
        quality: Quality = QUALITIES["normal"],
        backend: str | None = None,
    ) -> None:
        self._scene, self._timeline, self._path, self._size = scene, timeline, camera, size
        model = scene.model
        _set_quality(scene, size, camera.distance, quality)
        shadows = _shadow(scene, quality) > 0
        self._bodies, self._embodied = Bodies(scene), slice(scene.spec.first_body, None)
        if len(scene.spec.robots) > FLEET:
            half = np.tan(np.radians(model.vis.global_.fovy) / 2)
            self._bodies.leave_out(_VISIBLE * 2 * half * float(camera.distance.min()) / size[1])
        self._floor = FloorLines(scene, timeline, robot_scale(scene), size[1], shadows)
        self._data, self._twin_data = mujoco.MjData(model), mujoco.MjData(model)
        self._twin_qpos = _twin_qpos(scene, timeline)
        self._visual = mujoco.MjvScene(model, 2 * model.ngeom + self._floor.room + _SPARE_GEOMS)
        self._visual.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = shadows
        self._camera, self._options, self._nothing = mujoco.MjvCamera(), mujoco.MjvOption(), mujoco.MjvPerturb()
        self._key, self._key_offset = _key_light(model)
        self._context = gl.make_context(*size, backend)
        try:
            self._render = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
            mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._render)
            if self._render.currentBuffer != mujoco.mjtFramebuffer.mjFB_OFFSCREEN:
                raise RenderError(f"this OpenGL has no off-screen buffer of {size[0]} x {size[1]} pixels")
        except BaseException:
            self._context.free()
            raise

    def __enter__(self) -> SceneRenderer:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Frees the OpenGL context."""
        self._context.make_current()  # another stage may have been drawn since
        self._render.free()
        self._context.free()

    def draw(self, frame: int) -> np.ndarray:
        """Returns the picture of one frame, bytes of shape (height, width, 3)."""
        self._path.place(self._camera, frame)
        self._add_robots(frame)
        self._add_ghosts(frame)
        self._floor.add(self._visual, frame, float(self._path.distance[frame]))
        width, height = self._size
        picture = np.empty((height, width, 3), np.uint8)
        view = mujoco.MjrRect(0, 0, width, height)
        self._context.make_current()
        mujoco.mjr_render(view, self._visual, self._render)
        mujoco.mjr_readPixels(picture, None, view, self._render)
        return np.asarray(picture[::-1])  # OpenGL counts rows from below

    def _add_robots(self, frame: int) -> None:
        """Puts bodies, marker and light where they are in a frame; kinematics only, no physics."""
        model, data, timeline = self._scene.model, self._data, self._timeline
        data.qpos[:] = timeline.qpos[frame]
        if self._scene.marker is not None:
            x, y, theta = timeline.pose[frame, 0]
            data.mocap_pos[self._scene.marker] = (x, y, 0.0)
            data.mocap_quat[self._scene.marker] = (np.cos(theta / 2), 0.0, 0.0, np.sin(theta / 2))
        if self._key is not None:
            # The further the camera, the higher the light: the patch it lights grows with the picture
            height = max(1.0, 0.6 * float(self._path.distance[frame]) / _LIT_WIDTH)
            model.light_pos[self._key] = self._path.lookat[frame] + height * self._key_offset
        used = None if timeline.utilisation is None else timeline.utilisation[frame, self._embodied]
        self._bodies.show(timeline.pose[frame, self._embodied, :2], used)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_camlight(model, data)
        # The endless floor is centred below the camera of the scene as it stands: without this, that of another frame
        mujoco.mjv_updateCamera(model, data, self._camera, self._visual)
        everything = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(model, data, self._options, self._nothing, self._camera, everything, self._visual)

    def _add_ghosts(self, frame: int) -> None:
        """Adds the ideal twins that are not where their robots are."""
        if self._twin_qpos is None or self._timeline.twin is None:
            return
        positions, twins = (poses[frame, self._embodied, :2] for poses in (self._timeline.pose, self._timeline.twin))
        if not self._bodies.show_ghosts(positions, twins):
            return
        self._twin_data.qpos[:] = self._twin_qpos[frame]
        self._twin_data.mocap_pos[:] = _OUT_OF_SIGHT  # a marker has no twin
        model, moving = self._scene.model, mujoco.mjtCatBit.mjCAT_DYNAMIC
        mujoco.mj_kinematics(model, self._twin_data)
        mujoco.mjv_addGeoms(model, self._twin_data, self._options, self._nothing, moving, self._visual)


def _twin_qpos(scene: Scene, timeline: Timeline) -> np.ndarray | None:
    """Returns MuJoCo coordinates of the twins, shape (f, nq), or None; those that are unknown lie at the origin."""
    if timeline.twin is None or not scene.spec.bodies:
        return None
    twin = np.nan_to_num(timeline.twin[:, scene.spec.first_body :], posinf=0.0, neginf=0.0)
    angles = wheel_angles(twin, scene.drive.wheel_radius, scene.drive.half_separation)
    return np.asarray(scene.qpos_of(twin, angles))


def _shadow(scene: Scene, quality: Quality) -> int:
    return quality.crowd_shadow if len(scene.spec.robots) > MANY else quality.shadow


def _set_quality(scene: Scene, size: tuple[int, int], distance: np.ndarray, wanted: Quality) -> None:
    """Sets what the renderer spends, and clipping planes that hold the whole scene.

    Beyond the share of the far plane at which haze begins the floor is drawn over what lies flat on it: robots, however
    far from the camera, have to be nearer. The near plane keeps the digits of depth; nearer to the robots than this it
    would take them from the bias of the shadows, and the floor would show acne.
    """
    model = scene.model
    quality, picture, planes = model.vis.quality, model.vis.global_, model.vis.map
    quality.offsamples = wanted.samples
    quality.shadowsize = max(_shadow(scene, wanted), 1)
    crowd = len(scene.spec.robots) > MANY
    quality.numslices, quality.numstacks, quality.numquads = (wanted.slices * 3 // 5 if crowd else wanted.slices), 3, 1
    if any(patch.disc is not None for patch in scene.spec.ground.patches) or (wanted.samples and not crowd):
        quality.numslices = 48  # a disc on the floor is larger than a wheel, and its corners show
    picture.offwidth, picture.offheight = max(picture.offwidth, size[0]), max(picture.offheight, size[1])
    planes.znear = max(planes.znear, 0.02 * float(distance.min()) / model.stat.extent)
    planes.shadowscale = _SHADOWED
    planes.zfar = max(planes.zfar, 6 * float(distance.max()) / model.stat.extent)


def _key_light(model: mujoco.MjModel) -> tuple[int | None, np.ndarray]:
    """Returns the light that casts shadows, or None, and its offset from what it is to light."""
    casting = np.flatnonzero(model.light_castshadow)
    if casting.size == 0:
        return None, np.zeros(3)
    return int(casting[0]), model.light_pos[casting[0]].copy()
