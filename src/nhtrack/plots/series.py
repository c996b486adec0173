"""How quantities went over time: errors, inputs and torques, slip and friction."""

from __future__ import annotations

from typing import Any, get_args

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter

from nhtrack import se2
from nhtrack.events import Kind, find_events
from nhtrack.plots.marks import mark_events
from nhtrack.plots.style import (
    INK,
    draw_robots,
    panel_title,
    robot_legend,
    run_title,
    styled,
    time_axes,
)  # fmt: skip
from nhtrack.recording import Recording

__all__ = ["errors", "inputs", "slip"]

_DASHED: dict[str, Any] = {"linestyle": (0, (3, 1.5)), "linewidth": 1.1}
_LIMIT: dict[str, Any] = {"color": INK, "linewidth": 0.8, "linestyle": (0, (6, 3)), "zorder": 2}
# What concerns which panel of `slip`: a wheel that loses the floor shows in the loads, one that spins in the friction.
_SLIP_EVENTS: tuple[tuple[Kind, ...], ...] = (
    ("slipping", "tipped"),
    ("slipping", "tipped"),
    ("wheel off the floor", "leaning", "tipped"),
    ("stuck", "tipped"),
)
_DECADES = 6  # log axes show at most this many: below is rounding, not tracking


@styled
def errors(recording: Recording) -> Figure:
    """Returns each follower's position and heading error and its gap to the ideal twin.

    Position error is the distance to the pose it was told to track [m]; heading error the angle to it, in
    (-pi, pi] [rad]; the gap is between MuJoCo's pose and the ideal twin's at the same time, in the unit that suits it.
    The followers' events are shaded.
    """
    time, error = recording.time, recording["error"].values[:, 1:]
    distance, heading = np.hypot(error[..., 0], error[..., 1]), _broken_at_antipode(error[..., 2])
    gap = _gap(recording)
    rows = 2 if gap is None else 3
    figure = Figure(figsize=(8.4, 2.1 * rows + 1.0))
    panels = figure.subplots(rows, 2, sharex=True, squeeze=False)
    places = range(1, len(recording.robots))
    draw = _drawer(recording, places)
    rowwise = [(distance, "position error [m]"), (heading, "heading error [rad]")]
    if gap is not None:
        factor, prefix = _prefix(gap)
        rowwise.append((factor * gap, f"gap to ideal twin [{prefix}m]"))
    for row, (values, label) in enumerate(rowwise):
        draw(panels[row, 0], time, values)
        draw(panels[row, 1], time, _positive(np.abs(values)))
        panels[row, 1].set_yscale("log")
        panels[row, 1].yaxis.set_minor_formatter(NullFormatter())
        _clip_decades(panels[row, 1], np.abs(values))
        for axes in panels[row]:
            axes.set_ylabel(label)
    panels[1, 0].axhline(0.0, color="#999999", linewidth=0.6, zorder=1)
    panels[0, 0].set_ylim(bottom=0.0)
    followers = [event for event in find_events(recording) if event.robot != recording.robots[0]]
    for k, axes in enumerate(panels.flat):
        mark_events(axes, recording, followers, get_args(Kind), bars=False, names=k == 0)
    for k, title in enumerate(["linear", "logarithmic", "linear", "magnitude, logarithmic", "linear", "logarithmic"]):
        if k < 2 * rows:
            panel_title(panels.flat[k], "abcdef"[k], title)
    return _finish(figure, panels, recording, root=False)


