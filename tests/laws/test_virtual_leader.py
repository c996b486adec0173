"""Virtual leaders: their twists against finite differences, what the printed ones leave out, branches, symmetries."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import array_api_strict
import numpy as np
import pytest

import tolerances as tol
from angles import log_poses
from array_laws import Leader, displace, fold
from nhtrack import se2
from nhtrack.experiment.followers import Tracking
from nhtrack.network import Network, equal_weights
from nhtrack.simulation.state import State
from watching import watch

pytestmark = pytest.mark.property

PI = math.pi
STEP = 1e-4  # [s] of the central differences
TWISTS, TRANSFORMS = ("convex", "exact"), ("printed", "exact")


# -- motions ----------------------------------------------------------------------------------------


class Motion(NamedTuple):
    """A planar motion about t = 0: cubic position and heading, `coefficients` (4, ..., 3), constant term first."""

    coefficients: np.ndarray

    def at(self, t: float) -> Leader:
        """Pose, body twist and body acceleration, by the product rule on v = R^T p'."""
        c = self.coefficients
        g = c[0] + c[1] * t + c[2] * t**2 + c[3] * t**3
        rate = c[1] + 2 * c[2] * t + 3 * c[3] * t**2
        second = 2 * c[2] + 6 * c[3] * t
        omega = rate[..., 2:]
        v = se2.rotate(-g[..., 2], rate[..., :2])
        turned = omega * np.stack([-v[..., 1], v[..., 0]], axis=-1)
        force = se2.rotate(-g[..., 2], second[..., :2]) - turned
        return Leader(g, np.concatenate([v, omega], axis=-1), np.concatenate([force, second[..., 2:]], axis=-1))


def extrapolated(central: Callable[[float], np.ndarray]) -> np.ndarray:
    """Limit of central differences as their step shrinks: two of them, freed of their error in h^2 (Richardson)."""
    return (4 * central(STEP / 2) - central(STEP)) / 3


def difference(path: Callable[[float], np.ndarray]) -> np.ndarray:
    """Body twist of a path of poses at t = 0, by central differences."""
    return extrapolated(lambda h: np.asarray(se2.log(se2.between(path(-h), path(h)))) / (2 * h))


def slope(path: Callable[[float], np.ndarray]) -> np.ndarray:
    """Derivative of a path of vectors at t = 0, by central differences."""
    return extrapolated(lambda h: np.asarray(path(h) - path(-h)) / (2 * h))


def wheel_leader(g: np.ndarray, v: np.ndarray, omega: np.ndarray, u_x: float = 0.0, u_theta: float = 0.0) -> Leader:
    """Leaders on wheels, without lateral velocity or acceleration."""
    zero = np.zeros_like(v)
    u = np.broadcast_to(np.array([u_x, 0.0, u_theta]), g.shape)
    return Leader(g, np.stack(np.broadcast_arrays(v, zero, omega), axis=-1), u)


def motions(seed: int, count: int = 300) -> Motion:
    return Motion(np.random.default_rng(seed).uniform(-2.0, 2.0, (4, count, 3)))


def shares(count: int = 300) -> np.ndarray:
    return np.random.default_rng(9).uniform(0.0, 1.0, count)


def relative_poses(count: int = 300) -> np.ndarray:
    """Within 5 m, two thirds with headings about pi apart, on either side of it."""
    rng = np.random.default_rng(8)
    gap = 10 ** rng.uniform(-12, -0.7, count)
    theta = np.choose(np.arange(count) % 4, [PI - gap, PI + gap, rng.uniform(0, PI, count), np.full(count, PI)])
    return np.column_stack([rng.uniform(-5, 5, (count, 2)), theta * rng.choice([1.0, -1.0], count)])


def ahead(motion: Motion, relative: np.ndarray, other: Motion) -> Motion:
    """A motion that starts at a pose seen from another's start and moves by its own coefficients after that."""
    start = se2.compose(other.coefficients[0], relative)
    return Motion(np.concatenate([start[None], motion.coefficients[1:]]))


