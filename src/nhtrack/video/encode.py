"""Films in MP4 and GIF through the ffmpeg that imageio-ffmpeg finds or brings."""

from __future__ import annotations

import functools
import logging
import subprocess
import tempfile
from collections.abc import Generator, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import imageio_ffmpeg
import numpy as np

from nhtrack.errors import RenderError

__all__ = ["FORMATS", "Encoder", "find_encoder", "write_film"]

logging.getLogger("imageio_ffmpeg").setLevel(logging.ERROR)  # it warns of films that were interrupted

_ROOM = 2**20  # bytes without which ffmpeg is taken to have failed for want of room

# What ffmpeg is told for each ending of a file's name.
FORMATS: dict[str, dict[str, Any]] = {
    ".mp4": {
        "codec": "libx264",
        "pix_fmt_out": "yuv420p",  # because players expect it
        # The index in front, so that a browser need not fetch the whole file first
        "output_params": ["-preset", "veryfast", "-crf", "23", "-movflags", "+faststart"],
    },
    ".gif": {
        "codec": "gif",
        "pix_fmt_out": "pal8",
        # One palette for all pictures, what stands still left out, and no dithering: noise would be most of the file
        "output_params": [
            "-filter_complex",
            "[0:v]split[a][b];[a]palettegen[p];[b][p]paletteuse=dither=none:diff_mode=rectangle",
        ],
    },
}


@dataclass(frozen=True)
class Encoder:
    """An ffmpeg with H.264.

    Attributes:
        path: the program.
        version: what it says it is.
    """

    path: str
    version: str


@functools.cache
def find_encoder() -> Encoder:
    """Returns the ffmpeg to encode with.

    Raises:
        RenderError: there is none, it does not run, or it lacks libx264.
    """
    try:
        path = imageio_ffmpeg.get_ffmpeg_exe()
        listing = subprocess.run([path, "-encoders"], capture_output=True, text=True, timeout=60, check=True)
    except (RuntimeError, OSError, subprocess.SubprocessError) as error:
        raise RenderError(
            f"no working ffmpeg: install the Debian package ffmpeg, or pip install imageio-ffmpeg ({error})"
        ) from error
    if "libx264" not in listing.stdout:
        raise RenderError(f"{path} has no libx264: unset IMAGEIO_FFMPEG_EXE to use the one imageio-ffmpeg brings")
    return Encoder(path, listing.stderr.partition("\n")[0].partition(" Copyright")[0])


def write_film(frames: Iterable[np.ndarray], path: Path, size: tuple[int, int], fps: int) -> None:
    """Writes frames (height, width, 3) of bytes in the format that the file's name ends in, one of `FORMATS`.

    Raises:
        RenderError: ffmpeg failed while writing.
        OSError: nothing more can be written there.
    """
    find_encoder()
    writer: Generator[None, bytes | None, None] = imageio_ffmpeg.write_frames(
        str(path), size, fps=fps, quality=None, macro_block_size=2, ffmpeg_log_level="fatal", **FORMATS[path.suffix]
    )
    sent = 0
    try:
        writer.send(None)
        for frame in frames:
            writer.send(np.ascontiguousarray(frame).tobytes())
            sent += 1
    except OSError as error:
        _require_room(path.parent)
        raise RenderError(f"ffmpeg could not write the film after {sent} frames: {error}") from error
    finally:
        writer.close()
    try:
        written, _ = imageio_ffmpeg.count_frames_and_secs(str(path))  # ffmpeg's failures are not reported on closing
    except RuntimeError:  # not even the beginning of a film
        written = 0
    if written != sent:
        _require_room(path.parent)
        raise RenderError(f"ffmpeg wrote {written} of {sent} frames")


def _require_room(folder: Path) -> None:
    """Raises OSError where the disk is full: ffmpeg does not say why it failed."""
    with tempfile.TemporaryFile(dir=folder) as file:
        file.write(bytes(_ROOM))
