"""What a notebook shows of a sweep."""

from __future__ import annotations

from nhtrack.presentation.notebook import NotebookView, drawing, html_of
from nhtrack.presentation.numbers import counted, grouped
from nhtrack.studies.sweep.figure import figure_of
from nhtrack.studies.sweep.result import SweepResults
from nhtrack.studies.sweep.screen import not_completed, results_table


def sweep_html(results: SweepResults) -> str:
    """Returns what a notebook shows of a sweep: its metrics, the first of them drawn, and what did not complete."""
    sweep, shown = results.sweep, results.known[:1] if results.varied else []
    completed = f"{grouped(len(results.completed))} of {grouped(len(results.runs))}"
    view = NotebookView(
        f"{sweep.name}: {counted(len(results.runs), 'run')}",
        lead=f"{', '.join(sweep.axes)} varied, {results.base.backend} backend; {results.folder}",
        tiles=[("completed", completed)],
        figures=[
            drawing(figure_of(results, metric), f"{sweep.name}: {metric} over the axes", scale=1.0) for metric in shown
        ],
        tables=[results_table(results)],
        notes=[
            f"{outcome}: {counted(len(part), 'run')}, the first {int(part['run'].iloc[0])}: {reason}"
            for (outcome, reason), part in not_completed(results.runs)
        ],
    )
    return html_of(view)