@styled
def inputs(recording: Recording) -> Figure:
    """Returns commanded accelerations u_x [m/s^2], u_theta [rad/s^2] and wheel torques [mN m] with their limit."""
    time, u = recording.time, recording["input"].values
    torque = recording.dataset.get("wheel_torque")
    rows = 1 if torque is None else 2
    figure = Figure(figsize=(8.4, 2.6 * rows + 1.0))
    panels = figure.subplots(rows, 2, sharex=True, squeeze=False)
    draw = _drawer(recording, range(len(recording.robots)))
    for k, label in enumerate(["$u_x$ [m/s²]", r"$u_\theta$ [rad/s²]"]):
        draw(panels[0, k], time, u[..., k], drawstyle="steps-post")
        panels[0, k].set_ylabel(label)
        panel_title(panels[0, k], "ab"[k], ["forward acceleration", "turning acceleration"][k])
    for k in range(2 if torque is not None else 0):
        draw(panels[1, k], time, 1e3 * recording["wheel_torque"].values[..., k])
        panels[1, k].set_ylabel("torque [mN m]")
        panel_title(panels[1, k], "cd"[k], f"{['left', 'right'][k]} wheel motor")
        _torque_limit(panels[1, k], recording)
    return _finish(figure, panels, recording)


@styled
def slip(recording: Recording) -> Figure:
    """Returns lateral and longitudinal slip, wheel loads [N] and friction utilisation with its limit.

    Of the two wheels the one that slips, or uses friction, more is shown. Events are shaded where they concern what a
    panel shows. The ideal backend has no wheels on a floor: its figure says so.
    """
    names = ("lateral_slip", "longitudinal_slip", "wheel_load", "friction_utilisation")
    if not set(names) <= set(recording.dataset.data_vars):
        return _no_wheels(recording)
    time = recording.time
    lateral, longitudinal, load, utilisation = (recording[name].values for name in names)
    figure = Figure(figsize=(8.4, 6.2))
    panels = figure.subplots(2, 2, sharex=True)
    draw = _drawer(recording, range(len(recording.robots)))
    units = []
    for axes, values in zip(panels[0], (lateral, _of_largest_magnitude(longitudinal)), strict=True):
        factor, prefix = _prefix(values)
        draw(axes, time, factor * values)
        units.append(f"{prefix}m/s")
    draw(panels[1, 0], time, load[..., 0])
    draw(panels[1, 0], time, load[..., 1], **_DASHED)
    _draw_utilisation(panels[1, 1], recording, draw, utilisation.max(axis=-1))
    ylabels = [
        f"lateral slip [{units[0]}]",
        f"longitudinal slip [{units[1]}]",
        "wheel load [N]",
        "friction utilisation [1]",
    ]
    titles = [
        "sideways, axle midpoint",
        "rolling direction, worse wheel",
        "left solid, right dashed",
        "worse wheel",
    ]
    for k, axes in enumerate(panels.flat):
        axes.set_ylabel(ylabels[k])
        panel_title(axes, "abcd"[k], titles[k])
    lightest, heaviest = float(np.nanmin(load)), float(np.nanmax(load))
    if lightest < 0.7 * heaviest:  # a wheel nears lift-off: show how near
        panels[1, 0].set_ylim(0.0, 1.08 * heaviest)
    else:
        panels[1, 0].set_ylim(0.85 * lightest, 1.15 * heaviest)
    events = find_events(recording)
    for axes, kinds in zip(panels.flat, _SLIP_EVENTS, strict=True):
        mark_events(axes, recording, events, kinds)
    predicted = Line2D([], [], color=INK, label="largest predicted", **_DASHED | {"linewidth": 0.7})
    extra = [predicted] if "friction_utilisation_predicted" in recording.dataset else []
    return _finish(figure, panels, recording, extra)


def _broken_at_antipode(heading: np.ndarray) -> np.ndarray:
    """Returns headings with a gap where they pass from pi to -pi or back, so that no line is drawn across."""
    jumps = np.abs(np.diff(heading, axis=0, prepend=heading[:1])) > np.pi
    return np.where(jumps, np.nan, heading)


def _drawer(recording: Recording, places: range) -> Any:
    crowd = len(recording.robots) - 1

    def draw(axes: Axes, time: np.ndarray, values: np.ndarray, **line: Any) -> None:
        draw_robots(axes, time, values, places, crowd=crowd, **line)

    return draw


