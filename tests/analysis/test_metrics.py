"""Figures of runs that were made by hand, so that every figure is known."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest

import tolerances as tol
from nhtrack.analysis.metrics import (
    Separation,
    heading_gap,
    position_gap,
    settling_times,
    smallest_separation,
    summary,
)
from nhtrack.recording import Recording, make_recording

ROBOTS = ("leader", "follower")
TIME = np.arange(21) * 0.5  # 0 to 10 s: the last 15 % begin at 8.5 s, row 17


def recording(robots: tuple[str, ...] = ROBOTS, time: np.ndarray = TIME, **changed: np.ndarray) -> Recording:
    """Robots at rest at the origin, without error or gap, but for what is changed."""
    shape = (len(time), len(robots))
    nowhere, error = np.zeros((*shape, 3)), np.zeros((*shape, 3))
    error[:, 0] = np.nan
    variables: dict[str, np.ndarray] = {"pose": nowhere, "ideal_pose": nowhere, "error": error}
    variables |= {name: np.zeros(shape) for name in ("lateral_slip", "tilt")}
    wheels = ("friction_utilisation", "friction_utilisation_predicted", "torque_saturation", "wheel_load")
    variables |= {name: np.zeros((*shape, 2)) for name in (*wheels, "longitudinal_slip")}
    parents = {name: [] if name == robots[0] else [robots[0]] for name in robots}
    attributes: dict[str, Any] = {
        "name": "by hand",
        "backend": "mujoco",
        "outcome": "completed",
        "parents": parents,
    }
    attributes |= {"length_scale": 0.5, "time_scale": 2.0}
    return make_recording(time, robots, variables | changed, attributes)


def with_error(x: np.ndarray, y: np.ndarray | float = 0.0, theta: np.ndarray | float = 0.0) -> Recording:
    """One follower with the given error over time."""
    error = np.full((len(TIME), 2, 3), np.nan)
    error[:, 1, 0], error[:, 1, 1], error[:, 1, 2] = x, y, theta
    return recording(error=error)


# -- series -----------------------------------------------------------------------------------------


def test_gaps_are_to_the_twin_and_count_whole_turns() -> None:
    pose, twin = np.zeros((21, 2, 3)), np.zeros((21, 2, 3))
    pose[:, 1], twin[:, 1] = [3.0, 1.0, 7.0], [0.0, 5.0, 7.0 - 2 * math.pi]
    run = recording(pose=pose, ideal_pose=twin)
    np.testing.assert_array_equal(position_gap(run), np.outer(np.ones(21), [0.0, 5.0]))
    np.testing.assert_allclose(heading_gap(run), np.outer(np.ones(21), [0.0, 2 * math.pi]), rtol=tol.HAND)


# -- settling ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("x", "theta", "expected"),
    [  # within 5 mm and 0.02 rad, at half of the scenario's size
        pytest.param(4 * [1.0] + 2 * [0.004] + 2 * [0.006] + 13 * [0.004], 21 * [0.01], 4.0, id="enters twice"),
        pytest.param(21 * [0.0], 9 * [0.03] + 12 * [-0.02], 4.5, id="heading"),
        pytest.param(17 * [1.0] + 4 * [0.005], 21 * [0.0], 8.5, id="from the first late row on"),
        pytest.param(18 * [1.0] + 3 * [0.005], 21 * [0.0], math.nan, id="from one row later"),
        pytest.param(21 * [0.0], 21 * [0.03], math.nan, id="turned away for good"),
        pytest.param(21 * [0.0], 21 * [0.0], 0.0, id="without error"),
    ],
)
def test_settling_time(x: list[float], theta: list[float], expected: float) -> None:
    run = with_error(np.array(x), 0.0, np.array(theta))
    np.testing.assert_array_equal(settling_times(run), [np.nan, expected])
    assert summary(run)["settling_limits"] == {"position": 0.005, "heading": 0.02}


def test_settling_times_are_told_apart() -> None:
    error = np.zeros((21, 3, 3))
    error[:, 0] = np.nan
    error[:5, 1, 0], error[:9, 2, 1] = 1.0, 1.0
    run = recording(("leader", "a", "b"), error=error)
    np.testing.assert_array_equal(settling_times(run), [np.nan, 2.5, 4.5])


# -- separation -------------------------------------------------------------------------------------


def test_smallest_separation_names_the_pair_and_the_time() -> None:
    g = np.zeros((21, 3, 3))
    g[:, 1, 0], g[:, 2, 1] = 10.0, 20.0
    g[7, 2, :2] = [10.0, 0.5]
    g[:, :, 2] = np.random.default_rng(0).uniform(-9, 9, (21, 3))  # headings have no say
    assert smallest_separation(recording(("leader", "a", "b"), pose=g)) == Separation(0.5, ("a", "b"), 3.5)


@pytest.mark.parametrize("n", [2, 3, 100, 101, 150])
def test_smallest_separation_is_found_among_few_and_many(n: int) -> None:
    g = np.random.default_rng(n).uniform(-9, 9, (21, n, 3))
    g[11, n - 1, :2] = g[11, 0, :2] + [3e-4, 4e-4]
    found = smallest_separation(recording(tuple(f"r{i}" for i in range(n)), pose=g))
    assert found is not None
    assert found[1:] == (("r0", f"r{n - 1}"), 5.5)
    assert found.distance == pytest.approx(5e-4, rel=1e-9)


def test_a_single_robot_is_separated_from_nobody() -> None:
    run = recording(("leader",))
    assert smallest_separation(run) is None
    assert summary(run)["smallest_separation"] is None


# -- the summary ------------------------------------------------------------------------------------


def test_summary_says_what_was_run() -> None:
    told = summary(recording())
    assert (told["name"], told["backend"], told["outcome"]) == ("by hand", "mujoco", "completed")
    assert told["duration"] == 10.0
    assert told["similarity"] == {"length": 0.5, "time": 2.0}
    assert list(told["followers"]) == ["follower"]
    assert list(told["robots"]) == ["leader", "follower"]


def test_summary_of_a_follower() -> None:
    x = np.linspace(5.0, 0.0, 21)  # 0.25 m less each row
    theta = -0.1 * np.ones(21)
    theta[17], theta[16] = 0.7, -2.0  # just late, and just before
    assert summary(with_error(x, 0.0, theta))["followers"]["follower"] == {
        "initial_position_error": 5.0,
        "final_position_error": 0.0,
        "final_heading_error": 0.1,
        "late_position_error": 0.75,
        "late_heading_error": 0.7,
        "settling_time": None,  # inside from 9.5 s: not for the whole late part
    }


def test_summary_of_a_robot() -> None:
    pose, twin = np.zeros((21, 2, 3)), np.zeros((21, 2, 3))
    pose[:, 0, 0] = np.abs(np.arange(21) - 10) * 0.3  # 3 m there and 3 m back
    twin[:, 0] = pose[:, 0]
    pose[:, 1, :2], twin[:, 1, :2] = [0.3, 0.4], [0.3, 0.4]
    pose[4, 1, 1], pose[4, 1, 2], pose[9, 1, 2] = 0.6, -0.3, 0.2
    used, saturated, slip = np.zeros((21, 2, 2)), np.zeros((21, 2, 2)), np.zeros((21, 2))
    used[0] = np.nan  # before the first period nothing is known of forces
    used[3, 1], used[8, 1, 0] = [0.2, 0.6], 0.5
    saturated[0] = np.nan
    saturated[5, 1], saturated[6, 1] = [1.0, 0.5], [0.0, 0.6]
    slip[12, 0] = -0.01
    changed = {"friction_utilisation": used, "friction_utilisation_predicted": used / 2}
    told = summary(
        recording(pose=pose, ideal_pose=twin, torque_saturation=saturated, lateral_slip=slip, **changed)
    )["robots"]
    assert told["follower"] == pytest.approx(
        {
            "path_length": 0.4,
            "gap_position_rms": 0.2 / math.sqrt(21),
            "gap_position_max": 0.2,
            "gap_heading_rms": math.sqrt((0.09 + 0.04) / 21),
            "gap_heading_max": 0.3,
            "peak_utilisation": 0.6,
            "peak_utilisation_predicted": 0.3,
            "smallest_wheel_load": 0.0,
            "peak_lateral_slip": 0.0,
            "torque_saturation_share": (1.0 + 0.6) / 21,
        },
        rel=tol.HAND,
    )
    assert told["leader"]["path_length"] == pytest.approx(6.0, rel=tol.HAND)
    assert told["leader"]["peak_lateral_slip"] == 0.01
    assert told["leader"]["gap_position_max"] == 0.0


def test_summary_of_a_virtual_leader_has_no_wheels() -> None:
    """A marker leaves NaN where wheels leave numbers; JSON gets null, not NaN."""
    wheels = np.full((21, 2, 2), np.nan)
    wheels[:, 1] = 0.25
    told = summary(recording(friction_utilisation=wheels, friction_utilisation_predicted=wheels))["robots"]
    assert told["leader"]["peak_utilisation"] is None
    assert told["leader"]["peak_utilisation_predicted"] is None
    assert told["follower"]["peak_utilisation"] == 0.25


def test_summary_of_a_lifted_wheel_is_json() -> None:
    """An infinite utilisation has no JSON number."""
    wheels = np.zeros((21, 2, 2))
    wheels[3, 1, 0] = np.inf
    loads = np.full((21, 2, 2), 2.5)
    loads[0], loads[3, 1, 0] = np.nan, -0.1  # nothing is known before the first step
    told = summary(recording(friction_utilisation=wheels, wheel_load=loads))
    assert told["robots"]["follower"]["peak_utilisation"] is None
    assert told["robots"]["follower"]["smallest_wheel_load"] == pytest.approx(-0.1)
    assert told["robots"]["leader"]["smallest_wheel_load"] == 2.5
    assert json.loads(json.dumps(told, allow_nan=False)) == json.loads(json.dumps(told))


def test_summary_of_a_run_that_never_began() -> None:
    """Interrupted in the first period: one row, and every figure is of that row."""
    error = np.array([[[np.nan] * 3, [3.0, 4.0, 0.5]]])
    told = summary(recording(time=np.array([0.0]), error=error))
    assert told["duration"] == 0.0
    assert told["followers"]["follower"]["late_position_error"] == 5.0
    assert told["followers"]["follower"]["settling_time"] is None
    assert told["robots"]["follower"]["path_length"] == 0.0


def test_summary_lists_the_events_as_plain_values() -> None:
    """Two periods of half a second at the limit; the leader only comes near it."""
    used, aside, ahead, load = np.zeros((21, 2, 2)), np.zeros((21, 2)), np.zeros((21, 2, 2)), np.ones((21, 2, 2))
    used[:, 0], used[4:6, 1, 0] = 0.98, [1.0, np.inf]
    aside[5, 1], ahead[4, 1, 0], ahead[10, 1, 1] = 0.2, -0.3, 5.0
    slips = {"friction_utilisation": used, "lateral_slip": aside, "longitudinal_slip": ahead}
    told = summary(recording(wheel_load=load, **slips))["events"]
    slide = {"kind": "slipping", "robot": "follower", "wheel": "left", "start": 1.5, "end": 2.5}
    assert told == [slide | {"measure": "slip speed", "worst": 0.3, "unit": "m/s", "touch": None}]
    assert json.loads(json.dumps(told, allow_nan=False)) == told
    assert summary(recording(wheel_load=load))["events"] == []
