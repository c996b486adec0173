"""The floor: whose friction counts where, and gravity on a slope as a robot feels it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from angles import ANY_ANGLES
from nhtrack.ground import GRAVITY, LEVEL, Ground, Patch
from tolerances import EPS, HAND

# Sums and products of a handful of terms of the size of gravity.
GRAVITY_ROUNDING = 16 * EPS * GRAVITY

SQUARE = Patch(0.1, rectangle=(-1.0, 2.0, 0.5, 1.5))
DISC = Patch(0.05, disc=(3.0, -1.0, 0.5))
SHAPES = [(), (0,), (50,), (2, 3), (3, 0, 2)]


def covers(patch: Patch, *point: float) -> bool:
    return bool(patch.covers(np.array(point)))


class TestPatch:
    @pytest.mark.parametrize("corner", [(-1.0, 0.5), (2.0, 0.5), (-1.0, 1.5), (2.0, 1.5)])
    def test_a_rectangle_ends_at_its_sides_which_are_part_of_it(self, corner: tuple[float, float]) -> None:
        assert covers(SQUARE, *corner)
        assert covers(SQUARE, 0.3, corner[1])
        assert covers(SQUARE, corner[0], 1.0)
        away = np.nextafter(corner, np.inf * np.sign(np.array(corner) - (0.5, 1.0)))
        assert not covers(SQUARE, away[0], corner[1])
        assert not covers(SQUARE, corner[0], away[1])

    def test_a_disc_ends_at_its_circle_which_is_part_of_it(self) -> None:
        for x, y in ((3.5, -1.0), (2.5, -1.0), (3.0, -0.5), (3.0, -1.5), (3.0, -1.0)):
            assert covers(DISC, x, y)
        assert not covers(DISC, np.nextafter(3.5, 4), -1.0)
        assert not covers(DISC, 3.36, -0.64)  # inside the square around it
        assert covers(DISC, 3.35, -0.65)

    @given(st.floats(0, 2), st.sampled_from(ANY_ANGLES.tolist()))
    def test_a_disc_is_round(self, share: float, direction: float) -> None:
        x, y, radius = DISC.disc or ()
        point = (x + share * radius * math.cos(direction), y + share * radius * math.sin(direction))
        if abs(share - 1) > 1e-9:
            assert covers(DISC, *point) == (share < 1)

    @pytest.mark.parametrize("shapes", [{}, {"disc": (0, 0, 1), "rectangle": (0, 1, 0, 1)}], ids=["none", "both"])
    def test_it_is_one_thing_or_the_other(self, shapes: dict) -> None:
        with pytest.raises(ValueError, match="expected a rectangle or a disc"):
            Patch(0.1, **shapes)


class TestFriction:
    def test_where_patches_overlap_the_last_one_counts(self) -> None:
        wet, ice = Patch(0.4, rectangle=(0.0, 2.0, 0.0, 2.0)), Patch(0.05, disc=(2.0, 1.0, 0.5))
        points = np.array([[0.5, 1.0], [1.8, 1.0], [2.2, 1.0], [3.0, 1.0]])
        np.testing.assert_array_equal(Ground(0.9, (wet, ice)).friction_at(points), [0.4, 0.05, 0.05, 0.9])
        np.testing.assert_array_equal(Ground(0.9, (ice, wet)).friction_at(points), [0.4, 0.4, 0.05, 0.9])

    @pytest.mark.parametrize("shape", SHAPES)
    def test_any_shape_of_points_is_each_point_by_itself(self, shape: tuple[int, ...]) -> None:
        places, ground = np.random.default_rng(1).uniform(-4, 4, (*shape, 2)), Ground(1.0, (SQUARE, DISC))
        found = ground.friction_at(places)
        assert found.shape == shape
        for index in np.ndindex(*shape):
            assert found[index] == ground.friction_at(places[index])
            assert found[index] in (1.0, 0.1, 0.05)

    def test_without_patches_it_is_uniform(self) -> None:
        np.testing.assert_array_equal(Ground(0.7).friction_at(np.zeros((3, 2, 2))), np.full((3, 2), 0.7))

    @given(st.floats(0.01, 1), st.floats(-4, 4), st.floats(-4, 4))
    def test_a_share_of_it_is_that_share_everywhere(self, share: float, x: float, y: float) -> None:
        ground, place = Ground(0.8, (SQUARE, DISC), 0.2, 1.0), np.array([x, y])
        part = ground.scaled(share)
        assert part.friction_at(place) == pytest.approx(share * ground.friction_at(place), rel=HAND)
        assert (part.slope, part.uphill) == (ground.slope, ground.uphill)


class TestGravity:
    def test_on_the_level_it_is_all_weight(self) -> None:
        assert Ground().gravity == (0, 0, -GRAVITY)
        assert Ground().gravity_at(np.linspace(-9, 9, 5)) == LEVEL == (0, 0, GRAVITY)

    @pytest.mark.parametrize(
        ("theta", "along", "aside"),
        [(0.5, -1, 0), (0.5 + math.pi, 1, 0), (0.5 + math.pi / 2, 0, 1), (0.5 - math.pi / 2, 0, -1)],
        ids=["up", "down", "across, the top on the right", "across, the top on the left"],
    )
    def test_up_down_and_across(self, theta: float, along: float, aside: float) -> None:
        """Half of g draws along a slope of 30 degrees."""
        x, y, normal = Ground(slope=math.pi / 6, uphill=0.5).gravity_at(np.array(theta))
        assert (x, y) == pytest.approx((along * GRAVITY / 2, aside * GRAVITY / 2), abs=GRAVITY_ROUNDING)
        assert normal == pytest.approx(GRAVITY * math.sqrt(3) / 2, rel=HAND)

    @given(st.floats(0, 1.5), st.floats(-10, 10), st.floats(-10, 10))
    def test_it_is_one_vector_whatever_the_heading(self, slope: float, uphill: float, theta: float) -> None:
        ground = Ground(slope=slope, uphill=uphill)
        x, y, normal = (float(value) for value in ground.gravity_at(np.array(theta)))
        world = complex(x, y) * complex(math.cos(theta), math.sin(theta))
        assert (world.real, world.imag, -normal) == pytest.approx(ground.gravity, abs=GRAVITY_ROUNDING)
        assert math.hypot(x, y, normal) == pytest.approx(GRAVITY, rel=HAND)
        towards = complex(*ground.gravity[:2]) * complex(math.cos(uphill), -math.sin(uphill))
        assert (towards.real, towards.imag) == pytest.approx((-GRAVITY * math.sin(slope), 0), abs=GRAVITY_ROUNDING)

    @pytest.mark.parametrize("shape", SHAPES)
    def test_headings_of_any_shape(self, shape: tuple[int, ...]) -> None:
        theta = np.arange(math.prod(shape), dtype=float).reshape(shape)
        x, y, _ = Ground(slope=0.3, uphill=1.0).gravity_at(theta)
        assert x.shape == y.shape == shape
        for index in np.ndindex(*shape):
            alone = Ground(slope=0.3, uphill=1.0).gravity_at(theta[index])
            assert (x[index], y[index]) == pytest.approx(alone[:2], abs=GRAVITY_ROUNDING)
