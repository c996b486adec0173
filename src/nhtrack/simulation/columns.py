"""The columns of a simulation's telemetry, in the order in which compiled code writes them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

# First column and number of columns of each, by the names of `nhtrack.recording.VARIABLES`.
COLUMNS: Mapping[str, slice] = {
    "wheel_torque": slice(0, 2),
    "wheel_torque_demand": slice(2, 4),
    "torque_saturation": slice(4, 6),
    "wheel_speed": slice(6, 8),
    "wheel_load": slice(8, 10),
    "longitudinal_slip": slice(10, 12),
    "lateral_slip": slice(12, 13),
    "friction_utilisation": slice(13, 15),
    "friction_utilisation_predicted": slice(15, 17),
    "tilt": slice(17, 18),
    "wheel_clearance": slice(18, 20),
}
WIDTH = 20
SCALARS = ("lateral_slip", "tilt")  # those with one value a robot


def telemetry_of(rows: np.ndarray) -> dict[str, np.ndarray]:
    """Returns the quantities of telemetry by name, shape (..., WIDTH) -> (..., 2), or (...) for `SCALARS`."""
    return {
        name: rows[..., columns.start] if name in SCALARS else rows[..., columns] for name, columns in COLUMNS.items()
    }
