"""SE(2) on numbers worked by hand."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import tolerances as tol
from nhtrack import se2

PI = math.pi
QUARTER = PI / 2


def assert_close(actual: np.ndarray, expected: object) -> None:
    np.testing.assert_allclose(actual, expected, rtol=tol.HAND, atol=tol.HAND)


def test_product_of_two_poses() -> None:
    """Stand at (1, 2) looking along +y, walk 3 ahead and 1 left: (0, 5)."""
    a, b = np.array([1, 2, QUARTER]), np.array([3, 1, 0.25])
    assert_close(se2.compose(a, b), [0, 5, QUARTER + 0.25])


def test_pose_of_one_robot_seen_from_another() -> None:
    """Example 1 of the paper: the follower starts at (500, -500), looking down, the leader at the origin."""
    leader, follower = np.array([0, 0, 0.0]), np.array([500, -500, -QUARTER])
    assert_close(se2.between(leader, follower), [500, -500, -QUARTER])
    assert_close(se2.between(follower, leader), [-500, -500, QUARTER])


@pytest.mark.parametrize(
    ("X", "g"),
    [
        ([2, 3, 0], [2, 3, 0]),  # straight
        ([QUARTER, 0, QUARTER], [1, 1, QUARTER]),  # a quarter of the unit circle to the left
        ([QUARTER, 0, -QUARTER], [1, -1, -QUARTER]),  # to the right
        ([PI, 0, PI], [0, 2, PI]),  # half the circle
        ([-PI, 0, -PI], [0, 2, -PI]),  # the other half, driven backwards
        ([1.5 * PI, 0, 1.5 * PI], [-1, 1, 1.5 * PI]),  # three quarters: beyond the branch
    ],
)
def test_exp_and_log_on_the_unit_circle(X: list[float], g: list[float]) -> None:
    assert_close(se2.exp(np.array(X)), g)
    assert_close(se2.log(np.array(g)), X)


def test_hat_puts_components_in_their_places() -> None:
    np.testing.assert_array_equal(se2.hat(np.array([1.0, 2, 3])), [[0, -3, 1], [3, 0, 2], [0, 0, 0]])


def test_matrix_of_a_pose() -> None:
    assert_close(se2.matrix(np.array([1, 2, QUARTER])), [[0, -1, 1], [1, 0, 2], [0, 0, 1]])


def test_Ad_moves_a_twist_to_another_place() -> None:
    """A body spins at 2 rad/s about (3, 0): its point at the origin moves at 6 m/s along -y."""
    assert_close(se2.Ad(np.array([3, 0, 0.0]), np.array([0, 0, 2.0])), [0, -6, 2])
    assert_close(se2.Ad(np.array([0, 0, QUARTER]), np.array([1, 0, 0.0])), [0, 1, 0])


@pytest.mark.parametrize(
    ("theta", "wrapped", "turns"),
    [
        (0, 0, 0),
        (PI, PI, 0),
        (-PI, -PI, 0),
        (3 * PI, -PI, 1),
        (-3 * PI, PI, -1),
        (4, 4 - 2 * PI, 1),
        (7, 7 - 2 * PI, 1),
    ],
)
def test_whole_turns(theta: float, wrapped: float, turns: int) -> None:
    assert_close(se2.wrap(np.array(theta, dtype=float)), wrapped)
    assert se2.winding_number(np.array(theta, dtype=float)) == turns


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: se2.exp(np.zeros(2)), "X: expected shape (..., 3), got (2,)"),
        (lambda: se2.log(np.array(0.0)), "g: expected shape (..., 3), got ()"),
        (lambda: se2.compose(np.zeros(3), np.zeros((3, 2))), "b: expected shape (..., 3), got (3, 2)"),
        (lambda: se2.rotate(np.array(0.0), np.zeros(3)), "p: expected shape (..., 2), got (3,)"),
        (lambda: se2.vee(np.zeros((3, 2))), "matrix_: expected shape (..., 3), got (3, 2)"),
    ],
)
def test_wrong_shapes_are_named(call, message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        call()
