"""The compiled scalar code of laws, virtual leaders and SE(2) against the same written for arrays."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest

import array_laws as scalar
from angles import ANY_ANGLES, log_poses, poses, twists
from nhtrack import planar, se2
from nhtrack.laws import Law, Limits, law_named
from nhtrack.laws.evaluate import commands, first_memories
from nhtrack.testing.scenes import hard_walk
from reference import laws as arrays
from reference.laws import virtual_leader as array_leaders
from reference.laws.baselines.view import sinc as array_sinc

pytestmark = pytest.mark.property

PI = math.pi
PERIOD = 0.01  # [s]

# The operations are the same in the same order, and most results have the same bits. What rounds otherwise: the law
# `universal` takes lengths by square roots and powers by products, the array form by `hypot` and `pow`; the exact fold
# multiplies by 3 x 3 matrices there. Relative to 1 and the largest number of the same result.
ROUNDING = 1e-12

LIMITS = {"speed": 1.5, "yaw_rate": 2.0, "acceleration": 3.0, "yaw_acceleration": 4.0}
PAPER = {"kp": 11.0, "kd": 25.1, "ke": 6.0, "k": 3.2, "dead_zone_length": 1e-6, "dead_zone_speed": 1e-3}
FULL = PAPER | {"dead_zone_length": 0.3}
STILL = {"kp": 4.0, "kd": 5.0, "k": 6.0, "dead_zone_length": 0.0}
UNIVERSAL = {
    "k1": 16.0, "k2": 8.0, "k3": 6.0, "c": 0.5, "m": 1.5, "field_speed": 2.0, "turn_rate": 4.0, "dock_radius": 0.005,
    "dock_speed": 0.02,
}  # fmt: skip
RIVALS = {
    "kanayama": (arrays.Kanayama, {"k_x": 1.0, "k_y": 1.5, "k_theta": 2.0, "k_inner": 5.0}),
    "samson": (arrays.Samson, {"zeta": 0.7, "b": 1.5, "k_inner": 5.0}),
    "jiang_nijmeijer": (
        arrays.JiangNijmeijer,
        {"k_x": 1.0, "gamma": 1.5, "k_theta": 1.2, "k_inner": 5.0, "coupling": 0.8},
    ),
    "feedback_linearisation": (arrays.FeedbackLinearisation, {"kp": 1.0, "kd": 2.5, "k_inner": 5.0, "v_min": 0.1}),
    "look_ahead": (arrays.LookAhead, {"distance": 0.5, "k": 1.0, "k_inner": 5.0}),
}
# Each law as compiled scalar code and as arrays, with the same gains.
LAWS: dict[str, tuple[Law, Any]] = {
    "published": (law_named("published")(**PAPER), arrays.Published(**PAPER)),
    "full": (law_named("published")(variant=1, **FULL), arrays.Published(variant="full", **FULL)),
    "stabiliser": (law_named("stabiliser")(**STILL), arrays.Stabiliser(**STILL)),
    "universal": (law_named("universal")(**UNIVERSAL), arrays.Universal(**UNIVERSAL)),
    "limited": (
        law_named("universal")(limits=Limits(**LIMITS), **UNIVERSAL),
        arrays.Universal(limits=arrays.Limits(**LIMITS), **UNIVERSAL),
    ),
} | {name: (law_named(name)(**gains), law(**gains)) for name, (law, gains) in RIVALS.items()}
every_law = pytest.mark.parametrize("name", LAWS)


def as_robots(follower: np.ndarray) -> arrays.Robots:
    return arrays.Robots(follower[:, :3], follower[:, 3:])


def as_leader(leader: np.ndarray) -> arrays.Leader:
    return arrays.Leader(leader[:, :3], leader[:, 3:6], leader[:, 6:])


def memories(memory: Any, shape: tuple[int, ...]) -> np.ndarray:
    """The memory of an array law in the columns of a scalar one's."""
    fields = memory if isinstance(memory, tuple) else (memory,)
    return np.stack(fields, axis=-1) if shape[1] else np.zeros(shape)


def assert_same(found: np.ndarray, expected: np.ndarray) -> None:
    """Fails where a row is further off than rounding in shares of 1 and of its largest number."""
    assert_near(found, expected, expected)


