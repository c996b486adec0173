"""How quantities went over time: errors, inputs and torques, slip and friction, the gap to the ideal twin.

All are in the robots' units: metres on the floor, seconds of the robots' clock.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, get_args

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nhtrack.analysis.events import Event, EventKind, find_events
from nhtrack.analysis.metrics import heading_error, heading_gap, of_largest_magnitude, position_error, position_gap
from nhtrack.colours import INK
from nhtrack.plots.event_marks import mark_events
from nhtrack.plots.style import column_styled
from nhtrack.plots.time_figure import DASHED, LIMIT, Sheet
from nhtrack.presentation.numbers import common_prefix, quantity
from nhtrack.presentation.shown import CROWD
from nhtrack.recording import Recording

__all__ = ["errors", "gap", "inputs", "slip"]

# What concerns which panel of `slip`: a wheel that loses the floor shows in the loads, one that spins in the friction.
_SLIP_EVENTS: tuple[tuple[EventKind, ...], ...] = (
    ("slipping", "tipped"),
    ("slipping", "tipped"),
    ("wheel off the floor", "leaning", "tipped"),
    ("stuck", "tipped"),
)
# What a limit is stands at the panel's right.
_LIMIT_TEXT: dict[str, Any] = {
    "xycoords": "axes fraction", "textcoords": "offset points", "ha": "right", "fontsize": 6.0, "color": INK,
}  # fmt: skip
_AT_DATA: dict[str, Any] = {"xycoords": ("axes fraction", "data")}
_NEAR = 0.4  # share of the limit that torques reach where the limit is drawn
_SLIP_VARIABLES = ("lateral_slip", "longitudinal_slip", "wheel_load", "friction_utilisation")


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
    sheet.draw(1, _positive(distance), places, magnitude=True)
    sheet.draw(2, _broken_at_antipode(heading) if alone else heading, places)
    sheet.draw(3, _positive(np.abs(heading)), places, magnitude=True)
    sheet.logarithmic(1)
    sheet.logarithmic(3)
    sheet.panels[0].set_ylim(bottom=0.0)
    sheet.panels[2].axhline(0.0, color="#999999", linewidth=0.6, zorder=1)
    followers = [event for event in _known(events, recording) if event.robot != recording.robots[0]]
    for row, axes in enumerate(sheet.panels):
        mark_events(axes, recording, followers, get_args(EventKind), bars=False, names=row == 0)
    return sheet.finished()


@column_styled
def gap(recording: Recording, events: Sequence[Event] | None = None) -> Figure | None:
    """Returns the distance [m] and the angle [rad] of every robot from its ideal twin at the same time, logarithmic.

    The twin is the same scenario and the same sampled law on the ideal integrator. Units have the prefix that suits
    them, and all events are shaded. None where the run is its own twin: there is nothing to tell. Arguments as of
    `errors`.
    """
    if recording.backend == "ideal" or "ideal_pose" not in recording.dataset:
        return None
    values = position_gap(recording), np.abs(heading_gap(recording))
    scales = [common_prefix(each) for each in values]
    panels = [
        ("distance from the ideal twin", f"position gap [{scales[0][1]}m]"),
        ("angle from the ideal twin", f"heading gap [{scales[1][1]}rad]"),
    ]
    sheet, found = Sheet(recording, panels), _known(events, recording)
    for row, (each, (factor, _)) in enumerate(zip(values, scales, strict=True)):
        sheet.draw(row, _positive(factor * each), range(len(recording.robots)), magnitude=True)
        sheet.logarithmic(row)
        mark_events(sheet.panels[row], recording, found, get_args(EventKind), names=row == 0)
    return sheet.finished()


@column_styled
def inputs(recording: Recording) -> Figure:
    """Returns commanded accelerations u_x [m/s^2], u_theta [rad/s^2] and wheel torques [N m] with their limit."""
    u, places = recording["input"].values, range(len(recording.robots))
    torque = recording["wheel_torque"].values if "wheel_torque" in recording.dataset else None
    panels = [("forward acceleration", "input [m/s²]"), ("turning acceleration", "input [rad/s²]")]
    limit = recording.robot.torque_limit
    factor, prefix = common_prefix(np.array([limit]) if torque is None else torque)
    if torque is not None:
        panels += [(f"{side} wheel motor", f"torque [{prefix}N m]") for side in ("left", "right")]
    sheet = Sheet(recording, panels)
    for k in range(2):
        sheet.draw(k, u[..., k], places, drawstyle="steps-post")
        if torque is not None:
            sheet.draw(2 + k, factor * torque[..., k], places)
            _draw_torque_limit(sheet.panels[2 + k], factor * limit, f"{prefix}N m")
    return sheet.finished()


@column_styled
def slip(recording: Recording, events: Sequence[Event] | None = None) -> Figure | None:
    """Returns lateral and longitudinal slip [m/s], wheel loads [N] and friction utilisation with its limit.

    Of the two wheels the one that slips, or uses friction, more is shown. Events are shaded where they concern what a
    panel shows. A run on the ideal integrator, which does not slip, has only the loads and the utilisation that the
    reduced model predicts; None where a recording has not even these. Arguments as of `errors`.
    """
    if not set(_SLIP_VARIABLES) <= set(recording.dataset.data_vars):
        return None
    lateral, longitudinal, load, utilisation = (recording[name].values for name in _SLIP_VARIABLES)
    ideal, places = recording.backend == "ideal", range(len(recording.robots))
    slips = [] if ideal else [lateral, of_largest_magnitude(longitudinal)]
    scales = [common_prefix(values) for values in slips]
    titles = ("sideways slip, axle midpoint", "slip along the rolling direction, worse wheel")
    panels = [(title, f"slip [{prefix}m/s]") for title, (_, prefix) in zip(titles, scales, strict=False)]
    panels.append(("wheel load, left solid, right dashed", "load [N]"))
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
    found = _known(events, recording)
    for axes, kinds in zip(sheet.panels, _SLIP_EVENTS, strict=True):
        mark_events(axes, recording, found, kinds)
    return sheet.finished(*_draw_prediction(sheet.panels[row + 1], recording))


def _known(events: Sequence[Event] | None, recording: Recording) -> Sequence[Event]:
    return find_events(recording) if events is None else events


def _broken_at_antipode(heading: np.ndarray) -> np.ndarray:
    """Returns headings with a gap where they pass from pi to -pi or back, so that no line is drawn across."""
    jumps = np.abs(np.diff(heading, axis=0, prepend=heading[:1])) > np.pi
    return np.where(jumps, np.nan, heading)


def _positive(values: np.ndarray) -> np.ndarray:
    """Returns values with zeros as gaps, which a logarithm has no place for."""
    return np.where(values > 0, values, np.nan)


def _draw_torque_limit(axes: Axes, limit: float, unit: str) -> None:
    """Draws the limit on either side, if there is one; where torques are far below it, says where it is."""
    if not np.isfinite(limit):
        return
    largest = float(np.abs(axes.get_ylim()).max())
    if largest < _NEAR * limit:
        axes.annotate(f"motor limit: {quantity(limit, unit)}", (1.0, 1.0), xytext=(-2, -1), va="top", **_LIMIT_TEXT)
        return
    for sign in (-1.0, 1.0):
        axes.axhline(sign * limit, **LIMIT)
    axes.set_ylim(-1.35 * limit, 1.35 * limit)
    axes.annotate("motor limit", (1.0, limit), xytext=(-2, 1.5), va="bottom", **_LIMIT_TEXT | _AT_DATA)


def _frame_utilisation(axes: Axes) -> None:
    axes.axhline(1.0, **LIMIT)
    axes.annotate("wheels break away", (1.0, 1.0), xytext=(-2, 1.5), va="bottom", **_LIMIT_TEXT | _AT_DATA)
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