def assert_near(found: np.ndarray, expected: np.ndarray, bound: np.ndarray | float) -> None:
    """Fails where a row is further off than its bound."""
    off = np.abs(found - expected).reshape(len(found), -1).max(axis=1) / bound
    worst = int(off.argmax())
    assert off[worst] <= 1, f"row {worst}: got {found[worst]}, expected {expected[worst]}"


# -- folds: the exact twist and acceleration --------------------------------------------------------


@pytest.mark.slow
def test_exact_twist_and_acceleration_are_differences_of_the_fold() -> None:
    """Also with headings about pi apart, on either side of it: the branch is the memory's."""
    first, relative = motions(1), relative_poses()
    second, turns = ahead(motions(2), relative, first), np.zeros(300)  # |theta| < pi + hysteresis throughout

    def at(t: float) -> Leader:
        return fold(first.at(t), second.at(t), shares(), "exact", turns)[0]

    scale = tol.VIRTUAL_TWIST * (1.0 + np.abs(relative[:, :2]).max(axis=1))
    assert_near(at(0.0).xi, difference(lambda t: at(t).g), scale)
    assert_near(at(0.0).u, slope(lambda t: at(t).xi), 10 * scale)


def folded(parents: list[Leader], weights: Sequence[float], combination: str) -> Leader:
    """The fold of parents, headings less than pi apart."""
    leader = parents[0]
    for other, weight in zip(parents[1:], weights, strict=True):
        leader, _ = fold(leader, other, weight, combination, None)
    return leader


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
def test_exact_twist_of_several_folds_and_a_place(seed: int) -> None:
    """What a follower of three parents tracks in a formation moves as its twist says, thetabar included."""
    rng = np.random.default_rng(seed)
    parents = [Motion(rows) for rows in rng.uniform(-1.0, 1.0, (3, 4, 3)) * np.array([1.0, 1.0, 0.5])]

    def at(t: float) -> Leader:
        return displace(folded([each.at(t) for each in parents], [0.3, 0.6], "exact"), [-1.0, 0.7], "exact", 0.0)[0]

    np.testing.assert_allclose(at(0.0).xi, difference(lambda t: at(t).g), atol=tol.VIRTUAL_TWIST)
    assert at(0.0).xi[1] == 0.0


@pytest.mark.parametrize("combination", TWISTS)
def test_lambda_0_and_1_give_the_parents(combination: str) -> None:
    """To the last bit at 0, to rounding at 1; the heading of the second parent up to whole turns."""
    first = motions(1)
    a, b = first.at(0.0), ahead(motions(2), relative_poses(), first).at(0.0)
    at_a, _ = fold(a, b, np.zeros(300), combination, None)
    at_b, turns = fold(a, b, np.ones(300), combination, None)
    for values, expected in zip(at_a, a, strict=True):
        np.testing.assert_array_equal(values, expected)
    b = b._replace(g=b.g - turns[:, None] * [0.0, 0.0, 2 * PI])
    for values, expected in zip(at_b, b, strict=True):
        np.testing.assert_allclose(values, expected, atol=3000 * tol.COEFFICIENT)


@pytest.mark.parametrize("combination", TWISTS)
def test_fold_is_left_invariant(combination: str) -> None:
    """Moving both parents moves g_c along and leaves twist and input."""
    h = np.random.default_rng(3).uniform(-1, 1, (300, 3)) * [10, 10, 20]
    a, b = motions(1).at(0.0), motions(2).at(0.0)
    moved_a, moved_b = (leader._replace(g=se2.compose(h, leader.g)) for leader in (a, b))
    plain, _ = fold(a, b, shares(), combination, np.zeros(300))
    moved, _ = fold(moved_a, moved_b, shares(), combination, np.zeros(300))
    scale = 1e4 * tol.ALGEBRA * (1 + np.abs(h).sum(axis=1))  # accelerations reach some hundreds
    for values, expected in zip(moved, plain._replace(g=se2.compose(h, plain.g)), strict=True):
        assert_near(values, expected, scale)


# -- folds: slip 5, the printed twist ---------------------------------------------------------------


