"""The command `render`."""

from __future__ import annotations

import re
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from nhtrack.terminal.app import app


class Camera(StrEnum):
    """Where the film is seen from."""

    group = "group"
    top = "top"
    isometric = "isometric"
    chase = "chase"
    split = "split"  # type: ignore[assignment]  # a string has a method of that name


class QualityChoice(StrEnum):
    """What is spent on the film's pictures."""

    draft = "draft"
    normal = "normal"
    high = "high"


@app.command("render")
def render_command(
    recording: Annotated[Path, typer.Argument(help="A recording.nc that a run left.")],
    out: Annotated[
        Path | None, typer.Option(help="The film, .mp4 or .gif; by default renders/<run>.mp4.")
    ] = None,
    camera: Annotated[Camera | None, typer.Option(help="By default as the scenario says.")] = None,
    size: Annotated[str | None, typer.Option(metavar="WxH", help="Pixels, such as 1280x720.")] = None,
    fps: Annotated[int | None, typer.Option(min=1, max=120, help="Frames per second.")] = None,
    speed: Annotated[float | None, typer.Option(help="Robot seconds per second of film.")] = None,
    quality: Annotated[QualityChoice | None, typer.Option(help="By default as the scenario says.")] = None,
    processes: Annotated[
        int | None, typer.Option(min=1, help="Processes that draw; by default one for each core. Same pixels.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace the film if it exists.")] = False,
) -> None:
    """Make a film from a recording; nothing is simulated again."""
    if speed is not None and not speed > 0:
        raise typer.BadParameter(f"expected a number greater than 0, got {speed:g}", param_hint="--speed")
    pixels = _pixels(size) if size is not None else None
    from nhtrack.studies.render.run import render

    film = render(
        recording,
        out,
        camera=camera and camera.value,
        size=pixels,
        fps=fps,
        speed=speed,
        quality=quality and quality.value,
        processes=processes,
        overwrite=force,
        progress=True,
    )
    typer.echo(f"wrote {film.path}")


def _pixels(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d{1,6})x(\d{1,6})", text)
    if match is None:
        raise typer.BadParameter(f"expected two even numbers such as 1280x720, got {text!r}", param_hint="--size")
    return int(match[1]), int(match[2])
