"""A recording of random bits, for tests of files."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import xarray as xr

from nhtrack.experiment.load import load
from nhtrack.recording import VARIABLES, Recording, make_recording

ROBOTS = ("leader", "follower")
SOME = ("pose", "leader_pose", "tilt", "wheel_torque")
ATTRIBUTES: dict[str, Any] = {
    "name": "example1",
    "backend": "mujoco",
    "length_scale": 0.004,
    "time_scale": 4.0,
    "seed": 7,
    "outcome": "completed",
    "model_hash": "3f",
    "parents": {"leader": [], "follower": ["leader"]},
    "scenario": load("tour/hello").model_dump(mode="json"),
    "versions": {"nhtrack": "0.1.0", "mujoco": "3.17.0"},
}


def sample(times: int = 5, names: Iterable[str] = VARIABLES, **changes: Any) -> Recording:
    """A recording with every variable, random bits, NaN for the root, infinities, -0.0 and denormals."""
    random = np.random.default_rng(0)
    components = {"pose_component": 3, "twist_component": 3, "input_component": 2, "wheel": 2}
    components |= {"touch": 3, "touch_component": 5}
    variables = {}
    for name in names:
        values = random.standard_normal((times, len(ROBOTS), *(components[dim] for dim in VARIABLES[name].dims)))
        variables[name] = values
    variables["leader_pose"][:, 0] = np.nan
    variables["tilt"][:4, 1] = [np.inf, -np.inf, -0.0, 5e-324][:times]  # what text formats lose
    qpos = random.standard_normal((times, 19))
    return make_recording(0.01 * np.arange(times), ROBOTS, variables, ATTRIBUTES | changes, qpos)


def assert_same_bits(actual: xr.Dataset, expected: xr.Dataset) -> None:
    assert list(actual.variables) == list(expected.variables)
    for name in expected.variables:
        assert actual[name].dims == expected[name].dims
        assert actual[name].attrs == expected[name].attrs
        if expected[name].dtype == object:
            assert list(actual[name].values) == list(expected[name].values)
        else:
            assert actual[name].dtype == expected[name].dtype
            assert actual[name].values.tobytes() == expected[name].values.tobytes()