def require_same(name: str, walk: Iterable[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Fails where the two forms of a law differ on followers and leaders over some periods; returns all memories."""
    law, array = LAWS[name]
    seen: list[np.ndarray] = []
    for follower, leader in walk:
        robots, ahead = as_robots(follower), as_leader(leader)
        if not seen:
            seen.append(first_memories(law, follower, leader, PERIOD))
            expected_memory = array.init(robots, ahead)
            np.testing.assert_array_equal(seen[0], memories(expected_memory, seen[0].shape))
        u, memory = commands(law, follower, leader, seen[-1], PERIOD)
        expected, expected_memory = array(robots, ahead, expected_memory)
        assert_same(u, expected)
        np.testing.assert_array_equal(memory, memories(expected_memory, memory.shape))
        seen.append(memory)
    return np.concatenate(seen)


def way_to_the_leader(count: int, periods: int) -> Iterable[tuple[np.ndarray, np.ndarray]]:
    """From 5 m apart to where followers dock, period by period; leaders at rest, moving, and with lateral motion."""
    rng = np.random.default_rng(1)
    place = rng.uniform(-1, 1, (count, 15)) * [5, 5, 6, 2, 0, 2, 5, 5, 6, 2, 1, 2, 2, 1, 2]
    place[::3, 9:12], place[::6, 12:] = 0.0, 0.0  # half of those at rest are about to set off
    place[1::3, [10, 13]] = 0.0
    for _ in range(periods):
        place = place + rng.normal(size=place.shape) * [0, 0, 0.5, 0.1, 0, 0.1, 0, 0, 0.5, 0, 0, 0, 0, 0, 0]
        place[::2, :2] = place[::2, 6:8] + 0.7 * (place[::2, :2] - place[::2, 6:8])
        place[1::2, :2] += rng.normal(size=place[1::2, :2].shape)
        yield place[:, :6], place[:, 6:]


@every_law
def test_scalar_law_is_the_array_law(name: str) -> None:
    """At hard places, and on the way to a leader, where modes change: whole turns; side, gear and docking."""
    require_same(name, zip(hard_walk().follower, hard_walk().leader, strict=True))
    seen = require_same(name, way_to_the_leader(150, 25))
    modes = [len(np.unique(column)) for column in seen.T]
    assert modes == [] or max(modes) > 2
    if name == "universal":
        assert modes[:3] == [2, 2, 2]


@pytest.mark.parametrize("field", Limits._fields)
def test_one_limit_alone_leaves_no_number_undefined(field: str) -> None:
    law = law_named("universal")(limits=Limits()._replace(**{field: 0.5}), **UNIVERSAL)
    walk = hard_walk()
    memory = first_memories(law, walk.follower[0], walk.leader[0], PERIOD)
    for follower, leader in zip(walk.follower, walk.leader, strict=True):
        u, memory = commands(law, follower, leader, memory, PERIOD)
        assert np.isfinite(u).all()


# -- virtual leaders ------------------------------------------------------------------------------------------------


def leaders(seed: int) -> np.ndarray:
    """Leaders anywhere with hard headings, some at rest or without lateral motion."""
    rng = np.random.default_rng(seed)
    rows = rng.uniform(-3, 3, (len(ANY_ANGLES), 9))
    rows[:, 2] = rng.permutation(ANY_ANGLES)
    rows[::4, 3:6], rows[::8, 6:] = 0.0, 0.0
    rows[1::4, [4, 7]] = 0.0
    return rows


@pytest.mark.parametrize("kind", ["convex", "exact"])
def test_scalar_fold_is_the_array_fold(kind: Any) -> None:
    a, b, found_turns, expected_turns = leaders(1), leaders(2), None, None
    weight = np.random.default_rng(3).uniform(0, 1, len(a))
    for turned in (0.0, 0.6, -1.1):
        pair = as_leader(a), as_leader(b + turned * np.eye(9)[2])
        found, found_turns = scalar.fold(*map(scalar.Leader._make, pair), weight, kind, found_turns)
        expected, expected_turns = array_leaders.fold(*pair, weight, kind, expected_turns)
        np.testing.assert_array_equal(found_turns, expected_turns)
        assert_same(np.concatenate(found, axis=-1), np.concatenate(expected, axis=-1))


@pytest.mark.parametrize("kind", ["printed", "exact"])
@pytest.mark.parametrize(("dead_zone", "limit"), [(0.0, math.inf), (1e-3, 1.0)])
def test_scalar_displacement_is_the_array_s(kind: Any, dead_zone: float, limit: float) -> None:
    leader = as_leader(leaders(1))
    offset = np.random.default_rng(2).choice([0.0, 0.004, -2.0, 7.5], (len(leader.g), 2))
    found, rate = scalar.displace(scalar.Leader(*leader), offset, kind, dead_zone, limit)
    expected, expected_rate = array_leaders.displace(leader, offset, kind, dead_zone, limit)
    assert_same(rate[:, None], expected_rate[:, None])
    assert_same(np.concatenate(found, axis=-1), np.concatenate(expected, axis=-1))


# -- SE(2) ----------------------------------------------------------------------------------------------------------


def by_rows(function: Any, *arguments: np.ndarray) -> np.ndarray:
    """What a scalar function makes of rows, one by one."""
    rows = [argument.tolist() if argument.ndim == 1 else map(tuple, argument.tolist()) for argument in arguments]
    return np.array([function(*each) for each in zip(*rows, strict=True)])


def assert_near(found: np.ndarray, expected: np.ndarray, *factors: np.ndarray) -> None:
    """Fails where a row is further off than rounding in shares of the product of the factors' sizes."""
    size = np.prod([1 + np.abs(factor).reshape(len(factor), -1).max(axis=1) for factor in factors], axis=0)
    off = np.abs(found - expected).max(axis=1) / size
    worst = int(off.argmax())
    assert off[worst] <= ROUNDING, f"row {worst}: got {found[worst]}, expected {expected[worst]}"


def test_scalar_poses_are_the_array_s() -> None:
    a, b, xi = poses(1), poses(2), twists(3)
    assert_near(by_rows(planar.compose, a, b), se2.compose(a, b), a, b)
    assert_near(by_rows(planar.between, a, b), se2.between(a, b), a, b)
    assert_near(by_rows(planar.Ad_inverse, a, xi), se2.Ad_inverse(a, xi), a, xi)
    assert_near(by_rows(planar.ad, a, xi), se2.ad(a, xi), a, xi)


def test_scalar_exponential_is_the_array_s() -> None:
    X = log_poses(1)
    dX, v = (twists(seed)[: len(X)] for seed in (2, 3))
    log, inverse = se2.log(X), se2.right_jacobian_inverse(X)
    assert_near(by_rows(planar.exp, X), se2.exp(X), X)
    assert_near(by_rows(planar.log, X), log, log)
    for function, matrix, factors in (
        (planar.right_jacobian, se2.right_jacobian(X), (X, v)),
        (planar.right_jacobian_inverse, inverse, (inverse, X, v)),
    ):
        assert_near(by_rows(function, X, v), (matrix @ v[..., None])[..., 0], *factors)
    derivative = (se2.right_jacobian_derivative(X, dX) @ v[..., None])[..., 0]
    assert_near(by_rows(planar.right_jacobian_derivative, X, dX, v), derivative, X, dX, v)


def test_scalar_angles_are_the_array_s() -> None:
    halves = PI * np.arange(-9, 10)
    theta = np.concatenate([ANY_ANGLES, halves, np.nextafter(halves, np.inf), np.nextafter(halves, -np.inf)])
    rng = np.random.default_rng(1)
    previous, hysteresis = rng.integers(-3, 4, len(theta)).astype(float), rng.uniform(0.01, 3.0, len(theta))
    np.testing.assert_array_equal(by_rows(planar.wrap, theta), se2.wrap(theta))
    np.testing.assert_array_equal(by_rows(planar.winding_number, theta), se2.winding_number(theta))
    after = by_rows(planar.winding_number_after, theta, previous, hysteresis)
    np.testing.assert_array_equal(after, se2.winding_number(theta, previous, hysteresis))
    assert_same(by_rows(planar.sinc_and_slope, theta), np.stack(array_sinc(theta), axis=-1))


def test_clip_keeps_what_is_not_a_number() -> None:
    assert [planar.clip(x, -1.0, 2.0) for x in (-3.0, 0.5, 3.0)] == [-1.0, 0.5, 2.0]
    assert math.isnan(planar.clip(math.nan, -1.0, 2.0))
