"""What robots were commanded, and the torques it took, over time."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nhtrack.plots.event_marks import make_room
from nhtrack.plots.style import column_styled
from nhtrack.plots.time_figure import LIMIT, LIMIT_AT, LIMIT_TEXT, Sheet
from nhtrack.presentation.numbers import common_prefix, quantity
from nhtrack.recording import Recording

_TEXT_ROOM = 8.0  # [pt] for a line above the curves
_NEAR = 0.4  # share of the limit that torques reach where the limit is drawn


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


def _draw_torque_limit(axes: Axes, limit: float, unit: str) -> None:
    """Draws the limit on either side, if there is one; where torques are far below it, says where it is."""
    if not np.isfinite(limit):
        return
    largest = float(np.abs(axes.get_ylim()).max())
    if largest < _NEAR * limit:
        make_room(axes, _TEXT_ROOM)
        axes.annotate(f"motor limit: {quantity(limit, unit)}", (1.0, 1.0), xytext=(-2, -1), va="top", **LIMIT_TEXT)
        return
    for sign in (-1.0, 1.0):
        axes.axhline(sign * limit, **LIMIT)
    axes.set_ylim(-1.35 * limit, 1.35 * limit)
    axes.annotate("motor limit", (1.0, limit), xytext=(-2, 1.5), va="bottom", **LIMIT_TEXT | LIMIT_AT)