def defect(a: Leader, b: Leader, share: np.ndarray) -> np.ndarray:
    """Body velocity of g_c less the printed one, (..., 2) [m/s]; the turning rates agree."""
    exact, _ = fold(a, b, share, "exact", None)
    printed, _ = fold(a, b, share, "convex", None)
    gap = exact.xi - printed.xi
    np.testing.assert_allclose(gap[..., 2], 0.0, atol=100 * tol.ALGEBRA)
    return gap[..., :2]


def unit_parents(count: int, headings_apart: np.ndarray | None = None) -> tuple[Leader, Leader]:
    """Pairs on wheels at most 1 m apart, |v| <= 1, |omega| <= 1."""
    rng = np.random.default_rng(7)
    radius, bearing = np.sqrt(rng.uniform(0, 1, count)), rng.uniform(-PI, PI, count)
    theta = rng.uniform(-PI, PI, count) if headings_apart is None else headings_apart
    g = np.stack([radius * np.cos(bearing), radius * np.sin(bearing), theta], axis=-1)
    v, omega = rng.uniform(-1, 1, (2, 2, count))
    return wheel_leader(np.zeros_like(g), v[0], omega[0]), wheel_leader(g, v[1], omega[1])


def test_printed_twist_at_its_worst_is_wrong_by_one_and_a_half_metres_a_second() -> None:
    """Opposite headings and motions, 1 m abreast: (v + omega d/2) = 1.5 m/s, all of it lateral, by hand.

    X = (d pi/2, 0, pi), so what differs is D = xi_b - xi_a - (omega_b - omega_a)/pi X, of 2 + 1 m/s, and half of it is
    the defect at lambda = 1/2.
    """
    a = wheel_leader(np.zeros(3), np.array(1.0), np.array(-1.0))
    for side, worst in ((1.0, 1.5), (-1.0, 0.5)):
        b = wheel_leader(np.array([0.0, side, PI]), np.array(-1.0), np.array(1.0))
        gap = defect(a, b, np.array(0.5))
        np.testing.assert_allclose(np.abs(gap), [0.0, worst], atol=tol.HAND)


def test_defect_of_the_printed_twist_in_closed_form() -> None:
    """`D (e^{-i lambda theta} - 1 - lambda (e^{-i theta} - 1))/(e^{-i theta} - 1)`, D = dv - domega q/theta.

    In complex numbers v_x + i v_y; of size |D| tan(|theta|/4)/2 at lambda = 1/2 (docs/theory.md).
    """
    relative, first, share = relative_poses() * [1.0, 1.0, 0.99], motions(1), shares()
    relative[:, 2] = np.copysign(np.maximum(np.abs(relative[:, 2]), 0.1), relative[:, 2])
    a, b = first.at(0.0), ahead(motions(2), relative, first).at(0.0)
    theta, q, change = relative[:, 2], se2.log(relative), b.xi - a.xi
    bent = change[:, 0] + 1j * change[:, 1] - change[:, 2] * (q[:, 0] + 1j * q[:, 1]) / theta
    turn = np.exp(-1j * theta) - 1

    def gap(share: np.ndarray) -> np.ndarray:
        exact, printed = (fold(a, b, share, twist, np.zeros(300))[0].xi for twist in ("exact", "convex"))
        return (exact - printed)[:, 0] + 1j * (exact - printed)[:, 1]

    expected = bent / turn * (np.exp(-1j * share * theta) - 1 - share * turn)
    np.testing.assert_allclose(gap(share), expected, rtol=0, atol=1e4 * tol.ALGEBRA)
    half = np.abs(bent) * np.tan(np.abs(theta) / 4) / 2
    np.testing.assert_allclose(np.abs(gap(np.full(300, 0.5))), half, rtol=0, atol=1e4 * tol.ALGEBRA)


def test_printed_twist_is_exact_for_equal_headings_and_turning_rates() -> None:
    a, b = unit_parents(500, np.zeros(500))
    b.xi[:, 2] = a.xi[:, 2]
    share = np.random.default_rng(1).uniform(0, 1, 500)
    assert np.abs(defect(a, b, share)).max() <= tol.LAW
    b.xi[:, 2] = -a.xi[:, 2]
    assert np.abs(defect(a, b, share)).max() > 0.1


