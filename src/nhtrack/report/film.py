"""A film in a page: the file itself, how fast it shows the run, and a line that says so."""

from __future__ import annotations

import base64
from dataclasses import dataclass
from pathlib import Path

from nhtrack.recording import Recording

_CAMERAS = {
    "group": "The camera follows and frames all robots",
    "top": "Seen from above",
    "isometric": "The camera stands still and frames the whole run",
    "chase": "The camera follows the first follower",
    "split": "The camera follows and frames all robots, beside their errors",
}


@dataclass(frozen=True)
class Film:
    """A film that a page carries.

    Attributes:
        base64: the MP4 file.
        speed: seconds of the robot per second of film; None where the file does not tell how long it lasts.
        caption: how it was filmed.
        ratio: width over height of its pictures.
    """

    base64: str
    speed: float | None
    caption: str
    ratio: float


def read_film(path: Path, recording: Recording) -> Film:
    """Returns a film as a page carries it.

    Args:
        path: an MP4 file.
        recording: the run it shows, from its first row on.
    """
    content, wanted = path.read_bytes(), recording.scenario.video
    speed = wanted.speed or _speed(content, recording, wanted.fps)
    width, height = wanted.size
    encoded = base64.b64encode(content).decode()
    return Film(encoded, speed, _caption(speed, wanted.camera), round(width / height, 4))


def duration_of(content: bytes) -> float | None:
    """Returns how long an MP4 film lasts [s], or None where it does not say.

    Its movie header box (ISO/IEC 14496-12, `mvhd`) holds units per second and a number of units, after two times
    whose size depends on the box's version.
    """
    start = content.find(b"mvhd") + 4
    if start < 4 or len(content) < start + 32:
        return None
    size = 8 if content[start] == 1 else 4  # bytes of a time
    after = start + 4 + 2 * size
    scale = int.from_bytes(content[after : after + 4])
    units = int.from_bytes(content[after + 4 : after + 4 + size])
    return units / scale if scale and units else None


def _speed(content: bytes, recording: Recording, fps: int) -> float | None:
    """Returns the speed of a film of the whole run: its first and its last frame show the first and the last row."""
    film = duration_of(content)
    between = None if film is None else film - 1 / fps
    run = float(recording.time[-1] - recording.time[0])
    return run / between if between and between > 0 and run > 0 else None


def _caption(speed: float | None, camera: str) -> str:
    seen = _CAMERAS[camera]
    if speed is None:
        return f"{seen}."
    return f"{seen}; {_pace(speed)}. It moves with the time of the plots."


def _pace(speed: float) -> str:
    if abs(speed - 1) < 0.005:
        return "a second of film is a second of the robot"
    return f"a second of film is {speed:.3g} s of the robot"
