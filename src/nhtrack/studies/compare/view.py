"""What a notebook shows of a comparison."""

from __future__ import annotations

from nhtrack.presentation.notebook import NotebookView, PageImage, drawing, html_of
from nhtrack.studies.compare.figure import overlay
from nhtrack.studies.compare.result import Comparison, room_of
from nhtrack.studies.compare.tables import comparison_tables, tuned_lines


def comparison_html(found: Comparison) -> str:
    """Returns what a notebook shows of a comparison: how the laws did, and all of them in one drawing."""
    drawn, undrawn = _drawing(found)
    count = len(found.outcomes)
    view = NotebookView(
        f"{found.scenario.name}: {count} law{'s' * (count != 1)} compared",
        lead=found.scenario.description,
        figures=drawn,
        tables=comparison_tables(found),
        notes=[*(f"Tuned: {line}." for line in tuned_lines(found)), *undrawn],
        folded=[("How it went about", found.notes), ("Warnings", found.warnings)],
    )
    return html_of(view)


def _drawing(found: Comparison) -> tuple[list[PageImage], list[str]]:
    """Returns the drawing of all laws, or the reason why there is none."""
    try:
        figure = overlay(found.recordings, room_of(list(found.recordings.values())))
        return [drawing(figure, f"{found.scenario.name}: paths and errors of all laws")], []
    except (ValueError, OverflowError) as error:
        return [], [f"No drawing: {error}."]
