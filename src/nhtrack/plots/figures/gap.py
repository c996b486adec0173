"""How far robots are from their ideal twins, over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import get_args

import numpy as np
from matplotlib.figure import Figure

from nhtrack.analysis.event import Event, EventKind, first_touch
from nhtrack.analysis.events import find_events
from nhtrack.analysis.metrics import heading_gap, position_gap
from nhtrack.plots.event_marks import mark_events
from nhtrack.plots.style import column_styled
from nhtrack.plots.time_figure import Sheet, zeros_as_gaps
from nhtrack.presentation.numbers import common_prefix, seconds
from nhtrack.recording import Recording


@column_styled
def gap(recording: Recording, events: Sequence[Event] | None = None) -> Figure | None:
    """Returns the distance [m] and the angle [rad] of every robot from its ideal twin at the same time, logarithmic.

    The twin is the same scenario and the same sampled law on the ideal integrator. Units have the prefix that suits
    them, and all events are shaded. Twins pass through each other: curves end where robots first touch. None where
    the run is its own twin: there is nothing to tell. Arguments as of `errors`.
    """
    if recording.backend == "ideal" or "ideal_pose" not in recording.dataset:
        return None
    found = find_events(recording) if events is None else events
    touched = first_touch(found)
    compared = recording.time[:, None] <= (np.inf if touched is None else touched)
    gaps = position_gap(recording), np.abs(heading_gap(recording))
    values = [np.where(compared, each, np.nan) for each in gaps]
    scales = [common_prefix(each) for each in values]
    panels = [
        ("distance from the ideal twin", f"position gap [{scales[0][1]}m]"),
        ("angle from the ideal twin", f"heading gap [{scales[1][1]}rad]"),
    ]
    sheet = Sheet(recording, panels)
    for row, (each, (factor, _)) in enumerate(zip(values, scales, strict=True)):
        sheet.draw(row, zeros_as_gaps(factor * each), range(len(recording.robots)), magnitude=True)
        sheet.logarithmic(row)
        mark_events(sheet.panels[row], recording, found, get_args(EventKind), names=row == 0)
    if touched is None:
        return sheet.finished()
    return sheet.finished(f"Robots touch first at {seconds(touched)}; twins pass through, and are compared until then.")
