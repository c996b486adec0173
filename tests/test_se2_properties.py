"""SE(2) against its axioms, against matrices, and against series summed in sixty decimal digits.

Hundreds of poses and twists side by side, among them all angles that break trigonometric code.
"""

from __future__ import annotations

import decimal
import math
from decimal import Decimal

import array_api_strict
import numpy as np
import pytest

import tolerances as tol
from angles import ANY_ANGLES, BRANCH, LOG_ANGLES, log_poses, poses, triples, twists
from nhtrack import se2

pytestmark = pytest.mark.property

PI = math.pi
UNARY = [
    se2.inverse, se2.exp, se2.log, se2.hat, se2.matrix, se2.Ad_matrix, se2.ad_matrix, se2.right_jacobian,
    se2.left_jacobian, se2.right_jacobian_inverse,
]  # fmt: skip
BINARY = [se2.compose, se2.between, se2.Ad, se2.Ad_inverse, se2.ad, se2.ad_transpose]
MIRROR = np.array([1.0, -1.0, -1.0])


# -- sizes and errors ------------------------------------------------------------------------------


def length(*poses: np.ndarray) -> np.ndarray:
    """Sum of the norms of the positions, what rounding in a product is relative to."""
    return np.asarray(sum(np.hypot(pose[:, 0], pose[:, 1]) for pose in poses))


def turn(*poses: np.ndarray) -> np.ndarray:
    return np.asarray(sum(np.abs(pose[:, 2]) for pose in poses))


def assert_within(actual: np.ndarray, expected: np.ndarray, bound: np.ndarray | float) -> None:
    """Fails where an entry of a row is further off than the row's bound, or NaN; a bound of zero asks for equality."""
    error = np.abs(actual - expected).reshape(len(actual), -1).max(axis=1)
    worst = int(np.argmax(~(error <= bound)))
    assert (error <= bound).all(), f"row {worst}: off by {error[worst]:.3g}, got {actual[worst]}"


def assert_same_pose(actual: np.ndarray, expected: np.ndarray, scale: np.ndarray, angles: np.ndarray) -> None:
    """Compares unwrapped poses made of positions of size `scale` and headings adding up to `angles`."""
    assert_within(actual[:, :2], expected[:, :2], scale * (tol.ALGEBRA + tol.ANGLE_SUM * angles))
    assert_within(actual[:, 2], expected[:, 2], tol.ANGLE_SUM * angles)


# -- independent references in sixty digits --------------------------------------------------------


def matrix_series(generators: np.ndarray, first_factorial: int) -> np.ndarray:
    """sum_k A^k / (k + first_factorial)!, k = 0 ... 69, for 3x3 arrays, rounded once at the end."""
    exact = np.vectorize(Decimal, otypes=[object])
    with decimal.localcontext(prec=60):
        matrices = exact(generators)
        term = exact(np.broadcast_to(np.eye(3), generators.shape)) / Decimal(math.factorial(first_factorial))
        total = term
        for k in range(1, 70):
            term = (term[..., None] * matrices[:, None]).sum(axis=2) / Decimal(k + first_factorial)
            total = total + term
        return total.astype(float)


