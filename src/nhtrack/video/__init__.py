"""Films of a recording, replayed from recorded coordinates; physics is never stepped."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from nhtrack import gl
from nhtrack.errors import RenderError
from nhtrack.files.atomic import atomic_path
from nhtrack.presentation.thinned import thinned
from nhtrack.recording import Recording
from nhtrack.video.camera import CAMERAS
from nhtrack.video.encode import FORMATS, Encoder, find_encoder, write_film
from nhtrack.video.render_options import QUALITIES, SPLIT, RenderOptions
from nhtrack.video.render_pool import Pictures, rendered
from nhtrack.video.timeline import frame_times

if TYPE_CHECKING:
    from nhtrack.experiment.loop import Progress

__all__ = ["CAMERAS", "QUALITIES", "SPLIT", "Encoder", "find_encoder", "frames", "render_film"]


def render_film(
    recording: Recording,
    path: Path,
    *,
    camera: str = "group",
    size: tuple[int, int] = (640, 480),
    fps: int = 30,
    speed: float | None = None,
    quality: str = "normal",
    processes: int = 1,
    progress: Progress | None = None,
) -> Path:
    """Writes a film of a recording and returns its path; the file appears once it is whole.

    Args:
        recording: the run; one that was interrupted is shown as far as it went.
        path: file to write: H.264 for a name that ends in .mp4, an animation of 256 colours for one in .gif.
        camera: `group` (follows and frames all robots), `isometric`, `top` (both the whole run), `chase` (the
            first follower), or `split` (`group` beside a live plot of the errors).
        size: width and height [pixels], both even.
        fps: frames per second.
        speed: robot seconds per second of film; by default the slowest round number that keeps the film short.
        quality: `draft` (no shadows, no antialiasing), `normal` or `high`.
        processes: how many draw; pictures are the same with any number. More than one are started by `spawn`, so
            a script that asks for them needs the usual `if __name__ == "__main__":`.
        progress: called with the number of frames done and their total.

    Raises:
        RenderError: OpenGL or ffmpeg is missing, or an argument makes no film; raised before any work.
        RecordingError: the recording lacks the scene it was made in.
    """
    target = Path(path)
    if target.suffix not in FORMATS:
        raise RenderError(f"{target}: expected a name ending in {' or '.join(FORMATS)}")
    look = RenderOptions(camera, size, fps, speed, quality)
    _check(recording, processes)
    find_encoder()
    gl.choose_backend()
    with atomic_path(target) as temporary, closing(_frames(recording, look, processes, progress)) as pictures:
        write_film(pictures, temporary, size, fps)
    return target


def frames(
    recording: Recording,
    *,
    camera: str = "group",
    size: tuple[int, int] = (640, 480),
    fps: int = 30,
    speed: float | None = None,
    quality: str = "normal",
    processes: int = 1,
    progress: Progress | None = None,
) -> Iterator[np.ndarray]:
    """Yields the pictures of a film, bytes of shape (height, width, 3); arguments as `render_film`.

    A generator that is left half-way wants to be closed, which frees its OpenGL context.

    Raises:
        RenderError: OpenGL is missing, or an argument makes no film.
        RecordingError: the recording lacks the scene it was made in.
    """
    yield from _frames(recording, RenderOptions(camera, size, fps, speed, quality), processes, progress)


def _frames(recording: Recording, look: RenderOptions, processes: int, progress: Progress | None) -> Pictures:
    _check(recording, processes)
    at, _ = frame_times(recording.time, look.fps, look.speed)
    total, pictures = rendered(thinned(recording, at), look, processes)
    with closing(pictures):
        for frame, picture in enumerate(pictures):
            yield picture
            if progress is not None:
                progress(frame + 1, total)


def _check(recording: Recording, processes: int) -> None:
    recording.scene  # noqa: B018 - raises where there is none
    if processes < 1:
        raise RenderError(f"processes {processes}: expected at least 1")
