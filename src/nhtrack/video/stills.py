"""A few pictures of a run, instead of its film: small ones, so that nothing is written over them."""

from __future__ import annotations

import numpy as np

from nhtrack.arrays import Array
from nhtrack.recording import Recording
from nhtrack.video.frame_renderer import FrameRenderer
from nhtrack.video.render_options import RenderOptions
from nhtrack.video.timeline import frame_times


def stills(
    recording: Recording, count: int = 5, size: tuple[int, int] = (400, 300), camera: str = "group"
) -> list[tuple[float, Array]]:
    """Returns robot times [s] and pictures, bytes of shape (height, width, 3), from a run's beginning to its end.

    Raises:
        RenderError: OpenGL is missing.
        RecordingError: the recording lacks the scene it was made in.
    """
    look = RenderOptions(camera, size, quality="normal")
    times, _ = frame_times(recording.time, look.fps, look.speed)
    with FrameRenderer(recording, look) as renderer:
        chosen = np.unique(np.linspace(0, len(renderer) - 1, count).round().astype(int))
        return [(float(times[frame]), renderer.scene(int(frame))) for frame in chosen]
