"""How a film is made: camera, size, pace and picture quality."""

from __future__ import annotations

from dataclasses import dataclass

from nhtrack.errors import RenderError, did_you_mean
from nhtrack.video.camera import CAMERAS

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
        camera: one of `CAMERAS`, or `SPLIT`.
        size: width and height [pixels], both even.
        fps: frames per second of film.
        speed: robot seconds per second of film, or None for the slowest round number that keeps the film short.
        quality: one of `QUALITIES`.

    Raises:
        RenderError: a value that makes no film.
    """

    camera: str = "group"
    size: tuple[int, int] = (640, 480)
    fps: int = 30
    speed: float | None = None
    quality: str = "normal"

    def __post_init__(self) -> None:
        width, height = self.size
        if self.camera not in (*CAMERAS, SPLIT):
            raise RenderError(f"no camera {self.camera!r}; {did_you_mean(self.camera, (*CAMERAS, SPLIT))}")
        if self.quality not in QUALITIES:
            raise RenderError(f"no quality {self.quality!r}; {did_you_mean(self.quality, QUALITIES)}")
        if min(self.size) < 64 or width % 2 or height % 2:
            raise RenderError(f"size {width} x {height}: expected even numbers of pixels, at least 64")
        if self.fps < 1:
            raise RenderError(f"fps {self.fps}: expected at least 1 frame per second")
        if self.speed is not None and not 0 < self.speed < float("inf"):
            raise RenderError(f"speed {self.speed}: expected a positive number of robot seconds per second of film")