def test_printed_twist_is_exact_for_equal_twists() -> None:
    """At any places and headings; so for two robots on one circle, or on parallel courses."""
    a, b = unit_parents(500)
    share = np.random.default_rng(1).uniform(0, 1, 500)
    assert np.abs(defect(a, b._replace(xi=a.xi), share)).max() <= tol.LAW


def test_printed_twist_is_not_exact_for_parents_of_one_rigid_motion() -> None:
    """Two robots fixed to one turning plate, both on wheels, at different radii about its centre.

    A screw carries its own twist only; others it rotates. So one rigid motion is enough only for parents whose body
    twists are equal: the same radius, or no turning.
    """
    rng = np.random.default_rng(3)
    radii, bearing, omega = rng.uniform(0.3, 2.0, (2, 500)), rng.uniform(-3, 3, 500), rng.uniform(-1, 1, 500)
    for second, exact in ((radii[1], False), (radii[0], True)):
        g = np.stack([second * np.sin(bearing), radii[0] - second * np.cos(bearing), bearing], axis=-1)
        a = wheel_leader(np.zeros_like(g), omega * radii[0], omega)
        b = wheel_leader(g, omega * second, omega)
        np.testing.assert_allclose(se2.Ad_inverse(g, a.xi), b.xi, atol=tol.HAND)  # one rigid motion
        worst = np.abs(defect(a, b, np.full(500, 0.5))).max()
        assert worst <= tol.LAW if exact else worst > 0.3


# -- places in a formation --------------------------------------------------------------------------


def offset_pairs() -> np.ndarray:
    return np.random.default_rng(7).uniform(-5.0, 5.0, (300, 2))


def test_printed_transform_is_the_adjoint_of_gbar() -> None:
    """xi_a = Ad_{gbar^-1} xi_c, u_a likewise but for the lateral part, which no wheel robot can follow."""
    leader, offset = motions(1).at(0.0), offset_pairs()
    moved, _ = displace(leader, offset, "printed", 0.0)
    gbar = se2.between(leader.g, moved.g)
    np.testing.assert_allclose(gbar[:, :2], offset, atol=1e3 * tol.ALGEBRA)
    np.testing.assert_allclose(moved.xi, se2.Ad_inverse(gbar, leader.xi), atol=1e3 * tol.ALGEBRA)
    np.testing.assert_allclose(moved.u, se2.Ad_inverse(gbar, leader.u) * [1, 0, 1], atol=1e4 * tol.ALGEBRA)


def circling(t: float, offset: np.ndarray) -> tuple[Leader, np.ndarray]:
    """A leader on wheels with smooth v and omega, v - omega ybar > 0.4, and thetabar'' of the place, by hand.

    Its position does not enter what is displaced but through g; it is left at the origin of its own frame.
    """
    v, u_x, jerk = 1.5 + 0.5 * math.sin(t), 0.5 * math.cos(t), -0.5 * math.sin(t)
    omega, u_theta, twitch = 0.4 * math.cos(2 * t), -0.8 * math.sin(2 * t), -1.6 * math.cos(2 * t)
    leader = wheel_leader(np.array([0.0, 0.0, 0.2 * math.sin(2 * t)]), np.array(v), np.array(omega), u_x, u_theta)
    x, y = offset
    point, rate, second = (
        np.array([a - b * y, b * x]) for a, b in ((v, omega), (u_x, u_theta), (jerk, twitch))
    )
    square, cross = point @ point, point[0] * rate[1] - point[1] * rate[0]
    bend = (point[0] * second[1] - point[1] * second[0]) / square - 2 * cross * (point @ rate) / square**2
    return leader, bend


OFFSET = np.array([-1.0, 1.0])


def test_rate_of_thetabar_is_the_formula_of_slip_6() -> None:
    """xbar (u_theta v - omega u_x)/((v - omega ybar)^2 + (omega xbar)^2), for a leader on wheels."""
    leader, _ = circling(0.7, OFFSET)
    (v, _, omega), (u_x, _, u_theta) = leader.xi, leader.u
    x, y = OFFSET
    expected = x * (u_theta * v - omega * u_x) / ((v - omega * y) ** 2 + (omega * x) ** 2)
    assert float(displace(leader, OFFSET, "exact", 0.0)[1]) == pytest.approx(expected, rel=tol.HAND)
    assert abs(expected) > 0.1


