"""SE(2) against its axioms, against matrices, and against series summed in sixty decimal digits."""

from __future__ import annotations

import decimal
import math
from decimal import Decimal
from itertools import pairwise

import array_api_strict
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

import strategies as draw
import tolerances as tol
from nhtrack import se2

PI = math.pi
UNARY = [
    se2.inverse, se2.exp, se2.log, se2.hat, se2.matrix, se2.Ad_matrix, se2.ad_matrix, se2.right_jacobian,
    se2.left_jacobian, se2.right_jacobian_inverse,
]  # fmt: skip
few = settings(max_examples=25)  # of tests repeated for every function, whose examples are whole arrays
BINARY = [se2.compose, se2.between, se2.Ad, se2.Ad_inverse, se2.ad, se2.ad_transpose]


def length(*poses: np.ndarray) -> float:
    """Sum of the norms of the positions, what rounding in a product is relative to."""
    return sum(math.hypot(pose[0], pose[1]) for pose in poses)


def turn(*poses: np.ndarray) -> float:
    return sum(abs(float(pose[2])) for pose in poses)


def assert_within(actual: np.ndarray, expected: np.ndarray, bound: float) -> None:
    """Fails where an entry is further off than the bound, or NaN; a bound of zero asks for equality."""
    error = np.max(np.abs(actual - expected), initial=0.0)
    assert error <= bound, f"off by {error:.3g}, allowed {bound:.3g}"


def assert_same_pose(actual: np.ndarray, expected: np.ndarray, scale: float, angles: float) -> None:
    """Compares unwrapped poses made of positions of size `scale` and headings adding up to `angles`."""
    assert_within(actual[:2], expected[:2], scale * (tol.ALGEBRA + tol.ANGLE_SUM * angles))
    assert_within(actual[2], expected[2], tol.ANGLE_SUM * angles)


# -- independent references in sixty digits --------------------------------------------------------


def exact(array: np.ndarray) -> np.ndarray:
    """The same numbers as decimals, without rounding."""
    return np.vectorize(Decimal, otypes=[object])(array.astype(float))


def matrix_series(generator: np.ndarray, first_factorial: int) -> np.ndarray:
    """sum_k A^k / (k + first_factorial)!, k = 0 ... 69, for a 3x3 array, rounded once at the end."""
    with decimal.localcontext(prec=60):
        matrix = exact(generator)
        term = exact(np.eye(3)) / Decimal(math.factorial(first_factorial))
        total = term
        for k in range(1, 70):
            term = term @ matrix / Decimal(k + first_factorial)
            total = total + term
        return total.astype(float)


