"""The section `video`: how the film of a run is made."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import AfterValidator, Field

from nhtrack.section import Section, fault


def _even(pixels: int) -> int:
    if pixels % 2:
        raise fault(f"video needs even sizes, got {pixels}")
    return pixels


Pixels: TypeAlias = Annotated[int, Field(ge=64, le=8192), AfterValidator(_even)]


class Video(Section):
    """How the film of the run is made."""

    camera: Literal["group", "top", "isometric", "chase", "split"] = Field(
        default="group",
        description="`group` frames the robots as they move, `top` and `isometric` the whole run, "
        "`chase` follows the first follower, `split` is `group` beside a live plot of the errors",
    )
    size: Annotated[tuple[Pixels, Pixels], Field(strict=False)] = Field(
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
