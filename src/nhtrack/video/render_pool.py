"""Frames in their order, drawn here or in processes side by side.

A frame depends on nothing but the recording and its number, so whoever draws it draws the same pixels.
"""

from __future__ import annotations

from collections.abc import Generator
from contextlib import closing

import numpy as np

from nhtrack import gl
from nhtrack.execution import Processes
from nhtrack.recording import Recording
from nhtrack.video.frame_renderer import FrameRenderer
from nhtrack.video.render_options import RenderOptions
from nhtrack.video.timeline import frame_times

__all__ = ["Pictures", "rendered"]

Pictures = Generator[np.ndarray, None, None]

_AHEAD = 4  # frames a worker may be ahead of the film: enough to even out, few enough to hold in memory
_WORTH = 60  # frames, and as many as there are robots, below which another process costs more than it draws


def rendered(recording: Recording, look: RenderOptions, processes: int) -> tuple[int, Pictures]:
    """Returns how many frames a film has, and a generator of their pictures, bytes of shape (height, width, 3).

    Raises:
        RenderError: nothing draws; raised by the generator.
        WorkerError: a process ended; raised by the generator.
    """
    total = len(frame_times(recording.time, look.fps, look.speed)[0])
    workers = min(processes, max(1, total // (_WORTH + len(recording.robots))))
    return total, (_alone(recording, look) if workers == 1 else _together(recording, look, workers, total))


def _alone(recording: Recording, look: RenderOptions) -> Pictures:
    with FrameRenderer(recording, look) as renderer:
        for frame in range(len(renderer)):
            yield renderer.paint(frame)


def _together(recording: Recording, look: RenderOptions, processes: int, total: int) -> Pictures:
    start = (Recording(recording.dataset.load()), look, gl.choose_backend())
    executor = Processes(processes, _AHEAD * processes, _begin, start)
    early: dict[int, np.ndarray] = {}  # drawn before their turn
    following = 0
    with closing(executor(range(total), _paint)) as drawn:
        for frame, picture in drawn:
            early[frame] = picture
            while following in early:
                yield early.pop(following)
                following += 1


_renderer: FrameRenderer | Exception | None = None  # of this worker process, or why it has none


def _begin(recording: Recording, look: RenderOptions, backend: str) -> None:
    global _renderer
    try:
        _renderer = FrameRenderer(recording, look, backend)
    except Exception as error:  # told with the first frame: what an initializer raises is lost
        _renderer = error


def _paint(frame: int) -> np.ndarray:
    if isinstance(_renderer, Exception):
        raise _renderer
    assert _renderer is not None
    return _renderer.paint(frame)
