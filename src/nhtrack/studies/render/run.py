"""A film of a recording."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from nhtrack.execution import cores
from nhtrack.files.folder import require_free
from nhtrack.recording import Recording
from nhtrack.studies.run.result import Recorded, recording_of
from nhtrack.terminal.progress import Observer, shown_progress

_LARGEST = 30_000_000  # bytes of a film that a notebook takes in


@dataclass(frozen=True)
class RenderedFilm:
    """A film that was made.

    Attributes:
        path: the file.
        name: of the run that it shows.
    """

    path: Path
    name: str

    def _repr_html_(self) -> str:
        """Returns what a notebook shows: the film itself, unless it is too large."""
        from nhtrack.presentation.notebook import NotebookView, data_url, html_of, picture_file

        size = self.path.stat().st_size
        lead = f"{self.path}, {size / 1e6:.2g} MB"
        if size > _LARGEST:
            return html_of(NotebookView(self.name, lead=f"{lead}: too large to be shown here"))
        if self.path.suffix == ".gif":
            return html_of(NotebookView(self.name, lead=lead, figures=[picture_file(self.path, self.name)]))
        return html_of(NotebookView(self.name, lead=lead, film=data_url("video/mp4", self.path.read_bytes())))


def render(
    recording: Recorded,
    out: str | Path | None = None,
    *,
    camera: str | None = None,
    size: tuple[int, int] | None = None,
    fps: int | None = None,
    speed: float | None = None,
    quality: str | None = None,
    processes: int | None = None,
    overwrite: bool = False,
    progress: bool | Observer | None = None,
) -> RenderedFilm:
    """Returns a film of a recording; nothing is simulated again. What is None is as the scenario says.

    Args:
        recording: a run, a recording, or the file of one.
        out: the film, .mp4 or .gif; by default `renders/<run>.mp4`.
        camera: `group`, `isometric`, `top`, `chase`, or `split`; see `nhtrack.video.render_film`.
        size: width and height [pixels], both even.
        fps: frames per second.
        speed: robot seconds per second of film.
        quality: `draft`, `normal` or `high`.
        processes: how many draw, one for each core by default; a script that asks for more than one needs
            `if __name__ == "__main__":`.
        overwrite: allow a film that exists to be replaced.
        progress: as in `nhtrack.run`.

    Raises:
        RecordingError: no recording, or one that cannot be filmed.
        OutputError: the film exists.
        RenderError: OpenGL or ffmpeg is missing, or an argument makes no film.
    """
    from nhtrack.video import render_film

    loaded = recording_of(recording)
    given = {"camera": camera, "size": size, "fps": fps, "speed": speed, "quality": quality}
    wanted = loaded.scenario.video.model_dump()
    wanted |= {name: value for name, value in given.items() if value is not None}
    target = Path("renders") / f"{_run_name(recording, loaded)}.mp4" if out is None else Path(out)
    require_free(target, overwrite)
    with shown_progress(progress) as stage:
        path = render_film(loaded, target, **wanted, processes=processes or cores(), progress=stage("video"))
    return RenderedFilm(path, loaded.name)


def _run_name(recorded: Recorded, recording: Recording) -> str:
    """Returns the name of a run: the folder that its recording lies in, unless that says nothing."""
    folder = Path(recorded).resolve().parent.name if isinstance(recorded, (str, Path)) else ""
    return folder if folder.startswith(recording.name) else recording.name
