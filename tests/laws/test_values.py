"""The laws by hand-worked numbers, and the sentences they say about their gains."""

from __future__ import annotations

import math

import numpy as np
import pytest

import tolerances as tol
from array_laws import Leader, Published, Robots, Stabiliser
from nhtrack.laws.relative_motion import arctan_ratio

PI = math.pi
FOLLOWER = Robots(np.array([2.0, 1.0, PI / 2]), np.array([0.5, 0.0, 0.25]))
LEADER = Leader(np.zeros(3), np.array([1.0, 0.0, 0.5]), np.array([0.3, 0.0, 0.2]))


def command(law: Published | Stabiliser, follower: Robots = FOLLOWER, leader: Leader = LEADER) -> np.ndarray:
    return np.asarray(law(follower, leader, law.init(follower, leader))[0])


def test_published_by_hand() -> None:
    """r = (2, 1), theta01 = pi/2: A^-1 = pi/4 [[1, 1], [-1, 1]], q = pi/4 (3, -1), beta = arctan(1/3)."""
    kp, kd, ke, k = 2.0, 3.0, 0.5, 4.0
    beta, attitude = math.atan(1 / 3), math.atan((0.5 * 2) / (1 - 0.5 * 1))
    u_theta = -ke * (PI / 2 - attitude) - kp * (PI / 2 + k * beta) - kd * (0.25 - 0.5) + 0.2
    v_x01 = 0.5 - 0.5 * 2  # v_1 - omega_0 r_x sin(pi/2)
    u_x = -kp * 0.75 * PI - kd * v_x01 + 0.2 * 2  # u_theta0 r_x sin(pi/2)
    np.testing.assert_allclose(command(Published(kp, kd, ke, k)), [u_x, u_theta], rtol=tol.HAND)


def test_full_adds_the_bracket_by_hand() -> None:
    """-omega_1 v_y01 = -0.25 (1 - 0.5 * 1) to u_x."""
    gains = (2.0, 3.0, 0.5, 4.0)
    difference = command(Published(*gains, variant="full")) - command(Published(*gains))
    np.testing.assert_allclose(difference, [-0.25 * 0.5, 0.0], atol=tol.HAND)


def test_lateral_velocity_of_a_leader_is_taken_in() -> None:
    """With v_y0 = -1 = -omega_0 r_x the carried velocity is along the leader: adjoint attitude 0."""
    leader = LEADER._replace(xi=np.array([1.0, -1.0, 0.5]))
    u_theta = -0.5 * PI / 2 - 2 * (PI / 2 + 4 * math.atan(1 / 3)) - 3 * (0.25 - 0.5) + 0.2
    u_x = -2 * 0.75 * PI - 3 * 0.5 + 0.2 * 2
    np.testing.assert_allclose(
        command(Published(2.0, 3.0, 0.5, 4.0), leader=leader), [u_x, u_theta], rtol=tol.HAND
    )


def test_stabiliser_by_hand_looks_at_no_motion_of_the_leader() -> None:
    expected = [-2 * 0.75 * PI - 3 * 0.5, -2 * (PI / 2 + 4 * math.atan(1 / 3)) - 3 * 0.25]
    np.testing.assert_allclose(command(Stabiliser(2.0, 3.0, 4.0)), expected, rtol=tol.HAND)


@pytest.mark.parametrize(
    ("y", "x", "expected"),
    [
        (1.0, 1.0, PI / 4),
        (1.0, -1.0, -PI / 4),
        (-1.0, -1.0, PI / 4),
        (1.0, 0.0, PI / 2),
        (-1.0, 0.0, -PI / 2),
        (0.0, 5.0, 0.0),
        (0.0, -5.0, 0.0),
        (0.0, 0.0, 0.0),
        (1e-300, 1e-300, PI / 4),
        (1e300, 1e300, PI / 4),
    ],
)
def test_quotient_of_arctan(y: float, x: float, expected: float) -> None:
    assert arctan_ratio(y, x, 0.0) == pytest.approx(expected, abs=tol.HAND)


def test_quotient_of_arctan_counts_its_dead_zone_by_length() -> None:
    assert arctan_ratio(0.3, 0.4, 0.5) == 0.0
    assert arctan_ratio(0.30001, 0.40001, 0.5) == pytest.approx(math.atan(0.30001 / 0.40001), rel=tol.HAND)


# -- gain warnings ----------------------------------------------------------------------------------

STEERING = (
    "k = {k:g} is not above 2 (1 + ke/kp) = {bound:g}: with the leader at rest the heading will not align"
)
DAMPING = "kd = {kd:g} is below 2 sqrt(kp) = {bound:g}: q_x overshoots and beta jumps by pi each time"


@pytest.mark.parametrize(
    ("k", "warned"), [(2.0, True), (3.0, True), (math.nextafter(3.0, 4.0), False), (7.0, False), (-7.0, True)]
)
def test_steering_gain_must_exceed_its_bound(k: float, warned: bool) -> None:
    """kp = 4, ke = 2: k > 3."""
    expected = (STEERING.format(k=k, bound=3),) if warned else ()
    assert Published(4.0, 6.0, 2.0, k).warnings() == expected


@pytest.mark.parametrize(
    ("kd", "warned"), [(math.nextafter(4.0, 0.0), True), (4.0, False), (3.0, True), (9.0, False)]
)
def test_damping_may_be_critical(kd: float, warned: bool) -> None:
    """kp = 4: kd >= 4."""
    expected = (DAMPING.format(kd=kd, bound=4),) if warned else ()
    assert Published(4.0, kd, 2.0, 7.0).warnings() == expected


@pytest.mark.parametrize(("k", "warned"), [(2.0, True), (math.nextafter(2.0, 3.0), False)])
def test_stabiliser_has_the_bound_without_ke(k: float, warned: bool) -> None:
    assert Stabiliser(4.0, 6.0, k).warnings() == ((STEERING.format(k=k, bound=2),) if warned else ())


def test_every_broken_condition_is_told() -> None:
    assert Published(4.0, 3.0, 2.0, 1.0).warnings() == (
        STEERING.format(k=1, bound=3),
        DAMPING.format(kd=3, bound=4),
    )
    assert len(Stabiliser(4.0, 3.0, 1.0).warnings()) == 2


def test_bounds_do_not_depend_on_the_units_of_time() -> None:
    """Gains scaled by T = 2 say the same."""
    assert Published(1.0, 2.0, 0.5, 3.0).warnings() == Published(4.0, 4.0, 2.0, 3.0).warnings()[:1]
    assert Published(1.0, 3.0, 0.5, 3.5).warnings() == ()
