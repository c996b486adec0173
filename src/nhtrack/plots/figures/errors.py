"""How far followers are from what they track, over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import get_args

import numpy as np
from matplotlib.figure import Figure

from nhtrack.analysis.event import Event, EventKind
from nhtrack.analysis.events import find_events
from nhtrack.analysis.metrics import heading_error, position_error
from nhtrack.plots.event_marks import mark_events
from nhtrack.plots.style import column_styled
from nhtrack.plots.time_figure import Sheet, zeros_as_gaps
from nhtrack.presentation.shown import CROWD
from nhtrack.recording import Recording


@column_styled
def errors(recording: Recording, events: Sequence[Event] | None = None) -> Figure:
    """Returns each follower's position and heading error, linear and logarithmic.

    Position error is the distance to the pose it was told to track [m]; heading error the angle to it, in
    (-pi, pi] [rad]. The followers' events are shaded.

    Args:
        recording: the run.
        events: of the run, if they are known; else they are looked for.
    """
    distance, heading = position_error(recording)[:, 1:], heading_error(recording)[:, 1:]
    position_label, heading_label = "position [m]", "heading [rad]"
    sheet = Sheet(
        recording,
        [
            ("position error", position_label),
            ("position error, logarithmic", position_label),
            ("heading error", heading_label),
            ("heading error, magnitude, logarithmic", heading_label),
        ],
    )
    places = range(1, len(recording.robots))
    alone = len(places) <= CROWD
    sheet.draw(0, distance, places, magnitude=True)
    sheet.draw(1, zeros_as_gaps(distance), places, magnitude=True)
    sheet.draw(2, _broken_at_antipode(heading) if alone else heading, places)
    sheet.draw(3, zeros_as_gaps(np.abs(heading)), places, magnitude=True)
    sheet.logarithmic(1)
    sheet.logarithmic(3)
    sheet.panels[0].set_ylim(bottom=0.0)
    sheet.panels[2].axhline(0.0, color="#999999", linewidth=0.6, zorder=1)
    found = find_events(recording) if events is None else events
    followers = [event for event in found if event.robot != recording.robots[0]]
    for row, axes in enumerate(sheet.panels):
        mark_events(axes, recording, followers, get_args(EventKind), bars=False, names=row == 0)
    return sheet.finished()


def _broken_at_antipode(heading: np.ndarray) -> np.ndarray:
    """Returns headings with a gap where they pass from pi to -pi or back, so that no line is drawn across."""
    jumps = np.abs(np.diff(heading, axis=0, prepend=heading[:1])) > np.pi
    return np.where(jumps, np.nan, heading)
