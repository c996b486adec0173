"""Axes with a knee."""

from __future__ import annotations

import numpy as np
import pytest

from nhtrack.presentation.bend import bent, bent_ticks, knee_of, straightened

TIME = np.linspace(0.0, 100.0, 1001)
USUAL = 0.3 * np.sin(TIME)


def test_only_what_dwarfs_the_rest_for_a_short_time_bends_an_axis() -> None:
    peak = np.where(TIME < 1.0, 40.0, 0.0)
    assert knee_of(np.stack([USUAL, np.full_like(TIME, np.nan)], axis=-1)) is None
    assert knee_of((USUAL + np.where(TIME < 20.0, 40.0, 0.0))[:, None]) is None  # a fifth of the time is no peak
    assert knee_of(np.stack([USUAL, peak], axis=-1)) == pytest.approx(0.5)
    assert knee_of(peak[:, None]) == pytest.approx(0.05)  # no more than three decades below the peak
    assert knee_of(np.zeros((5, 2))) is None


def test_a_bent_axis_is_linear_to_its_knee_then_a_decade_a_step_and_goes_back() -> None:
    values = np.array([-50.0, -5.0, -0.5, 0.0, 0.25, 0.5, 5.0])
    np.testing.assert_allclose(bent(values, 0.5), [-3.0, -2.0, -1.0, 0.0, 0.5, 1.0, 2.0], atol=1e-15)
    np.testing.assert_allclose(straightened(bent(values, 0.5), 0.5), values, rtol=1e-12)
    assert bent_ticks(-0.7, 40.0, 0.5) == [-0.5, 0.0, 0.5, 10.0]
    assert bent_ticks(-39.2, 39.2, 5.0) == [-20.0, -5.0, 0.0, 5.0, 20.0]
