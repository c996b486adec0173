"""A film's frames, whole: what the camera sees, what is written over it, and the live plot beside it."""

from __future__ import annotations

from types import TracebackType
from typing import TYPE_CHECKING

import numpy as np

from nhtrack.recording import Recording
from nhtrack.simulation.scene import make_scene
from nhtrack.video.bodies import robot_scale
from nhtrack.video.camera import plan_camera
from nhtrack.video.floor import FAR_DISC, root_radius
from nhtrack.video.overlay import Overlay
from nhtrack.video.render_options import QUALITIES, SPLIT, RenderOptions
from nhtrack.video.scene_renderer import SceneRenderer
from nhtrack.video.timeline import make_timeline

if TYPE_CHECKING:
    from nhtrack.video.chart import Beside, Chart

__all__ = ["FrameRenderer"]

_SPLIT_LETTERS = 0.85  # of what is written over a part of the picture, over those over a whole one
_ABOVE = 0.11  # [m at nh_mini's size] height of names above the floor


class FrameRenderer:
    """Draws any frame of a film; use as a context manager, which frees the OpenGL context.

    Args:
        recording: the run.
        look: how the film is made.
        backend: an OpenGL backend that is known to draw; by default one is looked for.

    Raises:
        RenderError: nothing draws.
    """

    def __init__(self, recording: Recording, look: RenderOptions, backend: str | None = None) -> None:
        scene = make_scene(recording.scene, share_materials=True)
        quality = QUALITIES[look.quality]
        timeline = make_timeline(recording, scene, look.fps, look.speed, quality.trail)
        self._length = len(timeline)
        view = look.size
        self._beside: Beside | None = None
        self._chart: Chart | None = None
        if look.camera == SPLIT:
            from nhtrack.video.chart import Chart, split  # Matplotlib, which every process of a crew would load

            view, self._beside = split(look.size)
            self._chart = Chart(recording, timeline, self._beside.size, look.size[1] / 480)
        camera = "group" if look.camera == SPLIT else look.camera
        fovy = float(scene.model.vis.global_.fovy)
        path = plan_camera(camera, timeline.pose, fovy, view[0] / view[1], look.fps, robot_scale(scene))
        self._size, self._view = look.size, view
        scale = robot_scale(scene)

        def above(frame: int) -> np.ndarray:
            """Returns the places above robots and above their discs as the picture has them, whichever are higher."""
            places = np.pad(timeline.pose[frame, :, :2], [(0, 0), (0, 1)])
            turn = np.radians(path.azimuth[frame])
            beyond = root_radius(scale, FAR_DISC * path.distance[frame]) * np.array([np.cos(turn), np.sin(turn), 0.0])
            high = path.project(frame, places + np.array([0.0, 0.0, _ABOVE * scale]), fovy, view)
            high[:, 1] = np.minimum(high[:, 1], path.project(frame, places + beyond, fovy, view)[:, 1])
            return high

        self._overlay = Overlay(recording, timeline, view, above, max(view[1], _SPLIT_LETTERS * look.size[1]) / 480)
        self._stage = SceneRenderer(scene, timeline, path, view, quality, backend)

    def __len__(self) -> int:
        """Returns the number of frames."""
        return self._length

    def __enter__(self) -> FrameRenderer:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stage.close()

    def scene(self, frame: int) -> np.ndarray:
        """Returns what the camera sees in a frame, with nothing written over it."""
        return self._stage.draw(frame)

    def paint(self, frame: int) -> np.ndarray:
        """Returns the picture of a frame, bytes of shape (height, width, 3)."""
        seen = self._overlay.write(self.scene(frame), frame)
        if self._chart is None or self._beside is None:
            return seen
        width, height = self._size
        picture = np.empty((height, width, 3), np.uint8)
        picture[: self._view[1], : self._view[0]] = seen
        x, y = self._beside.corner
        picture[y:, x:] = self._chart.draw(frame)
        return picture
