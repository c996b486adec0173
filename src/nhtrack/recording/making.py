"""A recording from plain arrays."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from nhtrack.errors import RecordingError
from nhtrack.recording.recording import Recording
from nhtrack.recording.variables import COMPONENTS, FORMAT_VERSION, VARIABLES


def make_recording(
    time: np.ndarray,
    robots: tuple[str, ...],
    variables: Mapping[str, np.ndarray],
    attributes: Mapping[str, Any],
    qpos: np.ndarray | None = None,
) -> Recording:
    """Returns a recording built from plain arrays.

    Args:
        time: times [s], shape (t,).
        robots: the robots' names, shape n.
        variables: arrays of shape (t, n, ...) by the names of `VARIABLES`.
        attributes: strings and numbers to store; nested values are stored as JSON.
        qpos: MuJoCo's configuration, shape (t, nq), or None.

    Raises:
        RecordingError: a name that `VARIABLES` does not know.
    """
    import xarray as xr

    unknown = sorted(set(variables) - set(VARIABLES))
    if unknown:
        raise RecordingError(f"unknown variables {unknown}; known: {', '.join(VARIABLES)}")
    data: dict[str, Any] = {}
    for name, values in variables.items():
        spec = VARIABLES[name]
        meaning = {"units": spec.units, "long_name": spec.long_name}
        data[name] = (("time", "robot", *spec.dims), values, meaning)
    if qpos is not None:
        meaning = {"units": "m, rad or 1", "long_name": "MuJoCo configuration"}
        data["qpos"] = (("time", "coordinate"), qpos, meaning)
    coordinates: dict[str, Any] = {
        "time": ("time", time, {"units": "s", "long_name": "time on the robot's clock"}),
        "robot": ("robot", np.array(robots, dtype=object)),
    }
    used = {dim for name in variables for dim in VARIABLES[name].dims}
    coordinates |= {dim: np.array(labels, dtype=object) for dim, labels in COMPONENTS.items() if dim in used}
    return Recording(xr.Dataset(data, coordinates, plain_attributes(attributes)))


def plain_attributes(attributes: Mapping[str, Any]) -> dict[str, str | int | float]:
    """Returns the attributes of a recording as its file has them, with the version of its format."""
    plain = {
        key: value if isinstance(value, (str, int, float)) else json.dumps(value)
        for key, value in attributes.items()
    }
    return {"format_version": FORMAT_VERSION} | plain
