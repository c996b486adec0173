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


def test_rotation_by_a_quarter_turn() -> None:
    assert_close(se2.rotate(np.array(QUARTER), np.array([3.0, 4.0])), [-4, 3])


def test_product_of_two_poses() -> None:
    """Stand at (1, 2) looking along +y, walk 3 ahead and 1 left: (0, 5)."""
    a, b = np.array([1, 2, QUARTER]), np.array([3, 1, 0.25])
    assert_close(se2.compose(a, b), [0, 5, QUARTER + 0.25])


def test_headings_add_without_wrapping() -> None:
    three_quarters = np.array([0, 0, 3 * QUARTER])
    assert_close(se2.compose(three_quarters, three_quarters), [0, 0, 3 * PI])


def test_inverse_of_a_pose() -> None:
    """From (1, 2) looking along +y the origin lies 2 behind and 1 to the left."""
    assert_close(se2.inverse(np.array([1, 2, QUARTER])), [-2, 1, -QUARTER])


def test_pose_of_one_robot_seen_from_another() -> None:
    """Example 1 of the paper: the follower starts at (500, -500), looking down, the leader at the origin."""
    leader, follower = np.array([0, 0, 0.0]), np.array([500, -500, -QUARTER])
    assert_close(se2.between(leader, follower), [500, -500, -QUARTER])
    assert_close(se2.between(follower, leader), [-500, -500, QUARTER])


def test_points_move_with_the_pose() -> None:
    points = np.array([[1.0, 0.0], [0.0, 1.0]])
    assert_close(se2.act(np.array([10, 20, QUARTER]), points), [[10, 21], [9, 20]])


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


def test_exp_of_a_whole_turn_comes_back() -> None:
    assert_close(se2.exp(np.array([2 * PI, 0, 2 * PI])), [0, 0, 2 * PI])


def test_hat_puts_components_in_their_places() -> None:
    np.testing.assert_array_equal(se2.hat(np.array([1.0, 2, 3])), [[0, -3, 1], [3, 0, 2], [0, 0, 0]])


def test_matrix_of_a_pose() -> None:
    assert_close(se2.matrix(np.array([1, 2, QUARTER])), [[0, -1, 1], [1, 0, 2], [0, 0, 1]])


def test_Ad_moves_a_twist_to_another_place() -> None:
    """A body spins at 2 rad/s about (3, 0): its point at the origin moves at 6 m/s along -y."""
    assert_close(se2.Ad(np.array([3, 0, 0.0]), np.array([0, 0, 2.0])), [0, -6, 2])
    assert_close(se2.Ad(np.array([0, 0, QUARTER]), np.array([1, 0, 0.0])), [0, 1, 0])


def test_Ad_inverse_carries_a_leaders_twist_to_its_follower() -> None:
    """A point 1 m ahead of a leader turning at 2 rad/s is swept left at 2 m/s (r_x omega_0)."""
    ahead, to_the_left = np.array([1, 0, 0.0]), np.array([0, 1, 0.0])
    leader = np.array([0.5, 0, 2.0])
    assert_close(se2.Ad_inverse(ahead, leader), [0.5, 2, 2])
    assert_close(se2.Ad_inverse(to_the_left, leader), [0.5 - 2, 0, 2])


def test_bracket_of_rolling_and_turning_is_sliding() -> None:
    """[turn, roll] = slide: why a robot that cannot slide can still be parked anywhere."""
    roll, turn, slide = np.array([1, 0, 0.0]), np.array([0, 0, 1.0]), np.array([0, 1, 0.0])
    np.testing.assert_array_equal(se2.ad(turn, roll), slide)
    np.testing.assert_array_equal(se2.ad(roll, turn), -slide)


def test_coadjoint_term_is_the_lateral_force_of_a_turning_robot() -> None:
    """m = 2, v = 3, omega = 4: ad^T I xi = (0, -m omega v, 0), so the wheels push 24 N to the left."""
    xi = np.array([3.0, 0, 4.0])
    np.testing.assert_array_equal(se2.ad_transpose(xi, np.array([2, 2, 5]) * xi), [0, -24, 0])


def test_right_jacobian_at_a_quarter_turn() -> None:
    """theta = pi/2: s = c = 2/pi, e = (pi/2 - 1) 4/pi^2, f = 4/pi^2."""
    e, f = (PI / 2 - 1) * 4 / PI**2, 4 / PI**2
    expected = [[2 / PI, 2 / PI, e * 2 - f * 3], [-2 / PI, 2 / PI, f * 2 + e * 3], [0, 0, 1]]
    assert_close(se2.right_jacobian(np.array([2, 3, QUARTER])), expected)


def test_jacobians_at_zero_turn() -> None:
    """J = 1 -+ ad_X/2 without rotation."""
    X = np.array([2, 3, 0.0])
    half_ad = np.array([[0, 0, 1.5], [0, 0, -1], [0, 0, 0]])
    assert_close(se2.right_jacobian(X), np.eye(3) - half_ad)
    assert_close(se2.left_jacobian(X), np.eye(3) + half_ad)
    assert_close(se2.right_jacobian_inverse(X), np.eye(3) + half_ad)


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


def test_winding_number_holds_until_the_hysteresis_is_passed() -> None:
    headings = np.array([3.0, 3.3, 3.39, 3.4, 3.0, 2.9, 2.8])
    turns, seen = np.array(0.0), []
    for theta in headings:
        turns = se2.winding_number(theta, turns, hysteresis=0.25)
        seen.append(float(turns))
    # pi + 0.25 = 3.3916; back again only below 2 pi - 3.3916 = 2.8916
    assert seen == [0, 0, 0, 1, 1, 1, 0]


def test_winding_number_recovers_from_many_turns_at_once() -> None:
    assert se2.winding_number(np.array(20 * PI + 0.1), np.array(0.0)) == 10


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