def _finish(
    figure: Figure,
    panels: np.ndarray,
    recording: Recording,
    extra: list[Line2D] | None = None,
    *,
    root: bool = True,
) -> Figure:
    time_axes(figure, panels, recording)
    run_title(figure, recording)
    robot_legend(figure, recording, extra or [], root=root)
    figure.align_ylabels()
    return figure


def _gap(recording: Recording) -> np.ndarray | None:
    """Returns the followers' distance to the ideal twin [m], shape (t, k); None where the run is its own."""
    if recording.backend == "ideal" or "ideal_pose" not in recording.dataset:
        return None
    difference = se2.between(recording["ideal_pose"].values[:, 1:], recording["pose"].values[:, 1:])
    return np.asarray(np.hypot(difference[..., 0], difference[..., 1]))


def _prefix(values: np.ndarray) -> tuple[float, str]:
    """Returns the factor and the SI prefix with which the largest value reads as 1 to 1000."""
    finite = np.abs(values[np.isfinite(values)])
    largest = float(finite.max()) if finite.size else 0.0
    for factor, prefix in ((1.0, ""), (1e3, "m"), (1e6, "µ")):
        if factor * largest >= 1.0 or largest == 0.0:
            return factor, prefix
    return 1e9, "n"


def _positive(values: np.ndarray) -> np.ndarray:
    """Returns values with zeros as gaps, which a logarithm has no place for."""
    return np.where(values > 0, values, np.nan)


def _clip_decades(axes: Axes, values: np.ndarray) -> None:
    finite = values[np.isfinite(values) & (values > 0)]
    if finite.size == 0:
        return
    top = float(finite.max())
    bottom = np.clip(float(np.quantile(finite, 0.005)), top / 10**_DECADES, top / 10)
    axes.set_ylim(10 ** np.floor(np.log10(bottom)), 10 ** np.ceil(np.log10(1.05 * top)))


def _torque_limit(axes: Axes, recording: Recording) -> None:
    limit = recording.dataset.attrs.get("torque_limit")
    if limit is None:
        return
    for sign in (-1.0, 1.0):
        axes.axhline(sign * 1e3 * float(limit), **_LIMIT)
    axes.annotate(
        "motor limit", (1.0, 1e3 * float(limit)), xycoords=("axes fraction", "data"), xytext=(-2, 2),
        textcoords="offset points", ha="right", va="bottom", fontsize=7.5, color=INK,
    )  # fmt: skip


def _draw_utilisation(axes: Axes, recording: Recording, draw: Any, measured: np.ndarray) -> None:
    draw(axes, recording.time, measured)
    if "friction_utilisation_predicted" in recording.dataset:
        predicted = recording["friction_utilisation_predicted"].values.max(axis=-1)
        axes.plot(recording.time, predicted.max(axis=1), color=INK, **_DASHED | {"linewidth": 0.7, "zorder": 4})
    axes.axhline(1.0, **_LIMIT)
    axes.annotate(
        "wheels break away", (1.0, 1.0), xycoords=("axes fraction", "data"), xytext=(-2, 2),
        textcoords="offset points", ha="right", va="bottom", fontsize=7.5, color=INK,
    )  # fmt: skip
    axes.set_ylim(0.0, 1.15)


def _of_largest_magnitude(values: np.ndarray) -> np.ndarray:
    """Returns, of two wheels, the value of larger magnitude with its sign, shape (..., 2) -> (...)."""
    left, right = values[..., 0], values[..., 1]
    return np.where(np.abs(left) >= np.abs(right), left, right)


def _no_wheels(recording: Recording) -> Figure:
    figure = Figure(figsize=(8.4, 2.0))
    axes = figure.subplots()
    axes.set_axis_off()
    axes.text(0.5, 0.5, "Ideal integrator: no wheels, no slip, no friction", ha="center", va="center", color=INK)
    run_title(figure, recording)
    return figure
