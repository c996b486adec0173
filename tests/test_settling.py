"""When a follower has settled: worked by hand, and the same in arrays as in figures taken while runs run."""

from __future__ import annotations

import math

import numpy as np
import pytest

from nhtrack.experiment.recorder import Shape
from nhtrack.experiment.rows import COLUMNS
from nhtrack.experiment.run_statistics import RunStatistics
from nhtrack.settling import first_late_row, is_near, settling_limits, settling_rows

LIMITS = settling_limits(0.5)


def test_the_position_s_limit_scales_with_length() -> None:
    assert settling_limits(1.0) == (0.01, 0.02)
    assert LIMITS == (0.005, 0.02)
    assert settling_limits(2.0, 0.03, 0.01) == (0.06, 0.01)


@pytest.mark.parametrize(
    ("position", "heading", "row"),
    [
        pytest.param([0.1, 0.005, 0.005], [0.0, 0.02, -0.02], 1, id="limits are inside"),
        pytest.param([0.0, 0.0, 0.0], [0.0, 0.0, 0.0], 0, id="from the start"),
        pytest.param([0.0, 0.0051, 0.0], [0.0, 0.0, 0.0], 2, id="position"),
        pytest.param([0.0, 0.0, 0.0], [0.0, -0.021, 0.0], 2, id="heading"),
        pytest.param([0.0, 0.0, 0.0051], [0.0, 0.0, 0.0], 3, id="not at the end"),
        pytest.param([0.0, 0.0, math.nan], [0.0, 0.0, 0.0], 3, id="what is not known is not near"),
    ],
)
def test_rows_from_which_on_errors_are_small(position: list[float], heading: list[float], row: int) -> None:
    assert settling_rows(LIMITS, np.array(position), np.array(heading)) == row


@pytest.mark.parametrize(
    ("time", "first"),
    [
        (np.linspace(0.0, 10.0, 21), 17),  # 8.5 s is a row
        (np.linspace(5.0, 15.0, 21), 17),  # clock that does not start at zero
        (np.linspace(0.0, 10.0, 11), 9),  # 8.5 s lies between two rows
        (np.array([2.0]), 0),
        (np.array([0.0, 1.0]), 1),
    ],
)
def test_late_are_the_last_fifteen_per_cent_of_the_time(time: np.ndarray, first: int) -> None:
    assert first_late_row(time) == first


@pytest.mark.parametrize("block", [7, 64])
def test_figures_taken_by_the_way_settle_as_arrays_do(block: int) -> None:
    """Random walks that fade at all rates, some on them, some that end in what is not known."""
    b, t, late = 400, 64, 50
    rng = np.random.default_rng(3)
    fading = np.exp(-np.arange(t)[:, None, None] * rng.uniform(0.0, 0.3, (b, 1)))
    error = 0.1 * np.cumsum(rng.normal(size=(t, b, 3)), axis=0) * fading
    error[t // 2 :, :60] = 0.0
    error[t // 2 :, :20, 0] = LIMITS.position
    error[t // 2 :, 20:40, 2] = -LIMITS.heading
    error[-1, 40:60] = math.nan
    statistics = RunStatistics(LIMITS, late, ())
    statistics.begin(Shape(t - 1, b, 2, True, 0, (0, 0), 0.01, 0.0))
    for first in range(0, t, block):
        count = min(block, t - first)
        rows = statistics.space(first, count)
        rows.table[:] = math.nan
        rows.table[:, :count, 1, COLUMNS["error"]] = error[first : first + count].swapaxes(0, 1)
        statistics.add(first, count)
    distance, heading = np.hypot(error[..., 0], error[..., 1]), error[..., 2]
    expected = settling_rows(LIMITS, distance, heading)
    assert len(set(expected.tolist())) > t // 2, "a test needs many of them"
    np.testing.assert_array_equal(statistics.figures.settled[:, 1], expected)
    settled = is_near(LIMITS, distance[late:], heading[late:]).all(axis=0)
    assert 0 < settled.sum() < b
    np.testing.assert_array_equal(expected <= late, settled)