def solve_log(g: np.ndarray) -> np.ndarray:
    """q with V(theta) q = p by Cramer's rule, V from the Taylor series of sine and cosine, for one pose."""
    with decimal.localcontext(prec=60):
        x, y, theta = (Decimal(float(value)) for value in g)
        terms = [theta**k / math.factorial(k + 1) for k in range(1, 70)]
        s = 1 + sum(terms[k - 1] * (-1) ** (k // 2) for k in range(2, 70, 2))
        c = sum(terms[k - 1] * (-1) ** (k // 2) for k in range(1, 70, 2))
        determinant = s * s + c * c
        return np.array([float((s * x + c * y) / determinant), float((s * y - c * x) / determinant)])


# -- the group -------------------------------------------------------------------------------------


def test_product_is_the_product_of_matrices() -> None:
    a, b, c = poses(1), poses(2), poses(3)
    bound = (1 + length(a, b)) * (tol.ALGEBRA + tol.ANGLE_SUM * turn(a, b))
    assert_within(se2.matrix(se2.compose(a, b)), se2.matrix(a) @ se2.matrix(b), bound)
    left, right = se2.compose(se2.compose(a, b), c), se2.compose(a, se2.compose(b, c))
    assert_same_pose(left, right, length(a, b, c), turn(a, b, c))


def test_identity_changes_nothing_and_inverse_undoes_from_both_sides() -> None:
    g = poses(1)
    np.testing.assert_array_equal(se2.compose(se2.identity(np), g), g)
    np.testing.assert_array_equal(se2.compose(g, se2.identity(np)), g)
    for product in (se2.compose(g, se2.inverse(g)), se2.compose(se2.inverse(g), g)):
        assert_same_pose(product, np.zeros_like(g), length(g), np.zeros(len(g)))


def test_between_is_inverse_times_pose_wherever_the_origin_is() -> None:
    a, b, origin = poses(1), poses(2), poses(3)
    seen = se2.between(a, b)
    assert_same_pose(seen, se2.compose(se2.inverse(a), b), length(a, b), turn(a, b))
    moved = se2.between(se2.compose(origin, a), se2.compose(origin, b))
    assert_same_pose(moved, seen, length(origin, a, b), turn(origin, a, b))


def test_between_loses_no_digits_far_from_the_origin() -> None:
    """Near poses 2^30 m away, every coordinate a double: their offset is seen as at the origin."""
    theta = ANY_ANGLES[:, None]
    offset = np.random.default_rng(1).integers(-1000, 1000, (len(theta), 2)) / 1024.0
    place = np.broadcast_to([2.0**30, -(2.0**30)], offset.shape)
    expected = se2.between(np.column_stack([0 * offset, theta]), np.column_stack([offset, theta]))
    found = se2.between(np.column_stack([place, theta]), np.column_stack([place + offset, theta]))
    np.testing.assert_array_equal(found, expected)


def test_action_moves_the_origin_of_a_pose() -> None:
    g, b = poses(1), poses(2)
    assert_within(se2.act(g, b[:, :2]), se2.compose(g, b)[:, :2], tol.ALGEBRA * length(g, b))


# -- exp and log -----------------------------------------------------------------------------------


def test_exp_is_the_series_of_its_matrix() -> None:
    X = log_poses(1)
    found = se2.exp(X)
    assert_within(found[:, :2], matrix_series(se2.hat(X), 0)[:, :2, 2], tol.COEFFICIENT * length(X))
    np.testing.assert_array_equal(found[:, 2], X[:, 2])


def test_log_solves_v_q_equals_p() -> None:
    g = log_poses(1)
    reference, found = np.array([solve_log(each) for each in g]), se2.log(g)
    assert_within(found[:, :2], reference, tol.COEFFICIENT * np.hypot(*reference.T))
    np.testing.assert_array_equal(found[:, 2], g[:, 2])


def test_log_undoes_exp() -> None:
    X = log_poses(1)
    assert_within(se2.log(se2.exp(X)), X, tol.ROUND_TRIP * length(X))


def test_mirror_image_has_the_mirrored_log() -> None:
    """Reflection in the x axis, exactly: what turned left turns right, at +-pi too."""
    g = log_poses(1)
    np.testing.assert_array_equal(se2.log(g * MIRROR), se2.log(g) * MIRROR)
    np.testing.assert_array_equal(se2.exp(g * MIRROR), se2.exp(g) * MIRROR)


def test_sign_of_pi_names_the_branch() -> None:
    """One place, reached by half a turn left or right: q is p rotated by a right angle each way."""
    left = triples(np.full(50, PI), 1)
    x, y, bound = left[:, 0], left[:, 1], tol.COEFFICIENT * PI * length(left)
    assert_within(se2.log(left), np.column_stack([y * PI / 2, -x * PI / 2, left[:, 2]]), bound)
    right = left * [1.0, 1.0, -1.0]
    assert_within(se2.log(right), np.column_stack([-y * PI / 2, x * PI / 2, right[:, 2]]), bound)


# -- adjoints --------------------------------------------------------------------------------------


def moment(g: np.ndarray, xi: np.ndarray) -> np.ndarray:
    """Size of the terms of Ad_g xi: speeds, and angular velocities times the arm."""
    return length(xi) + turn(xi) * (1 + length(g))


def columns(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    return np.asarray((matrix @ vector[..., None])[..., 0])


def test_Ad_is_conjugation_of_the_matrix() -> None:
    g, xi = poses(1), twists(2)
    bound = tol.ALGEBRA * moment(g, xi)
    conjugate = se2.matrix(g) @ se2.hat(xi) @ se2.matrix(se2.inverse(g))
    assert_within(se2.hat(se2.Ad(g, xi)), conjugate, bound)
    assert_within(columns(se2.Ad_matrix(g), xi), se2.Ad(g, xi), bound)
    assert_within(se2.Ad_inverse(g, xi), se2.Ad(se2.inverse(g), xi), bound)
    assert_within(se2.Ad_inverse(g, se2.Ad(g, xi)), xi, bound)
    np.testing.assert_array_equal(se2.vee(se2.hat(xi)), xi)


def test_ad_is_the_commutator() -> None:
    xi, eta = twists(1), twists(2)
    bound = tol.ALGEBRA * np.linalg.norm(xi, axis=1) * np.linalg.norm(eta, axis=1)
    commutator = se2.hat(xi) @ se2.hat(eta) - se2.hat(eta) @ se2.hat(xi)
    assert_within(se2.hat(se2.ad(xi, eta)), commutator, bound)
    assert_within(columns(se2.ad_matrix(xi), eta), se2.ad(xi, eta), bound)
    np.testing.assert_array_equal(se2.ad(xi, eta), -se2.ad(eta, xi))
    transposed = se2.ad_transpose(xi, eta)
    assert_within(transposed, columns(np.swapaxes(se2.ad_matrix(xi), 1, 2), eta), bound)
    assert_within((xi * transposed).sum(axis=1), np.zeros(len(xi)), bound * np.linalg.norm(xi, axis=1))  # no work


# -- Jacobians of exp ------------------------------------------------------------------------------


def test_right_jacobian_is_the_series_of_minus_ad() -> None:
    """Rotation block and arm apart: each is a rotation times a number, so each is right to rounding."""
    X = log_poses(1)
    J, reference = se2.right_jacobian(X), matrix_series(-se2.ad_matrix(X), 1)
    for rows, column in ((slice(2), slice(2)), (slice(2), 2), (2, slice(3))):
        expected = reference[:, rows, column].reshape(len(X), -1)
        bound = tol.COEFFICIENT * np.linalg.norm(expected, axis=1)
        assert_within(J[:, rows, column].reshape(len(X), -1), expected, bound)


def test_arm_of_the_jacobian_keeps_its_digits_near_zero() -> None:
    """(theta - sin theta)/theta^2 alone: relative to itself, down to the smallest angles."""
    found = se2.right_jacobian(np.column_stack([np.ones_like(LOG_ANGLES), 0 * LOG_ANGLES, LOG_ANGLES]))[:, 0, 2]
    with decimal.localcontext(prec=60):
        terms = [
            sum(Decimal(theta) ** k / math.factorial(k + 2) * (-1) ** (k // 2) for k in range(1, 70, 2))
            for theta in LOG_ANGLES.tolist()
        ]
    reference = np.array(terms, dtype=float)
    assert_within(found, reference, tol.COEFFICIENT * np.abs(reference))


def test_right_jacobian_is_the_derivative_of_exp() -> None:
    step, X = 1e-5, np.random.default_rng(1).uniform(-6.0, 6.0, (300, 3))
    ahead, behind = (se2.exp(X[:, None] + sign * step * np.eye(3)) for sign in (1, -1))
    difference = se2.log(se2.between(behind, ahead)) / (2 * step)
    assert_within(np.swapaxes(difference, 1, 2), se2.right_jacobian(X), tol.FINITE_DIFFERENCE * (1 + length(X)))


def test_other_jacobians_by_the_right_one() -> None:
    X = log_poses(1)
    J_inv, J = se2.right_jacobian_inverse(X), se2.right_jacobian(X)
    assert (np.abs(J_inv @ J - np.eye(3)) <= tol.ALGEBRA * (np.abs(J_inv) @ np.abs(J))).all()
    assert_within(se2.left_jacobian(X), se2.Ad_matrix(se2.exp(X)) @ J, tol.ALGEBRA * (1 + length(X)))


# -- batches and other array libraries -------------------------------------------------------------


def batches(seed: int) -> list[np.ndarray]:
    """Arrays (*batch, 3) of many batch shapes."""
    shapes = [(), (0,), (1,), (5,), (2, 3), (3, 0, 2), (120,)]
    return [np.resize(log_poses(seed), (*shape, 3)) for shape in shapes]


@pytest.mark.parametrize("function", [*UNARY, *BINARY])
def test_batch_equals_loop_on_any_array_library(function) -> None:
    """array-api-strict fails on whatever the standard does not promise; its numbers are NumPy's."""
    for arguments in zip(*map(batches, range(1 if function in UNARY else 2)), strict=True):
        result = function(*arguments)
        shape = arguments[0].shape[:-1]
        assert result.shape[: len(shape)] == shape
        for index in np.ndindex(shape):
            np.testing.assert_array_equal(result[index], function(*(each[index] for each in arguments)))
        strict = function(*map(array_api_strict.asarray, arguments))
        np.testing.assert_array_equal(np.asarray(strict), result)
        single = function(*(each.astype(np.float32) for each in arguments))
        assert single.dtype == np.float32


@pytest.mark.parametrize("function", BINARY)
def test_one_against_a_batch_broadcasts(function) -> None:
    batch, one = batches(0)[-1], log_poses(1)[7]
    repeated = np.broadcast_to(one, batch.shape)
    np.testing.assert_array_equal(function(one, batch), function(repeated, batch))
    np.testing.assert_array_equal(function(batch, one), function(batch, repeated))


def test_the_rest_runs_on_the_bare_array_api() -> None:
    for g in batches(0):
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


# -- headings --------------------------------------------------------------------------------------


def test_wrap_takes_off_whole_turns_and_leaves_the_branch_alone() -> None:
    wrapped, rounding = se2.wrap(ANY_ANGLES), tol.ANGLE_SUM * (1 + np.abs(ANY_ANGLES))
    turns = (ANY_ANGLES - wrapped) / (2 * PI)
    assert (np.abs(turns - np.round(turns)) <= rounding).all()
    assert (np.abs(wrapped) <= PI + rounding).all()
    np.testing.assert_array_equal(se2.wrap(BRANCH), BRANCH)
    np.testing.assert_array_equal(se2.winding_number(BRANCH), 0.0)


def test_winding_number_changes_only_past_the_hysteresis() -> None:
    """Then to what keeps log away from its singularity; so headings that tremble about the antipode change nothing."""
    rng = np.random.default_rng(1)
    hysteresis = rng.uniform(0.01, 3.0, 500)
    walk = rng.uniform(-20.0, 20.0, 500) + np.cumsum(rng.uniform(-3.0, 3.0, (30, 500)), axis=0)
    walk[:, ::5] = np.sign(walk[0, ::5]) * PI + hysteresis[::5] * rng.uniform(-0.999, 0.999, (30, 100))
    first = turns = se2.winding_number(walk[0])
    for theta in walk[1:]:
        before, turns = turns, se2.winding_number(theta, turns, hysteresis)
        past = np.abs(theta - 2 * PI * before) > PI + hysteresis
        np.testing.assert_array_equal(turns != before, past)
        np.testing.assert_array_equal(turns, np.round(turns))
        assert (np.abs(theta - 2 * PI * turns) <= PI + hysteresis + tol.ANGLE_SUM * np.abs(theta)).all()
        np.testing.assert_array_equal(se2.winding_number(-theta, -before, hysteresis), -turns)  # the mirror image
        alone = [se2.winding_number(*each) for each in zip(theta, before, hysteresis, strict=True)]
        np.testing.assert_array_equal(alone, turns)
    np.testing.assert_array_equal(turns[::5], first[::5])
