"""How a film is made: camera, size, pace and picture quality."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from pydantic import ValidationError

from nhtrack.config.messages import shape_faults
from nhtrack.config.tree import dotted
from nhtrack.config.video import Video
from nhtrack.errors import RefusedFilmError

__all__ = ["FLEET", "MANY", "QUALITIES", "SPLIT", "Quality", "RenderOptions"]

MANY = 20  # more robots than this are drawn with less
FLEET = 100  # more than this without parts of a pixel or two, and with signs no larger than their places

SPLIT = "split"  # the group camera beside a live plot of the errors


@dataclass(frozen=True)
class Quality:
    """What a renderer spends on a picture.

    Attributes:
        samples: of each pixel (MSAA).
        shadow: texels along the shadow map's edge, 0 for no shadows.
        crowd_shadow: the same where there are more robots than `MANY`.
        slices: segments around a cylinder.
        trail: vertices of all trails together.
    """

    samples: int
    shadow: int
    crowd_shadow: int
    slices: int
    trail: int


QUALITIES = {
    "draft": Quality(samples=0, shadow=0, crowd_shadow=0, slices=12, trail=400),
    "normal": Quality(samples=4, shadow=1024, crowd_shadow=0, slices=20, trail=800),
    "high": Quality(samples=8, shadow=4096, crowd_shadow=4096, slices=40, trail=2000),
}


@dataclass(frozen=True)
class RenderOptions:
    """How a film is made; see `nhtrack.video.render_film`.

    Attributes:
        camera: one of `nhtrack.video.camera.CAMERAS`, or `SPLIT`.
        size: width and height [pixels], both even.
        fps: frames per second of film.
        speed: robot seconds per second of film, or None for the slowest round number that keeps the film short.
        quality: one of `QUALITIES`.

    Raises:
        RefusedFilmError: a value that a scenario's `video` may not have either.
    """

    camera: str = "group"
    size: tuple[int, int] = (640, 480)
    fps: int = 30
    speed: float | None = None
    quality: str = "normal"

    def __post_init__(self) -> None:
        given = asdict(self)
        try:
            Video.model_validate(given)
        except ValidationError as error:
            said = (f"{dotted(path)}: {message}" for path, message in shape_faults(given, error))
            raise RefusedFilmError("; ".join(said)) from None
