"""A recording as plain numbers and names, thinned so that a browser draws them at once.

Two kinds of thinning. *Frames* are rows evenly spread in time: every robot's pose, its twin's and the figures of the
read-outs, for what moves with the slider. *Panels* are curves over time, each with the rows that hold its extremes.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from nhtrack.analysis.metrics import heading_error, position_error, position_gap
from nhtrack.analysis.touches import touch_place, touches
from nhtrack.colours import GRIP, ICE
from nhtrack.presentation.shown import CROWD, Span, covered, ground_of
from nhtrack.presentation.thinned import even_rows
from nhtrack.recording import Recording
from nhtrack.report.downsample import numbers
from nhtrack.report.panels import colours_of, dash_of, make_panels
from nhtrack.report.summary_text import has_virtual_root

DIGITS = 8  # significant digits: a tenth of a micrometre along ten metres
SHOWN_DIGITS = 4  # of read-outs, which show three
MOST_FRAMES = 2000  # more than a slider has pixels
POSES = 40_000  # of all robots together: what a browser draws within a second


@np.errstate(over="ignore", invalid="ignore")  # a run gone wild has numbers too large to square
def payload(recording: Recording, wrong: Iterable[Span]) -> dict[str, Any]:
    """Returns what the page's scripts draw, ready for JSON; unknown numbers are None.

    Lengths in metres and times in seconds of the robot, angles in radians; panels have units of their own.

    Args:
        recording: the run.
        wrong: start and end of everything that went wrong on wheels [s].
    """
    rows, colours = frame_rows(recording), colours_of(recording)
    frames = {"time": numbers(recording.time[rows], DIGITS)} | _poses(recording, rows) | _readouts(recording, rows)
    return {
        "robots": [
            {"name": name, "colour": colour, "dash": dash_of(recording, place)}
            for place, (name, colour) in enumerate(zip(recording.robots, colours, strict=True))
        ],
        "virtual_root": has_virtual_root(recording),
        "crowd": len(recording.robots) - 1 > CROWD,
        "grouped": bool(recording.groups),
        "twin": recording.has_twin,
        "backend": "MuJoCo" if recording.backend == "mujoco" else "ideal integrator",
        "frames": frames,
        "floor": _floor(recording),
        "touches": [
            {"time": event.start} | dict(zip("xy", numbers(touch_place(recording, event), DIGITS), strict=True))
            for event in touches(recording)
        ],
        "panels": make_panels(recording, DIGITS),
        "spells": [[float(f"{edge:.{DIGITS}g}") for edge in span] for span in covered(wrong)],
    }


def frame_rows(recording: Recording) -> np.ndarray:
    """Returns the rows of the recording that the slider stops at."""
    return even_rows(len(recording.time), min(MOST_FRAMES, max(2, POSES // len(recording.robots))))


def _poses(recording: Recording, rows: np.ndarray) -> dict[str, Any]:
    """Returns x, y [m] and theta [rad] of every robot, each of shape (n, frames), and the same of the twins."""
    sources = {"pose": "pose"} | ({"twin": "ideal_pose"} if recording.has_twin else {})
    return {
        label: dict(zip("xyh", numbers(recording[name].values[rows].transpose(2, 1, 0), DIGITS), strict=True))
        for label, name in sources.items()
    }


def _readouts(recording: Recording, rows: np.ndarray) -> dict[str, Any]:
    """Returns the figures shown for every robot at the slider's time, in the order of their columns."""
    columns = [("position error", "m", position_error(recording)), ("heading error", "rad", heading_error(recording))]
    if "twist" in recording.dataset:
        columns.append(("speed", "m/s", np.hypot(*np.moveaxis(recording["twist"].values[..., :2], -1, 0))))
    if recording.has_twin:
        columns.append(("gap to twin", "m", position_gap(recording)))
    if "friction_utilisation" in recording.dataset:
        columns.append(("friction used", "%", 100 * recording["friction_utilisation"].values.max(axis=-1)))
    return {
        "readouts": [
            {"name": name, "unit": unit, "values": numbers(values[rows].T, SHOWN_DIGITS)}
            for name, unit, values in columns
        ]
    }


def _floor(recording: Recording) -> dict[str, Any]:
    """Returns the size of the robots and what they drive on."""
    ground, robot = ground_of(recording), recording.robot
    known = {"half_separation": robot.half_separation, "wheel_radius": robot.wheel_radius}
    sizes = {name: value for name, value in known.items() if np.isfinite(value)}
    patches = [
        {
            "friction": patch.friction,
            "rectangle": patch.rectangle,
            "disc": patch.disc,
            "colour": ICE if patch.friction < ground.friction else GRIP,
        }
        for patch in ground.patches
    ]
    return {"patches": patches, "slope": ground.slope, "uphill": ground.uphill} | sizes
