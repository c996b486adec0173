"""Scaling between a scenario's units and the robot's: hand-worked numbers, inverses, and the equations of motion."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tolerances as tol
from nhtrack.similarity import Similarity

factors = st.floats(1e-3, 1e3)
EXAMPLE_1 = Similarity(length=0.004, time=4.0)


def test_example_1_by_hand() -> None:
    pose = EXAMPLE_1.poses_to_robot(np.array([500.0, -500.0, -math.pi / 2]))
    twist = EXAMPLE_1.twists_to_robot(np.array([10.0, 0.0, 2.0]))
    u = EXAMPLE_1.inputs_to_robot(np.array([10.0, 0.15]))
    np.testing.assert_allclose(pose, [2.0, -2.0, -math.pi / 2], rtol=tol.HAND)
    np.testing.assert_allclose(twist, [0.01, 0.0, 0.5], rtol=tol.HAND)
    np.testing.assert_allclose(u, [0.0025, 0.009375], rtol=tol.HAND)
    assert EXAMPLE_1.times_to_robot(20.0) == 80.0


def test_a_quantity_of_any_unit_by_hand() -> None:
    """A gain per length^2 and time, and a speed."""
    assert Similarity(length=0.5, time=4.0).scale(3.0, length=-2, time=-1) == 3.0
    assert Similarity(length=0.5, time=4.0).scale(8.0, length=1, time=-1) == 1.0


@given(factors, factors)
def test_scenario_and_robot_are_inverse(length: float, time: float) -> None:
    there, rng = Similarity(length, time), np.random.default_rng(1)
    g, xi, u = rng.normal(size=(2, 5, 3)), rng.normal(size=(5, 3)), rng.normal(size=(5, 2))
    np.testing.assert_allclose(there.poses_to_scenario(there.poses_to_robot(g)), g, rtol=tol.ALGEBRA)
    np.testing.assert_allclose(there.twists_to_scenario(there.twists_to_robot(xi)), xi, rtol=tol.ALGEBRA)
    np.testing.assert_allclose(there.inputs_to_scenario(there.inputs_to_robot(u)), u, rtol=tol.ALGEBRA)
    np.testing.assert_allclose(there.times_to_scenario(there.times_to_robot(3.0)), 3.0, rtol=tol.ALGEBRA)


@pytest.mark.parametrize("factor", [0.0, -1.0, math.nan, math.inf])
@pytest.mark.parametrize("name", ["length", "time"])
def test_factors_are_positive(name: str, factor: float) -> None:
    with pytest.raises(ValueError, match=rf"similarity\.{name}: expected a positive number"):
        Similarity(**{name: factor})


def test_a_wrong_shape_is_refused() -> None:
    with pytest.raises(ValueError, match=r"poses: expected shape \(\.\.\., 3\), got \(2,\)"):
        EXAMPLE_1.poses_to_robot(np.zeros(2))
