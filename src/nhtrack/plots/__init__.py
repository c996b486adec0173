"""Figures of a recording: pure functions of it; only `save_figures` writes.

Figures are one journal column wide, in one house style (`nhtrack.plots.style`), in the robots' units. One that would
have nothing to say of a run is None.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from matplotlib.figure import Figure

from nhtrack.analysis.events import Event, find_events
from nhtrack.plots.files import save_figure
from nhtrack.plots.graph import communication
from nhtrack.plots.paths import trajectories
from nhtrack.plots.series import errors, gap, inputs, slip
from nhtrack.plots.style import column_styled
from nhtrack.recording import Recording

__all__ = ["FIGURES", "communication", "errors", "gap", "inputs", "save_figures", "slip", "trajectories"]

FIGURES: dict[str, Callable[..., Figure | None]] = {
    "trajectories": trajectories,
    "errors": errors,
    "inputs": inputs,
    "slip": slip,
    "gap": gap,
    "graph": communication,
}
_MARKED = ("errors", "slip", "gap")  # those that mark events


@column_styled
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
        The files, in the order of `FIGURES`, PNG before PDF; without those that have nothing to say of the run, as
        the gap of one that is its own ideal twin.
    """
    found, written = find_events(recording) if events is None else events, []
    for name, draw in FIGURES.items():
        figure = draw(recording, found) if name in _MARKED else draw(recording)
        if figure is not None:
            written += save_figure(figure, folder / name, pdf=pdf, title=f"{recording.name}: {name}")
    return written
