"""Films of a recording, replayed from recorded coordinates; physics is never stepped."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from nhtrack import gl
from nhtrack.errors import RecordingError, RenderError, did_you_mean
from nhtrack.recording import Recording, atomic_path
from nhtrack.simulation.scene import SceneSpec, make_scene
from nhtrack.video.camera import CAMERAS, CameraPath, floor_footprint, plan_camera
from nhtrack.video.encode import Encoder, find_encoder, write_mp4
from nhtrack.video.overlay import Overlay
from nhtrack.video.stage import Stage, robot_scale
from nhtrack.video.timeline import Timeline, make_timeline

__all__ = ["CAMERAS", "Encoder", "find_encoder", "frames", "render"]

Progress = Callable[[int, int], None]


def render(
    recording: Recording,
    path: Path,
    *,
    camera: str = "group",
    size: tuple[int, int] = (640, 480),
    fps: int = 30,
    speed: float | None = None,
    progress: Progress | None = None,
) -> Path:
    """Writes a film of a recording as H.264 in MP4 and returns its path; the file appears once it is whole.

    Args:
        recording: the run; one that was interrupted is shown as far as it went.
        path: file to write, ending in .mp4.
        camera: `group` (follows and frames all robots), `isometric`, `top` (both the whole run), `chase` (the root).
        size: width and height [pixels], both even.
        fps: frames per second.
        speed: robot seconds per second of film; by default the slowest round number that keeps the film short.
        progress: called with the number of frames done and their total.

    Raises:
        RenderError: OpenGL or ffmpeg is missing, or an argument makes no film; raised before any work.
        RecordingError: the recording lacks the scene it was made in.
    """
    target = Path(path)
    _check(target, camera, size, fps, speed)
    find_encoder()
    gl.choose_backend()
    with atomic_path(target) as temporary:
        pictures = frames(recording, camera=camera, size=size, fps=fps, speed=speed, progress=progress)
        write_mp4(pictures, temporary, size, fps)
    return target


def frames(
    recording: Recording,
    *,
    camera: str = "group",
    size: tuple[int, int] = (640, 480),
    fps: int = 30,
    speed: float | None = None,
    progress: Progress | None = None,
) -> Iterator[np.ndarray]:
    """Yields the pictures of a film, bytes of shape (height, width, 3); arguments as `render`.

    Raises:
        RenderError: OpenGL is missing, or no camera of that name.
        RecordingError: the recording lacks the scene it was made in.
    """
    if "scene" not in recording.dataset.attrs:
        raise RecordingError("this recording does not say which scene it was made in: it cannot be filmed")
    scene = make_scene(SceneSpec.from_json(recording.dataset.attrs["scene"]))
    timeline = make_timeline(recording, scene, fps, speed)
    fovy, aspect = float(scene.model.vis.global_.fovy), size[0] / size[1]
    path = plan_camera(camera, timeline.pose, fovy, aspect, fps, robot_scale(scene))
    overlay = Overlay(recording, timeline, size)
    reach = _span(timeline)
    with Stage(scene, timeline, path, size) as stage:
        for frame in range(len(timeline)):
            footprint = floor_footprint(path, frame, fovy, aspect, reach) if _moves(path) else None
            yield overlay.write(stage.draw(frame), frame, footprint)
            if progress is not None:
                progress(frame + 1, len(timeline))


def _check(path: Path, camera: str, size: tuple[int, int], fps: int, speed: float | None) -> None:
    if path.suffix != ".mp4":
        raise RenderError(f"{path}: films are MP4; expected a name ending in .mp4")
    if camera not in CAMERAS:
        raise RenderError(f"no camera {camera!r}; {did_you_mean(camera, CAMERAS)}")
    if min(size) < 64 or size[0] % 2 or size[1] % 2:
        raise RenderError(f"size {size[0]} x {size[1]}: expected even numbers of pixels, at least 64")
    if fps < 1:
        raise RenderError(f"fps {fps}: expected at least 1 frame per second")
    if speed is not None and not 0 < speed < float("inf"):
        raise RenderError(f"speed {speed}: expected a positive number of robot seconds per second of film")


def _span(timeline: Timeline) -> float:
    positions = timeline.pose[..., :2]
    return 2.0 * float(np.hypot(*(positions.max(axis=(0, 1)) - positions.min(axis=(0, 1))))) + 1.0


def _moves(path: CameraPath) -> bool:
    """Returns whether the camera moves; where it holds the whole run anyway, its outline on the map says nothing."""
    return bool(np.ptp(path.lookat, axis=0).max() > 1e-9)