def test_exact_transform_is_a_difference_of_the_place() -> None:
    """Twist and longitudinal acceleration, where the place does not stop: there thetabar turns without bound."""
    offset, twist = offset_pairs(), motions(1).at(0.0).xi
    along = np.abs(twist[:, 0] - twist[:, 2] * offset[:, 1])
    going = along > 0.3  # thetabar jumps by pi where the place turns back
    motion, offset = Motion(motions(1).coefficients[:, going]), offset[going]

    def at(t: float) -> Leader:
        return displace(motion.at(t), offset, "exact", 0.0)[0]

    scale = 3 * tol.VIRTUAL_TWIST * (1 + np.abs(offset).sum(axis=1)) / np.minimum(1.0, along[going]) ** 3
    assert_near(at(0.0).xi, difference(lambda t: at(t).g), scale)
    assert_near(at(0.0).u[:, :1], slope(lambda t: at(t).xi)[:, :1], scale)


def test_printed_transform_is_not_a_difference_of_the_place() -> None:
    """What slip 6 leaves out is thetabar', all of it in omega."""
    leader, _ = circling(0.7, OFFSET)
    printed, rate = displace(leader, OFFSET, "printed", 0.0)
    exact, _ = displace(leader, OFFSET, "exact", 0.0)
    np.testing.assert_array_equal(exact.xi - printed.xi, [0.0, 0.0, exact.xi[2] - printed.xi[2]])
    assert exact.xi[2] - printed.xi[2] == pytest.approx(float(rate), abs=tol.HAND)
    assert abs(rate) > 0.1


def seen_in_loop(dt: float) -> tuple[Leader, Leader]:
    """What a follower in a place tracks in two periods, the second at t = 0.7."""
    before, now = circling(0.7 - dt, OFFSET)[0], circling(0.7, OFFSET)[0]
    network = Network.from_parents({"leader": (), "follower": ("leader",)})
    start = State(0.0, np.stack([before.g, before.g]), np.stack([before.xi, np.zeros(3)]))
    tracking = Tracking(np.stack([np.zeros(2), OFFSET]), "exact", "exact")
    seen = watch(network, np.stack([before.u, now.u])[:, ::2], start, dt, tracking)
    names = (("x", "y", "theta"), ("v_x", "v_y", "omega"), ("u_x", "u_y", "u_theta"))
    first, second = (Leader(*(np.array([seen[name][k, 1] for name in part]) for part in names)) for k in (0, 1))
    return first, second


def test_second_rate_of_thetabar_is_met_at_first_order() -> None:
    """u_theta,a - u_theta,c is thetabar' less that of the period before, over dt: its error halves with dt."""
    leader, expected = circling(0.7, OFFSET)
    steps = (0.02, 0.01, 0.005)
    errors = [float(seen_in_loop(dt)[1].u[2] - leader.u[2] - expected) for dt in steps]
    assert abs(errors[0]) > 1e-3
    np.testing.assert_allclose(np.array(errors[:-1]) / errors[1:], 2.0, atol=tol.ORDER)


# -- places: leaders at rest, turning in place, turning back ----------------------------------------


@pytest.mark.parametrize("transform", ["printed", "exact"])
@pytest.mark.parametrize("u", [(0.0, 0.0), (1.0, 0.0), (1.0, -2.0)])
def test_place_of_a_leader_at_rest_has_its_heading(transform: str, u: tuple[float, float]) -> None:
    """0/0 in thetabar counts as 0, also in the period in which the leader starts."""
    leader = wheel_leader(np.array([1.0, 2.0, 0.5]), np.array(0.0), np.array(0.0), *u)
    moved, rate = displace(leader, OFFSET, transform, 0.0)  # type: ignore[arg-type]
    np.testing.assert_array_equal(moved.g, se2.compose(leader.g, np.array([*OFFSET, 0.0])))
    np.testing.assert_array_equal(moved.xi, np.zeros(3))
    np.testing.assert_allclose(moved.u, [u[0] - u[1] * OFFSET[1], 0.0, u[1]], atol=tol.HAND)
    assert rate == 0.0


