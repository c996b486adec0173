"""Curves over time: which there are, what they are called, and how a crowd becomes a band."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from nhtrack.analysis.event import first_touch
from nhtrack.analysis.metrics import heading_error, heading_gap, of_largest_magnitude, position_error, position_gap
from nhtrack.analysis.touches import touches
from nhtrack.colours import BAND_COLOUR, robot_colour, robot_dashes
from nhtrack.presentation.bend import bent_ticks, knee_of
from nhtrack.presentation.numbers import common_prefix, seconds
from nhtrack.presentation.shown import CROWD
from nhtrack.presentation.thinned import extreme_rows
from nhtrack.recording import Recording
from nhtrack.report.downsample import numbers

POINTS = 120_000  # of all curves together: four megabytes, drawn within two seconds
MOST_POINTS = 2000  # of one curve: two extremes for every pixel
_WIDTH = 1.4  # [px] of curves, as `panels.js` has it
_DECADES = 8  # of a logarithmic axis at most: below is rounding


@dataclass(frozen=True)
class Panel:
    """One plot over time.

    Attributes:
        key: what scripts know it by.
        group: heading under which it stands.
        title: what is drawn.
        unit: unit of its axis.
        values: shape (t, n), one column a robot; NaN where a value is not known or the robot has none.
        logarithmic: whether a logarithmic axis can show it.
        held: whether values hold from one row to the next.
        limits: lines that curves should stay within, with their names.
    """

    key: str
    group: str
    title: str
    unit: str
    values: np.ndarray
    logarithmic: bool = False
    held: bool = False
    limits: tuple[tuple[str, float], ...] = ()


def make_panels(recording: Recording, digits: int) -> list[dict[str, Any]]:
    """Returns every panel with its curves as plain numbers."""
    panels = list(_panels(recording))
    curves = sum(len(_curves(panel, recording)) for panel in panels)
    most = int(np.clip(POINTS // max(curves, 1), 100, MOST_POINTS))
    return [_plain(panel, recording, most, digits) for panel in panels]


def _panels(recording: Recording) -> Iterator[Panel]:
    yield Panel("position", "Tracking error", "position error", "m", position_error(recording), logarithmic=True)
    heading = np.abs(heading_error(recording))
    yield Panel("heading", "Tracking error", "heading error, magnitude", "rad", heading, logarithmic=True)
    if "input" in recording.dataset:
        u = recording["input"].values
        yield Panel("u_x", "Commands", "forward acceleration", "m/s²", u[..., 0], held=True)
        yield Panel("u_theta", "Commands", "turning acceleration", "rad/s²", u[..., 1], held=True)
    if "wheel_torque" in recording.dataset:
        yield from _torques(recording)
    if "friction_utilisation" in recording.dataset:
        yield from _slips(recording)
    if recording.backend != "ideal" and "ideal_pose" in recording.dataset:
        yield from _gaps(recording)


def _gaps(recording: Recording) -> Iterator[Panel]:
    """Yields how far robots are from their twins, and from when on that says nothing of wheels."""
    touched, group = first_touch(list(touches(recording))), "Gap to the ideal twin"
    through = "" if touched is None else f"; robots touch first at {seconds(touched)}, twins pass through"
    yield _prefixed("gap", group, f"distance from the twin{through}", "m", position_gap(recording))
    turned = np.abs(heading_gap(recording))
    yield _prefixed("turned", group, f"heading from the twin's, magnitude{through}", "rad", turned)


def _torques(recording: Recording) -> Iterator[Panel]:
    limit = recording.robot.torque_limit
    limits = (("motor limit", 1e3 * limit), ("", -1e3 * limit)) if np.isfinite(limit) else ()
    for wheel, side in enumerate(("left", "right")):
        torque = 1e3 * recording["wheel_torque"].values[..., wheel]
        yield Panel(f"torque_{side}", "Commands", f"torque of the {side} wheel", "mN m", torque, limits=limits)


def _slips(recording: Recording) -> Iterator[Panel]:
    """Yields slip, which only wheels have, and friction utilisation, which the ideal integrator predicts."""
    group = "Wheels on the floor"
    if recording.backend != "ideal":
        yield _prefixed("sideways", group, "sideways slip of the axle", "m/s", recording["lateral_slip"].values)
        rolling = of_largest_magnitude(recording["longitudinal_slip"].values)
        yield _prefixed("rolling", group, "rolling slip, worse wheel", "m/s", rolling)
    use = recording["friction_utilisation"].values.max(axis=-1)
    limits = (("wheels break away", 1.0),)
    yield Panel("utilisation", group, "friction utilisation, worse wheel", "1", use, limits=limits)


def _prefixed(key: str, group: str, title: str, unit: str, values: np.ndarray) -> Panel:
    """Returns a panel in the SI unit in which its largest value reads as 1 to 1000."""
    factor, prefix = common_prefix(values)
    return Panel(key, group, title, prefix + unit, factor * values)


def colours_of(recording: Recording) -> list[str]:
    """Returns the colours of the robots as the scene has them, or those of their places."""
    spec = recording.scene if recording.has_scene else None
    return [robot_colour(place) if spec is None else spec.colour(place) for place in range(len(recording.robots))]


def dash_of(recording: Recording, place: int) -> str:
    """Returns how the line of a robot is broken, as the page's library has it; solid for robots of a single run."""
    places = recording.scene.colours if recording.groups and recording.has_scene else ()
    dashes = robot_dashes(places[place]) if places else ()
    return ",".join(f"{_WIDTH * part:.3g}px" for part in dashes) or "solid"


