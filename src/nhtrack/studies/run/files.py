"""What of a run is drawn and written: figures, film and report, or the reason why there are none."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from nhtrack.config.video import Video
from nhtrack.errors import RenderError
from nhtrack.files.folder import clear, save_json
from nhtrack.recording import Recording
from nhtrack.studies.run.result import Outcome
from nhtrack.terminal.progress import Stage


def save_outcome(outcome: Outcome, folder: Path) -> list[Path]:
    """Returns the files of recording and summary, in a folder that holds no other run's once they are there."""
    recording = outcome.recording.save(folder / "recording.nc")
    clear(folder, but=recording)
    return [recording, save_json(folder / "summary.json", outcome.summary)]


def save_run_figures(outcome: Outcome, folder: Path, *, pdf: bool) -> tuple[list[Path], list[str]]:
    """Returns the figures, or the reason why there are none: a run gone wild has numbers that no axis can show."""
    from nhtrack.plots import save_figures

    try:
        return save_figures(outcome.recording, folder / "figures", pdf=pdf, events=outcome.events), []
    except (ValueError, OverflowError) as error:
        return [], [f"no figures: {error}"]


def make_film(
    recording: Recording, wanted: Video, path: Path, stage: Stage | None = None, processes: int = 1
) -> tuple[list[Path], list[str]]:
    """Returns the film, or the reason why there is none: a machine without GL still gets its numbers.

    Args:
        recording: what to film.
        wanted: how.
        path: file to write, ending in .mp4.
        stage: see `nhtrack.studies.run.run.simulate`.
        processes: how many draw it.
    """
    from nhtrack.video import render_film

    progress = stage("video") if stage is not None else None
    try:
        return [render_film(recording, path, **wanted.model_dump(), processes=processes, progress=progress)], []
    except RenderError as error:
        return [], [f"no video: {error}"]


def write_run_report(outcome: Outcome, folder: Path, skipped: Sequence[str]) -> Path:
    """Returns the report of a run, with the film in it if the folder has one."""
    from nhtrack.config.documentation import json_schema
    from nhtrack.studies.run.report import Extras, write_run_page

    film, mark = folder / "video.mp4", "no video: "
    reasons = [reason.removeprefix(mark) for reason in skipped if reason.startswith(mark)]
    if outcome.recording.outcome != "completed":
        reasons.append("the run did not complete")
    reason = next(iter(reasons), "none was asked for")
    extras = Extras(film if film.exists() else None, reason, json_schema())
    return write_run_page(outcome.recording, outcome.summary, folder / "report.html", extras)
