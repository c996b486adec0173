"""Means over the time before each row."""

import numpy as np
import pytest

from nhtrack.analysis.spells import averaged


@pytest.mark.parametrize("period", [0.01, 0.03, 0.1, 0.5])
def test_a_row_has_the_mean_of_the_rows_of_the_span_before_it(period: float) -> None:
    time = 2.0 + period * np.arange(40)
    values = np.random.default_rng(1).uniform(0.0, 9.0, (40, 2))
    values[[0, 17]] = np.nan
    found = averaged(values, time, 0.1)
    whole = min(k for k in range(40) if time[k] >= time[0] + 0.1 - 1e-9)
    for k in range(40):
        end = max(k, whole)
        rows = [j for j in range(40) if time[end] - 0.1 + 1e-9 < time[j] <= time[end]]
        known = values[rows][np.isfinite(values[rows, 0])]
        expected = known.mean(axis=0) if len(known) else np.full(2, np.nan)
        np.testing.assert_allclose(found[k], expected, rtol=1e-12)


def test_a_run_shorter_than_the_span_has_one_mean() -> None:
    np.testing.assert_allclose(averaged(np.arange(5.0), 0.01 * np.arange(5), 0.1), 2.0)
