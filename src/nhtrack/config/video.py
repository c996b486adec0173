"""The section `video`: how the film of a run is made."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import AfterValidator, Field

from nhtrack.section import Section, fault


def _even(pixels: int) -> int:
    if pixels % 2:
        raise fault(f"video needs even sizes, got {pixels}")
    return pixels


def _encoded(size: tuple[int, int]) -> tuple[int, int]:
    if size[0] * size[1] > _MOST_PIXELS:
        raise fault(f"a picture of a film has at most 8192 x 4320 pixels, got {size[0]} x {size[1]}")
    return size


_MOST_PIXELS = 8192 * 4320  # of H.264 at its highest level
MOST_FRAMES = 200_000  # of a film; near two hours at 30 frames a second
Pixels: TypeAlias = Annotated[int, Field(ge=64, le=8192), AfterValidator(_even)]


class Video(Section):
    """How the film of the run is made."""

    camera: Literal["group", "top", "isometric", "chase", "split"] = Field(
        default="group",
        description="`group` frames the robots as they move, `top` and `isometric` the whole run, "
        "`chase` follows the first follower, `split` is `group` beside a live plot of the errors",
    )
    size: Annotated[tuple[Pixels, Pixels], Field(strict=False), AfterValidator(_encoded)] = Field(
        default=(640, 480), description="width, height [pixels]"
    )
    fps: int = Field(default=30, ge=1, le=120, description="frames per second of film [1/s]")
    speed: float | None = Field(
        default=None,
        gt=0,
        description="robot seconds per second of film [1]; null picks one that keeps the film short",
    )
    quality: Literal["draft", "normal", "high"] = Field(
        default="normal",
        description="`draft` has no shadows and no antialiasing; `high` has twice the samples of `normal` and finer "
        "shadows, for more than 20 robots too",
    )


def film_fault(seconds: float, fps: int, speed: float | None) -> str:
    """Returns why so many seconds on the robot's clock make no film, empty where they do."""
    frames = 0.0 if speed is None else seconds / speed * fps
    if frames <= MOST_FRAMES:
        return ""
    least = seconds * fps / MOST_FRAMES
    film = f"{seconds:g} s at {speed:g} s per second of film are {frames:.3g} frames"
    return f"{film}, at most {MOST_FRAMES}: {least:.2g} would do"