def solve_log(g: np.ndarray) -> np.ndarray:
    """q with V(theta) q = p by Cramer's rule, V from the Taylor series of sine and cosine."""
    with decimal.localcontext(prec=60):
        x, y, theta = (Decimal(float(value)) for value in g)
        terms = [theta**k / math.factorial(k + 1) for k in range(1, 70)]
        s = 1 + sum(terms[k - 1] * (-1) ** (k // 2) for k in range(2, 70, 2))
        c = sum(terms[k - 1] * (-1) ** (k // 2) for k in range(1, 70, 2))
        determinant = s * s + c * c
        return np.array([float((s * x + c * y) / determinant), float((s * y - c * x) / determinant)])


# -- the group -------------------------------------------------------------------------------------


@given(draw.poses, draw.poses, draw.poses)
def test_product_is_associative(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> None:
    left, right = se2.compose(se2.compose(a, b), c), se2.compose(a, se2.compose(b, c))
    assert_same_pose(left, right, length(a, b, c), turn(a, b, c))


@given(draw.poses)
def test_identity_changes_nothing(g: np.ndarray) -> None:
    np.testing.assert_array_equal(se2.compose(se2.identity(np), g), g)
    np.testing.assert_array_equal(se2.compose(g, se2.identity(np)), g)


@given(draw.poses)
def test_inverse_undoes_from_both_sides(g: np.ndarray) -> None:
    for product in (se2.compose(g, se2.inverse(g)), se2.compose(se2.inverse(g), g)):
        assert_same_pose(product, np.zeros(3), length(g), 0.0)


@given(draw.poses, draw.poses)
def test_product_is_the_product_of_matrices(a: np.ndarray, b: np.ndarray) -> None:
    bound = (1 + length(a, b)) * (tol.ALGEBRA + tol.ANGLE_SUM * turn(a, b))
    assert_within(se2.matrix(se2.compose(a, b)), se2.matrix(a) @ se2.matrix(b), bound)


@given(draw.poses, draw.poses)
def test_between_is_inverse_times_pose(a: np.ndarray, b: np.ndarray) -> None:
    expected = se2.compose(se2.inverse(a), b)
    assert_same_pose(se2.between(a, b), expected, length(a, b), turn(a, b))


@given(draw.any_angles, st.integers(-1000, 1000), st.integers(-1000, 1000))
def test_between_loses_no_digits_far_from_the_origin(theta: float, x: int, y: int) -> None:
    """Near poses 2^30 m away, every coordinate a double: their offset is seen as at the origin."""
    offset, place = np.array([x, y]) / 1024.0, np.array([2.0**30, -(2.0**30)])
    a, b = np.array([*place, theta]), np.array([*(place + offset), theta])
    expected = se2.between(np.array([0.0, 0.0, theta]), np.array([*offset, theta]))
    np.testing.assert_array_equal(se2.between(a, b), expected)


@given(draw.poses, draw.poses, draw.poses)
def test_between_does_not_see_where_the_origin_is(origin: np.ndarray, a: np.ndarray, b: np.ndarray) -> None:
    moved = se2.between(se2.compose(origin, a), se2.compose(origin, b))
    assert_same_pose(moved, se2.between(a, b), length(origin, a, b), turn(origin, a, b))


@given(draw.poses, draw.poses)
def test_action_moves_the_origin_of_a_pose(g: np.ndarray, b: np.ndarray) -> None:
    assert_within(se2.act(g, b[:2]), se2.compose(g, b)[:2], tol.ALGEBRA * length(g, b))
    homogeneous = se2.matrix(g) @ np.array([b[0], b[1], 1.0])
    assert_within(se2.act(g, b[:2]), homogeneous[:2], tol.ALGEBRA * length(g, b))


# -- exp and log -----------------------------------------------------------------------------------


@given(draw.log_poses)
@example(np.array([3.0, -2.0, 5e-324]))
def test_exp_is_the_series_of_its_matrix(X: np.ndarray) -> None:
    reference = matrix_series(se2.hat(X), 0)
    assert_within(se2.exp(X)[:2], reference[:2, 2], tol.COEFFICIENT * length(X))
    assert se2.exp(X)[2] == X[2]


@given(draw.log_poses)
def test_exp_is_scipys_matrix_exponential(X: np.ndarray) -> None:
    assert_within(se2.matrix(se2.exp(X)), expm(se2.hat(X)), tol.EXPM * (1 + length(X)))


@given(draw.log_poses)
@example(np.array([3.0, -2.0, 5e-324]))
@example(np.array([3.0, -2.0, math.nextafter(2 * PI, 0)]))
def test_log_solves_v_q_equals_p(g: np.ndarray) -> None:
    reference = solve_log(g)
    assert_within(se2.log(g)[:2], reference, tol.COEFFICIENT * float(np.linalg.norm(reference)))
    assert se2.log(g)[2] == g[2]


@given(draw.log_poses)
@example(np.array([500.0, -500.0, PI]))
@example(np.array([500.0, -500.0, -PI]))
def test_log_undoes_exp(X: np.ndarray) -> None:
    assert_within(se2.log(se2.exp(X)), X, tol.ROUND_TRIP * length(X))


@given(draw.log_poses)
def test_exp_undoes_log(g: np.ndarray) -> None:
    assert_within(se2.exp(se2.log(g)), g, tol.ROUND_TRIP * length(g))


@given(draw.log_poses)
def test_log_of_the_inverse_is_minus_log(g: np.ndarray) -> None:
    X = se2.log(g)
    assert_within(se2.log(se2.inverse(g)), -X, tol.ALGEBRA * length(X))


@given(draw.log_poses)
def test_mirror_image_has_the_mirrored_log(g: np.ndarray) -> None:
    """Reflection in the x axis, exactly: what turned left turns right, at +-pi too."""
    mirror = np.array([1.0, -1.0, -1.0])
    np.testing.assert_array_equal(se2.log(g * mirror), se2.log(g) * mirror)
    np.testing.assert_array_equal(se2.exp(g * mirror), se2.exp(g) * mirror)


@given(draw.lengths, draw.lengths)
def test_sign_of_pi_names_the_branch(x: float, y: float) -> None:
    """One place, reached by half a turn left or right: q is p rotated by a right angle each way."""
    left, right = se2.log(np.array([x, y, PI])), se2.log(np.array([x, y, -PI]))
    bound = tol.COEFFICIENT * PI * math.hypot(x, y)
    assert_within(left, np.array([y * PI / 2, -x * PI / 2, PI]), bound)
    assert_within(right, np.array([-y * PI / 2, x * PI / 2, -PI]), bound)


# -- adjoints --------------------------------------------------------------------------------------


def moment(g: np.ndarray, *twists: np.ndarray) -> float:
    """Size of the terms of Ad_g xi: speeds, and angular velocities times the arm."""
    return sum(math.hypot(xi[0], xi[1]) + abs(float(xi[2])) * (1 + length(g)) for xi in twists)


@given(draw.twists)
def test_vee_undoes_hat(xi: np.ndarray) -> None:
    np.testing.assert_array_equal(se2.vee(se2.hat(xi)), xi)


@given(draw.poses, draw.twists)
def test_Ad_is_conjugation_of_the_matrix(g: np.ndarray, xi: np.ndarray) -> None:
    conjugate = se2.matrix(g) @ se2.hat(xi) @ se2.matrix(se2.inverse(g))
    assert_within(se2.hat(se2.Ad(g, xi)), conjugate, tol.ALGEBRA * moment(g, xi))


@given(draw.poses, draw.twists)
def test_Ad_matrix_times_twist_is_Ad(g: np.ndarray, xi: np.ndarray) -> None:
    assert_within(se2.Ad_matrix(g) @ xi, se2.Ad(g, xi), tol.ALGEBRA * moment(g, xi))


@given(draw.poses, draw.twists)
def test_Ad_inverse_is_Ad_of_the_inverse(g: np.ndarray, xi: np.ndarray) -> None:
    assert_within(se2.Ad_inverse(g, xi), se2.Ad(se2.inverse(g), xi), tol.ALGEBRA * moment(g, xi))
    assert_within(se2.Ad_inverse(g, se2.Ad(g, xi)), xi, tol.ALGEBRA * moment(g, xi))


@given(draw.poses, draw.poses, draw.twists)
def test_Ad_of_a_product_is_the_product_of_Ads(a: np.ndarray, b: np.ndarray, xi: np.ndarray) -> None:
    both = se2.compose(a, b)
    bound = (tol.ALGEBRA + tol.ANGLE_SUM * turn(a, b)) * (moment(a, xi) + moment(b, xi))
    assert_within(se2.Ad(both, xi), se2.Ad(a, se2.Ad(b, xi)), bound)


@given(draw.twists, draw.twists)
def test_ad_is_the_commutator(xi: np.ndarray, eta: np.ndarray) -> None:
    commutator = se2.hat(xi) @ se2.hat(eta) - se2.hat(eta) @ se2.hat(xi)
    bound = tol.ALGEBRA * float(np.linalg.norm(xi) * np.linalg.norm(eta))
    assert_within(se2.hat(se2.ad(xi, eta)), commutator, bound)
    assert_within(se2.ad_matrix(xi) @ eta, se2.ad(xi, eta), bound)
    np.testing.assert_array_equal(se2.ad(xi, eta), -se2.ad(eta, xi))


@given(draw.twists, draw.twists)
def test_ad_transpose_is_the_transpose_and_does_no_work(xi: np.ndarray, momentum: np.ndarray) -> None:
    bound = tol.ALGEBRA * float(np.linalg.norm(xi) * np.linalg.norm(momentum))
    assert_within(se2.ad_transpose(xi, momentum), se2.ad_matrix(xi).T @ momentum, bound)
    power = float(xi @ se2.ad_transpose(xi, momentum))
    assert abs(power) <= bound * float(np.linalg.norm(xi))


@given(draw.log_poses)
def test_Ad_of_exp_is_the_series_of_ad(X: np.ndarray) -> None:
    reference = matrix_series(se2.ad_matrix(X), 0)
    assert_within(se2.Ad_matrix(se2.exp(X)), reference, tol.ALGEBRA * (1 + length(X)))


# -- Jacobians of exp ------------------------------------------------------------------------------


@given(draw.log_poses)
@example(np.array([3.0, -2.0, 5e-324]))
@example(np.array([3.0, -2.0, 1.0]))
@example(np.array([3.0, -2.0, math.nextafter(1.0, 0.0)]))
def test_right_jacobian_is_the_series_of_minus_ad(X: np.ndarray) -> None:
    """Rotation block and arm apart: each is a rotation times a number, so each is right to rounding."""
    J, reference = se2.right_jacobian(X), matrix_series(-se2.ad_matrix(X), 1)
    for block in (np.s_[:2, :2], np.s_[:2, 2], np.s_[2, :]):
        assert_within(J[block], reference[block], tol.COEFFICIENT * float(np.linalg.norm(reference[block])))


@given(draw.log_angles)
def test_arm_of_the_jacobian_keeps_its_digits_near_zero(theta: float) -> None:
    """(theta - sin theta)/theta^2 alone: relative to itself, down to the smallest angles."""
    e = se2.right_jacobian(np.array([1.0, 0.0, theta]))[0, 2]
    with decimal.localcontext(prec=60):
        exact_theta = Decimal(theta)
        terms = (exact_theta**k / math.factorial(k + 2) * (-1) ** (k // 2) for k in range(1, 70, 2))
        reference = float(sum(terms))
    assert abs(e - reference) <= tol.COEFFICIENT * abs(reference)


@given(draw.triples(st.floats(-6.0, 6.0)).filter(lambda X: length(X) < 10))
def test_right_jacobian_is_the_derivative_of_exp(X: np.ndarray) -> None:
    step = 1e-5
    ahead, behind = se2.exp(X + step * np.eye(3)), se2.exp(X - step * np.eye(3))
    difference = se2.log(se2.between(behind, ahead)) / (2 * step)
    assert_within(difference.T, se2.right_jacobian(X), tol.FINITE_DIFFERENCE * (1 + length(X)))


@given(draw.log_poses)
def test_right_jacobian_inverse_times_right_jacobian_is_one(X: np.ndarray) -> None:
    J_inv, J = se2.right_jacobian_inverse(X), se2.right_jacobian(X)
    rounding = tol.ALGEBRA * (np.abs(J_inv) @ np.abs(J))
    assert np.all(np.abs(J_inv @ J - np.eye(3)) <= rounding)


@given(draw.log_poses)
def test_left_jacobian_is_the_right_one_seen_from_the_parent_frame(X: np.ndarray) -> None:
    expected = se2.Ad_matrix(se2.exp(X)) @ se2.right_jacobian(X)
    assert_within(se2.left_jacobian(X), expected, tol.ALGEBRA * (1 + length(X)))


# -- batches and other array libraries -------------------------------------------------------------


@pytest.mark.parametrize("function", UNARY)
@few
@given(draw.batches(1))
def test_batch_equals_loop(function, arrays) -> None:
    (batch,) = arrays
    result = function(batch)
    assert result.shape[: batch.ndim - 1] == batch.shape[:-1]
    for index in np.ndindex(batch.shape[:-1]):
        np.testing.assert_array_equal(result[index], function(batch[index]))


@pytest.mark.parametrize("function", BINARY)
@few
@given(draw.batches(2))
def test_batch_of_pairs_equals_loop(function, arrays) -> None:
    first, second = arrays
    result = function(first, second)
    assert result.shape == first.shape
    for index in np.ndindex(first.shape[:-1]):
        np.testing.assert_array_equal(result[index], function(first[index], second[index]))


@pytest.mark.parametrize("function", BINARY)
@few
@given(draw.batches(1), draw.log_poses)
def test_one_against_a_batch_broadcasts(function, arrays, one) -> None:
    (batch,) = arrays
    repeated = np.broadcast_to(one, batch.shape)
    np.testing.assert_array_equal(function(one, batch), function(repeated, batch))
    np.testing.assert_array_equal(function(batch, one), function(batch, repeated))


@pytest.mark.parametrize("function", UNARY)
@few
@given(draw.batches(1))
def test_runs_on_the_bare_array_api(function, arrays) -> None:
    """array-api-strict fails on whatever the standard does not promise; its numbers are NumPy's."""
    result = function(*(array_api_strict.asarray(array) for array in arrays))
    np.testing.assert_array_equal(np.asarray(result), function(*arrays))


@pytest.mark.parametrize("function", BINARY)
@few
@given(draw.batches(2))
def test_pairs_run_on_the_bare_array_api(function, arrays) -> None:
    result = function(*(array_api_strict.asarray(array) for array in arrays))
    np.testing.assert_array_equal(np.asarray(result), function(*arrays))


@given(draw.batches(1))
def test_the_rest_runs_on_the_bare_array_api(arrays) -> None:
    (g,) = arrays
    strict = array_api_strict.asarray(g)
    theta, points = strict[..., 2], strict[..., :2]
    previous = se2.winding_number(theta)
    for actual, expected in [
        (se2.rotate(theta, points), se2.rotate(g[..., 2], g[..., :2])),
        (se2.act(strict, points), se2.act(g, g[..., :2])),
        (se2.vee(se2.hat(strict)), g),
        (se2.wrap(theta), se2.wrap(g[..., 2])),
        (previous, se2.winding_number(g[..., 2])),
        (se2.winding_number(theta, previous + 1, 0.1), se2.winding_number(g[..., 2], previous + 1, 0.1)),
        (se2.identity(array_api_strict, g.shape[:-1]), np.zeros(g.shape)),
    ]:
        np.testing.assert_array_equal(np.asarray(actual), np.asarray(expected))


@pytest.mark.parametrize("function", [*UNARY, *BINARY])
def test_single_precision_stays_single(function) -> None:
    pose = np.ones((2, 3), dtype=np.float32)
    arguments = (pose,) if function in UNARY else (pose, pose)
    assert function(*arguments).dtype == np.float32


# -- headings --------------------------------------------------------------------------------------


@given(draw.any_angles)
def test_wrap_takes_off_whole_turns(theta: float) -> None:
    wrapped = float(se2.wrap(np.array(theta)))
    turns = (theta - wrapped) / (2 * PI)
    assert abs(turns - round(turns)) <= tol.ANGLE_SUM * (1 + abs(theta))
    assert abs(wrapped) <= PI + tol.ANGLE_SUM * (1 + abs(theta))


@given(draw.branch_angles)
def test_wrap_leaves_the_branch_alone(theta: float) -> None:
    assert float(se2.wrap(np.array(theta))) == theta
    assert float(se2.winding_number(np.array(theta))) == 0.0


hystereses = st.floats(0.01, 3.0)


@given(draw.heading_walks, hystereses)
def test_winding_number_keeps_log_away_from_its_singularity(walk: list[float], hysteresis: float) -> None:
    """After every update the heading is at most the hysteresis past the branch, and turns are whole."""
    turns = None
    for theta in np.array(walk):
        turns = se2.winding_number(theta, turns, hysteresis)
        assert turns == np.round(turns)
        assert abs(theta - 2 * PI * turns) <= PI + hysteresis + tol.ANGLE_SUM * abs(theta)


@given(draw.heading_walks, hystereses)
def test_winding_number_changes_only_past_the_hysteresis(walk: list[float], hysteresis: float) -> None:
    turns = [se2.winding_number(np.array(walk[0]))]
    for theta in np.array(walk[1:]):
        turns.append(se2.winding_number(theta, turns[-1], hysteresis))
    for theta, (before, after) in zip(walk[1:], pairwise(turns), strict=True):
        past = abs(theta - 2 * PI * before) > PI + hysteresis
        assert (before != after) == past


@given(st.integers(-5, 4), st.lists(st.floats(-0.999, 0.999), min_size=1, max_size=40), hystereses)
def test_winding_number_does_not_chatter_at_the_antipode(
    half: int, noise: list[float], hysteresis: float
) -> None:
    """Any noise smaller than the hysteresis about an odd multiple of pi: the first choice stands."""
    headings = (2 * half + 1) * PI + hysteresis * np.array(noise)
    first = turns = se2.winding_number(headings[0])
    for theta in headings[1:]:
        turns = se2.winding_number(theta, turns, hysteresis)
        assert turns == first


@given(draw.heading_walks, hystereses)
def test_winding_number_is_the_same_for_the_mirror_image(walk: list[float], hysteresis: float) -> None:
    turns = mirrored = None
    for theta in np.array(walk):
        turns = se2.winding_number(theta, turns, hysteresis)
        mirrored = se2.winding_number(-theta, mirrored, hysteresis)
        assert mirrored == -turns


@given(draw.batches(1, draw.any_angles), st.integers(-3, 3), hystereses)
def test_winding_numbers_of_a_batch_equal_a_loop(arrays, previous: int, hysteresis: float) -> None:
    theta = arrays[0][..., 2]
    memory = np.full(theta.shape, float(previous))
    for held in (None, memory):
        result = se2.winding_number(theta, held, hysteresis)
        assert result.shape == theta.shape
        for index in np.ndindex(theta.shape):
            alone = se2.winding_number(theta[index], None if held is None else held[index], hysteresis)
            assert result[index] == alone
