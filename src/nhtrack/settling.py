"""When a follower has settled: one definition for all tables, figures, pages and searches.

A follower has settled at the first time from which on, until the end of the run,

    |p - p_r| <= position    and    |theta - theta_r| <= heading ,

p_r and theta_r the pose that it tracks. If that is not at least the late part of the run it has not settled: an error
that dips below the limits at the very end may be on its way out again. The limits are 10 mm and 0.02 rad in a scenario
of length scale one; that of the position scales as positions do. A campaign may set its own.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from nhtrack.arrays import Array
from nhtrack.compiled import compiled_inside

POSITION = 0.01  # [scenario length]
HEADING = 0.02  # [rad]
LATE = 0.15  # share of a run, at its end, that counts as late


class SettlingLimits(NamedTuple):
    """How near a follower that has settled stays to the pose that it tracks.

    Attributes:
        position: largest distance [m].
        heading: largest heading error [rad].
    """

    position: float
    heading: float


def settling_limits(length_scale: float, position: float = POSITION, heading: float = HEADING) -> SettlingLimits:
    """Returns the limits on the floor.

    Args:
        length_scale: robot metres per scenario length unit.
        position: largest distance [scenario length].
        heading: largest heading error [rad].
    """
    return SettlingLimits(position * length_scale, heading)


def is_near(limits: SettlingLimits, distance: Any, heading: Any) -> Any:
    """Returns whether errors [m], [rad] are within the limits: numbers, or arrays of any shape; NaN is not."""
    return (distance <= limits.position) & (abs(heading) <= limits.heading)


is_near_compiled = compiled_inside(is_near)


def settling_rows(limits: SettlingLimits, distance: Array, heading: Array) -> Array:
    """Returns the first row from which on errors are within the limits, shape (t, ...) -> (...).

    It is t where they are not at the end. Whether that is settled, the first late row decides: `row <= late`.

    Args:
        limits: in the errors' units.
        distance: [m], shape (t, ...).
        heading: heading errors [rad], shape (t, ...).
    """
    outside = ~is_near(limits, distance, heading)
    return np.where(outside.any(axis=0), len(outside) - outside[::-1].argmax(axis=0), 0)


def first_late_row(time: Array) -> int:
    """Returns the first row of the late part of a run, from its times, shape (t,)."""
    return int(np.searchsorted(time, time[0] + (1 - LATE) * (time[-1] - time[0])))
