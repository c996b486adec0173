"""How much of a picture a robot covers."""

from __future__ import annotations

import mujoco
import numpy as np

from nhtrack import gl
from nhtrack.arrays import Array
from nhtrack.simulation.scene import Scene

__all__ = ["covered"]

_WIDTH, _HEIGHT = 240, 180  # [pixels]
_CHANGED = 12  # of 255: more than a shadow's noise


def covered(scene: Scene, size: float) -> float:
    """Returns the share of a picture that changes where the robot of a scene is taken away.

    Args:
        scene: of one robot.
        size: of the robot [m]; the camera stands ten times as far away.

    Raises:
        RenderError: nothing draws.
    """
    data = mujoco.MjData(scene.model)
    context = gl.make_context(_WIDTH, _HEIGHT)
    try:
        render = mujoco.MjrContext(scene.model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, render)
        with_robot = _picture(scene.model, data, render, size)
        root = scene.model.joint("robot/root/")
        data.qpos[int(root.qposadr[0]) + 2] -= 1e3 * size
        without = _picture(scene.model, data, render, size)
        render.free()
    finally:
        context.free()
    return float((np.abs(with_robot - without).max(axis=-1) > _CHANGED).mean())


def _picture(model: mujoco.MjModel, data: mujoco.MjData, render: mujoco.MjrContext, size: float) -> Array:
    """Returns what a camera sees that looks at the scene's origin, shape (height, width, 3)."""
    mujoco.mj_forward(model, data)
    camera = mujoco.MjvCamera()
    camera.lookat[:], camera.distance, camera.azimuth, camera.elevation = (0.0, 0.0, size / 2), 10 * size, 150, -25
    seen, everything = mujoco.MjvScene(model, 10_000), mujoco.mjtCatBit.mjCAT_ALL
    mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, camera, everything, seen)
    whole, pixels = mujoco.MjrRect(0, 0, _WIDTH, _HEIGHT), np.zeros((_HEIGHT, _WIDTH, 3), np.uint8)
    mujoco.mjr_render(whole, seen, render)
    mujoco.mjr_readPixels(pixels, None, whole, render)
    return pixels.astype(int)
