"""Figures of a recording: pure functions of it; only `save_figures` and `save_drawn` write.

Figures are one journal column wide, in one house style (`nhtrack.plots.style`), in the robots' units: metres on the
floor, seconds of the robots' clock.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from inspect import signature
from pathlib import Path

from matplotlib.figure import Figure

from nhtrack.analysis.event import Event
from nhtrack.analysis.events import find_events
from nhtrack.plots.figures import run_figures
from nhtrack.plots.files import save_figure
from nhtrack.plots.style import column_styled
from nhtrack.presentation.thinned import thinned
from nhtrack.recording import Recording

__all__ = ["draw_figures", "run_figures", "save_drawn", "save_figures"]


def save_figures(
    recording: Recording, folder: Path, *, pdf: bool = False, events: Sequence[Event] | None = None
) -> list[Path]:
    """Writes every figure that says something; each file appears only once it is whole.

    Args:
        recording: the run.
        folder: where to write.
        pdf: whether to write for print, see `nhtrack.plots.files.save_figure`.
        events: of the run, if they are known; else they are looked for.

    Returns:
        The files, in the order of `run_figures`, PNG before PDF; without those that have nothing to say of the run, as
        the gap of one that is its own ideal twin.
    """
    written = []
    for name, figure in draw_figures(recording, run_figures(), events):
        written += save_drawn(recording.name, {name: figure}, folder, pdf=pdf)
    return written


def draw_figures(
    recording: Recording, names: Iterable[str], events: Sequence[Event] | None = None
) -> Iterator[tuple[str, Figure]]:
    """Yields those of the named figures that have something to say of a run, with their names; see `save_figures`."""
    found, recording = find_events(recording) if events is None else events, thinned(recording)
    for name in names:
        draw = run_figures()[name]
        figure = draw(recording, events=found) if "events" in signature(draw).parameters else draw(recording)
        if figure is not None:
            yield name, figure


@column_styled
def save_drawn(run: str, figures: Mapping[str, Figure], folder: Path, *, pdf: bool = False) -> list[Path]:
    """Writes figures of a run, by their names; see `save_figures`."""
    written = []
    for name, figure in figures.items():
        written += save_figure(figure, folder / name, pdf=pdf, title=f"{run}: {name}")
    return written
