"""Who tracks whom in a run."""

from __future__ import annotations

from matplotlib.figure import Figure

from nhtrack.plots.graph import draw_graph
from nhtrack.plots.style import column_styled, run_title
from nhtrack.recording import Recording


@column_styled
def graph(recording: Recording) -> Figure:
    """Returns who tracks whom in a run; see `nhtrack.plots.graph.draw_graph`."""
    return draw_graph(recording.parents, lambda figure: run_title(figure, recording))
