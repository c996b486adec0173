"""The laws by hand-worked numbers, and the sentences they say about their gains."""

from __future__ import annotations

import math

import pytest

import tolerances as tol
from array_laws import Published, Stabiliser
from nhtrack.laws.relative_motion import arctan_ratio

PI = math.pi


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
