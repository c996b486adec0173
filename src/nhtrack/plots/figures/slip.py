"""How wheels hold the floor, over time: slip, loads, friction."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nhtrack.analysis.event import Event, EventKind
from nhtrack.analysis.events import find_events
from nhtrack.analysis.metrics import mean_loads, of_largest_magnitude
from nhtrack.colours import INK
from nhtrack.plots.event_marks import mark_events
from nhtrack.plots.style import column_styled
from nhtrack.plots.time_figure import DASHED, LIMIT, LIMIT_AT, LIMIT_TEXT, Sheet
from nhtrack.presentation.numbers import common_prefix
from nhtrack.recording import Recording

# What concerns which panel: a wheel that loses the floor shows in the loads, one that spins in the friction.
_SLIP_EVENTS: tuple[tuple[EventKind, ...], ...] = (
    ("slipping", "touched", "tipped"),
    ("slipping", "touched", "tipped"),
    ("hopping", "wheel off the floor", "leaning", "tipped"),
    ("stuck", "tipped"),
)
_SLIP_VARIABLES = ("lateral_slip", "longitudinal_slip", "wheel_load", "friction_utilisation")


@column_styled
def slip(recording: Recording, events: Sequence[Event] | None = None) -> Figure | None:
    """Returns lateral and longitudinal slip [m/s], mean wheel loads [N] and friction utilisation with its limit.

    Of the two wheels the one that slips, or uses friction, more is shown. Events are shaded where they concern what a
    panel shows. A run on the ideal integrator, which does not slip, has only the loads and the utilisation that the
    reduced model predicts; None where a recording has not even these. Arguments as of `errors`.
    """
    if not set(_SLIP_VARIABLES) <= set(recording.dataset.data_vars):
        return None
    lateral, longitudinal, utilisation = (recording[name].values for name in _SLIP_VARIABLES if name != "wheel_load")
    load = mean_loads(recording)
    ideal, places = recording.backend == "ideal", range(len(recording.robots))
    slips = [] if ideal else [lateral, of_largest_magnitude(longitudinal)]
    scales = [common_prefix(values) for values in slips]
    titles = ("sideways slip, axle midpoint", "slip along the rolling direction, worse wheel")
    panels = [(title, f"slip [{prefix}m/s]") for title, (_, prefix) in zip(titles, scales, strict=False)]
    panels.append(("wheel load, mean over 0.1 s, left solid, right dashed", "load [N]"))
    panels.append((f"friction utilisation, worse wheel{', predicted' if ideal else ''}", "utilisation [1]"))
    sheet = Sheet(recording, panels)
    for row, (values, (factor, _)) in enumerate(zip(slips, scales, strict=True)):
        sheet.draw(row, factor * values, places)
    row = len(slips)
    sheet.draw(row, load[..., 0], places)
    sheet.draw(row, load[..., 1], places, named=False, **DASHED)
    _frame_loads(sheet.panels[row], load)
    sheet.draw(row + 1, utilisation.max(axis=-1), places, magnitude=True)
    _frame_utilisation(sheet.panels[row + 1])
    if ideal:
        return sheet.finished()
    found = find_events(recording) if events is None else events
    for axes, kinds in zip(sheet.panels, _SLIP_EVENTS, strict=True):
        mark_events(axes, recording, found, kinds)
    return sheet.finished(*_draw_prediction(sheet.panels[row + 1], recording))


def _frame_utilisation(axes: Axes) -> None:
    axes.axhline(1.0, **LIMIT)
    axes.annotate("wheels break away", (1.0, 1.0), xytext=(-2, 1.5), va="bottom", **LIMIT_TEXT | LIMIT_AT)
    axes.set_ylim(0.0, 1.3)


def _draw_prediction(axes: Axes, recording: Recording) -> list[str]:
    """Draws the largest utilisation that the reduced model predicts, if it is recorded; returns what to say of it."""
    if "friction_utilisation_predicted" not in recording.dataset:
        return []
    predicted = np.fmax.reduce(recording["friction_utilisation_predicted"].values, axis=(1, 2))
    axes.plot(recording.time, predicted, color=INK, **DASHED, linewidth=0.6, zorder=4)
    return ["Dashed in (d): the largest that the reduced model predicts."]


def _frame_loads(axes: Axes, load: np.ndarray) -> None:
    """Sets the axis of loads: from zero where a wheel nears lift-off, to show how near."""
    lightest, heaviest = float(np.nanmin(load)), float(np.nanmax(load))
    if lightest < 0.7 * heaviest:
        axes.set_ylim(0.0, 1.08 * heaviest)
    else:
        axes.set_ylim(0.85 * lightest, 1.15 * heaviest)
