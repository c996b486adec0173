"""What a notebook shows of a run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from nhtrack.analysis.event import Event, sentences
from nhtrack.analysis.events import find_events
from nhtrack.analysis.metrics import summary as figures_of
from nhtrack.errors import RecordingError, RenderError
from nhtrack.plots.figures.errors import errors
from nhtrack.plots.figures.trajectories import trajectories
from nhtrack.presentation.notebook import NotebookView, PageImage, drawing, html_of, photograph
from nhtrack.presentation.numbers import seconds
from nhtrack.recording import Recording
from nhtrack.report.summary_text import about, run_verdicts, tiles
from nhtrack.studies.run.result import Outcome
from nhtrack.studies.run.tables import run_tables


def outcome_html(outcome: Outcome) -> str:
    """Returns what a notebook shows of a run that has just been done."""
    return run_html(outcome.recording, outcome.summary, outcome.events)


def recording_html(recording: Recording) -> str:
    """Returns what a notebook shows of a recording, whose summary is reckoned anew."""
    events = find_events(recording)
    told = {"warnings": list(sentences(events))}
    return run_html(recording, figures_of(recording, events) | told, events)


def run_html(recording: Recording, summary: dict[str, Any], events: Sequence[Event]) -> str:
    """Returns what a notebook shows of a run: pictures, drawings, tables, and what there is to say of it.

    Args:
        recording: the run.
        summary: its figures, with `warnings` where there are any.
        events: what went wrong on wheels.
    """
    strip, no_strip = film_strip(recording)
    drawn, undrawn = _drawings(recording, events)
    first, *verdict = run_verdicts(summary, about(recording))
    view = NotebookView(
        recording.name,
        lead=first,
        tiles=tiles(summary),
        strip=strip,
        figures=drawn,
        tables=run_tables(summary),
        notes=[*no_strip, *undrawn],
        folded=[("In words", verdict), ("Warnings", list(summary.get("warnings", ())))],
    )
    return html_of(view)


def film_strip(recording: Recording) -> tuple[list[PageImage], list[str]]:
    """Returns some pictures of a run, or the reason why there are none."""
    if recording.outcome.startswith("diverged"):
        return [], ["No pictures: the run diverged."]
    from nhtrack.video.stills import stills

    try:
        return [photograph(picture, seconds(time)) for time, picture in stills(recording)], []
    except (RenderError, RecordingError) as error:
        return [], [f"No pictures: {error}."]


@np.errstate(over="ignore", invalid="ignore")  # axes that are to show what diverged
def _drawings(recording: Recording, events: Sequence[Event]) -> tuple[list[PageImage], list[str]]:
    """Returns drawings of a run, or the reason why there are none: one gone wild has numbers that no axis can show."""
    try:
        drawn = {"the floor": trajectories(recording), "errors over time": errors(recording, events)}
        return [drawing(figure, f"{recording.name}: {name}") for name, figure in drawn.items()], []
    except (ValueError, OverflowError) as error:
        return [], [f"No drawings: {error}."]