@pytest.mark.parametrize("omega", [-2.0, 0.5])
@pytest.mark.parametrize("offset", [(-1.0, 1.0), (2.0, -0.5), (-1.0, 0.0), (0.0, 1.0)])
def test_place_of_a_leader_turning_in_place_runs_on_a_circle(omega: float, offset: tuple[float, float]) -> None:
    """thetabar = -arctan(xbar/ybar) stands still, at right angles to the arm; the speed is omega times its length."""
    leader = wheel_leader(np.array([1.0, 2.0, 0.5]), np.array(0.0), np.array(omega), 0.0, 0.3)
    moved, rate = displace(leader, np.array(offset), "exact", 0.0)
    arm = np.hypot(*offset)
    assert abs(moved.xi[0]) == pytest.approx(abs(omega) * arm, rel=tol.HAND)
    assert moved.xi[2] == omega
    assert rate == pytest.approx(0.0, abs=tol.HAND)
    along = se2.rotate(moved.g[2] - leader.g[2], np.array([1.0, 0.0]))
    assert along @ np.array(offset) == pytest.approx(0.0, abs=tol.HAND)
    assert abs(moved.g[2] - leader.g[2]) <= PI / 2


def test_place_of_a_leader_turning_back_keeps_its_heading_within_a_quarter_turn() -> None:
    """As v - omega ybar changes sign thetabar jumps by pi, as the paper's arctan does; velocity stays continuous."""
    sides = []
    for v in (-1e-9, 1e-9):
        leader = wheel_leader(np.zeros(3), np.array(v), np.array(0.5))
        moved, _ = displace(leader, np.array([1.0, 0.0]), "exact", 0.0)
        sides.append((float(moved.g[2]), se2.rotate(moved.g[2], moved.xi[:2])))
    assert sides[1][0] - sides[0][0] == pytest.approx(PI, abs=1e-8)
    np.testing.assert_allclose(sides[0][1], sides[1][1], atol=1e-8)


def test_offsets_of_the_paper_s_formation_make_a_diamond() -> None:
    """Slip 7: edges 0-1, 0-2, 1-3, 2-3 at equal shares put robot 3 behind the leader, 30 m, on its axis."""
    leader = wheel_leader(np.array([0.0, 0.0, 0.0]), np.array(1.0), np.array(0.0))
    flanks = [displace(leader, np.array([-15.0, y]), "printed", 0.0)[0] for y in (15.0, -15.0)]
    last, _ = displace(folded(flanks, equal_weights(2), "convex"), np.array([-15.0, 0.0]), "printed", 0.0)
    np.testing.assert_allclose(last.g, [-30.0, 0.0, 0.0], atol=tol.HAND)
    np.testing.assert_allclose(last.xi, [1.0, 0.0, 0.0], atol=tol.HAND)


# -- the derivative of the right Jacobian -----------------------------------------------------------


def test_right_jacobian_derivative_is_a_difference() -> None:
    h, X = 1e-5, log_poses(1)
    direction = np.random.default_rng(2).uniform(-1.0, 1.0, X.shape)
    expected = (se2.right_jacobian(X + h * direction) - se2.right_jacobian(X - h * direction)) / (2 * h)
    scale = tol.FINITE_DIFFERENCE * (1.0 + np.abs(X).max(axis=1))
    assert_near(se2.right_jacobian_derivative(X, direction), expected, scale)


@pytest.mark.parametrize("shape", [(), (3,), (2, 0), (2, 4)])
def test_right_jacobian_derivative_needs_the_array_api_only(shape: tuple[int, ...]) -> None:
    X, dX = np.random.default_rng(6).uniform(-2, 2, (2, *shape, 3))
    strict = se2.right_jacobian_derivative(array_api_strict.asarray(X), array_api_strict.asarray(dX))
    assert strict.shape == (*shape, 3, 3)
    np.testing.assert_array_equal(np.asarray(strict), se2.right_jacobian_derivative(X, dX))