def _curves(panel: Panel, recording: Recording) -> list[tuple[dict[str, Any], np.ndarray]]:
    """Returns what curves are called and their columns: one a robot, or low, median and high of a crowd.

    A crowd of several runs is one crowd for each run. A robot of which nothing is known, as the root of errors, has no
    curve.
    """
    colours, known = colours_of(recording), np.isfinite(panel.values).any(axis=0)
    crowd = len(recording.robots) - 1 > CROWD
    alone = [place for place in range(len(recording.robots)) if known[place] and not (crowd and place)]
    bands = _bands(recording, colours) if crowd else []
    curves: list[tuple[dict[str, Any], np.ndarray]] = []
    for look, places in bands:
        members = panel.values[:, [place for place in places if known[place]]]
        if members.size:
            curves.append((look, band_of(members)))
    return curves + [
        (
            {"name": recording.robots[place], "colour": colours[place], "dash": dash_of(recording, place)},
            panel.values[:, [place]],
        )
        for place in alone
    ]


def _bands(recording: Recording, colours: list[str]) -> list[tuple[dict[str, Any], list[int]]]:
    """Returns what the crowds of a recording are called, and the places of their robots."""
    places = {name: place for place, name in enumerate(recording.robots)}
    groups = recording.groups
    if not groups:
        followers = list(range(1, len(recording.robots)))
        return [({"name": f"median of {len(followers)} followers", "colour": BAND_COLOUR, "dash": "solid"}, followers)]
    members = {label: [places[name] for name in names] for label, names in groups.items()}
    return [
        ({"name": label, "colour": colours[those[0]], "dash": dash_of(recording, those[0])}, those)
        for label, those in members.items()
    ]


def band_of(members: np.ndarray) -> np.ndarray:
    """Returns smallest, median and largest of what is known at each time, shape (t, k) -> (t, 3); NaN for none."""
    found = np.full((len(members), 3), np.nan)
    some = np.isfinite(members).any(axis=1)
    known = members[some]
    figures = np.nanmin(known, axis=1), np.nanmedian(known, axis=1), np.nanmax(known, axis=1)
    found[some] = np.stack(figures, axis=-1)
    return found


def _plain(panel: Panel, recording: Recording, most: int, digits: int) -> dict[str, Any]:
    curves, knee = [], None if panel.logarithmic else knee_of(panel.values)
    for look, columns in _curves(panel, recording):
        rows = extreme_rows(columns, most)
        lines = numbers(columns[rows].T, digits)
        names = ("y",) if len(lines) == 1 else ("low", "y", "high")
        curves.append(look | {"t": numbers(recording.time[rows], digits)} | dict(zip(names, lines, strict=True)))
    return {
        "key": panel.key,
        "group": panel.group,
        "title": panel.title,
        "unit": panel.unit,
        "held": panel.held,
        "decades": decades(panel.values) if panel.logarithmic else None,
        "knee": knee,
        "ticks": [] if knee is None else bent_ticks(*_ends(panel), knee),
        "limits": [{"name": name, "value": value} for name, value in panel.limits],
        "curves": curves,
    }


def _ends(panel: Panel) -> tuple[float, float]:
    """Returns the smallest and the largest of a panel's values and limits."""
    known = panel.values[np.isfinite(panel.values)]
    limits = [value for _, value in panel.limits]
    return min([float(known.min()), *limits]), max([float(known.max()), *limits])


def decades(values: np.ndarray) -> list[float] | None:
    """Returns the logarithms between which a logarithmic axis shows the values; None where none is above zero."""
    positive = values[np.isfinite(values) & (values > 0)]
    if not positive.size:
        return None
    top = float(positive.max())
    bottom = float(np.clip(np.quantile(positive, 0.005), top / 10**_DECADES, top / 10))
    return [float(np.floor(np.log10(bottom))), float(np.ceil(np.log10(1.05 * top)))]
