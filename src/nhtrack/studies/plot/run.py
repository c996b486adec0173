"""Figures of a recording."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from matplotlib.figure import Figure

from nhtrack.errors import NhtrackError, did_you_mean
from nhtrack.plots import draw_figures, run_figures, save_drawn
from nhtrack.studies.run.result import Recorded, recording_of


class PlotError(NhtrackError):
    """A figure that does not exist."""


@dataclass(frozen=True, repr=False)
class DrawnFigures:
    """Figures of a run.

    Attributes:
        name: of the run.
        figures: Matplotlib's, by name.
    """

    name: str
    figures: Mapping[str, Figure]

    def __getitem__(self, name: str) -> Figure:
        """Returns a figure by its name.

        Raises:
            PlotError: no such figure; the message lists those there are.
        """
        if name not in self.figures:
            raise PlotError(f"no figure {name!r} of this run; {did_you_mean(name, self.figures)}")
        return self.figures[name]

    def __repr__(self) -> str:
        """Returns a one-line account."""
        return f"DrawnFigures({self.name!r}: {', '.join(self.figures)})"

    def save(self, folder: str | Path, *, pdf: bool = False) -> list[Path]:
        """Writes the figures into a folder and returns the files; see `nhtrack.plots.files.save_figure`."""
        return save_drawn(self.name, self.figures, Path(folder), pdf=pdf)

    def _repr_html_(self) -> str:
        """Returns what a notebook shows: the figures."""
        from nhtrack.presentation.notebook import NotebookView, drawing, html_of

        drawn = [drawing(figure, f"{self.name}: {name}") for name, figure in self.figures.items()]
        return html_of(NotebookView(self.name, figures=drawn))


def plot(recording: Recorded, only: str | Iterable[str] | None = None) -> DrawnFigures:
    """Returns the figures of a recording that have something to say of it.

    Args:
        recording: a run, a recording, or the file of one.
        only: their names, those of the modules of `nhtrack.plots.figures`; all by default.

    Raises:
        PlotError: no such figure.
        RecordingError: no recording.
    """
    wanted = list(run_figures()) if only is None else [only] if isinstance(only, str) else list(only)
    for name in wanted:
        if name not in run_figures():
            raise PlotError(f"no figure {name!r}; {did_you_mean(name, run_figures())}")
    loaded = recording_of(recording)
    return DrawnFigures(loaded.name, dict(draw_figures(loaded, wanted)))
