"""The compiled scalar code of laws, virtual leaders and SE(2) against the same written for arrays."""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable, Iterator
from functools import cache
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import strategies as draw
from nhtrack import planar, se2
from nhtrack.compiled import compiled
from nhtrack.laws import virtual_leader
from nhtrack.laws.contract import Follower, Leader, Limits
from reference import laws as arrays
from reference.laws import virtual_leader as array_leaders
from reference.laws.baselines.view import sinc as array_sinc

PI = math.pi

# The operations are the same in the same order, and most results have the same bits. What rounds otherwise: the law
# `universal` takes lengths by square roots and powers by products, the array form by `hypot` and `pow`; the exact fold
# multiplies by 3 x 3 matrices there. Relative to 1 and the largest number of the same result.
ROUNDING = 1e-12


# -- the two forms of each law --------------------------------------------------------------------------------------


class Both(NamedTuple):
    """A law as compiled scalar code and as arrays, with the same gains."""

    module: ModuleType
    gains: Any
    limits: Limits
    array: Any


LIMITS = {"speed": 1.5, "yaw_rate": 2.0, "acceleration": 3.0, "yaw_acceleration": 4.0}
PAPER = {"kp": 11.0, "kd": 25.1, "ke": 6.0, "k": 3.2, "dead_zone_length": 1e-6, "dead_zone_speed": 1e-3}
STILL = {"kp": 4.0, "kd": 5.0, "k": 6.0, "dead_zone_length": 0.0}
UNIVERSAL = {
    "k1": 16.0, "k2": 8.0, "k3": 6.0, "c": 0.5, "m": 1.5, "field_speed": 2.0, "turn_rate": 4.0, "dock_radius": 0.005,
    "dock_speed": 0.02,
}  # fmt: skip


def both(name: str, array: Callable[..., Any], gains: dict[str, Any], limits: dict[str, float] | None = None) -> Both:
    module = importlib.import_module(f"nhtrack.laws.{name}")
    given = dict(gains)
    if "variant" in given:
        given["variant"] = ("published", "full").index(given["variant"])
    bounded = {} if limits is None else {"limits": arrays.Limits(**limits)}
    return Both(module, module.Gains(**given), Limits(**(limits or {})), array(**gains, **bounded))


LAWS = {
    "published": both("published", arrays.Published, PAPER),
    "full": both("published", arrays.Published, {**PAPER, "variant": "full", "dead_zone_length": 0.3}),
    "stabiliser": both("stabiliser", arrays.Stabiliser, STILL),
    "universal": both("universal", arrays.Universal, UNIVERSAL),
    "limited": both("universal", arrays.Universal, UNIVERSAL, LIMITS),
    "kanayama": both("kanayama", arrays.Kanayama, {"k_x": 1.0, "k_y": 1.5, "k_theta": 2.0, "k_inner": 5.0}),
    "samson": both("samson", arrays.Samson, {"zeta": 0.7, "b": 1.5, "k_inner": 5.0}),
    "jiang_nijmeijer": both(
        "jiang_nijmeijer",
        arrays.JiangNijmeijer,
        {"k_x": 1.0, "gamma": 1.5, "k_theta": 1.2, "k_inner": 5.0, "coupling": 0.8},
    ),
    "feedback_linearisation": both(
        "feedback_linearisation", arrays.FeedbackLinearisation, {"kp": 1.0, "kd": 2.5, "k_inner": 5.0, "v_min": 0.1}
    ),
    "look_ahead": both("look_ahead", arrays.LookAhead, {"distance": 0.5, "k": 1.0, "k_inner": 5.0}),
}
every_law = pytest.mark.parametrize("name", LAWS)


@cache
def machine_code(module: ModuleType, function: str) -> Any:
    return compiled(getattr(module, function))


def begin(law: Both, follower: Follower, leader: Leader) -> Any:
    if not hasattr(law.module, "Memory"):
        return ()
    return machine_code(law.module, "init")(law.gains, 0.01, follower, leader)


def command(law: Both, follower: Follower, leader: Leader, memory: Any) -> tuple[float, float, Any]:
    result: tuple[float, float, Any] = machine_code(law.module, "command")(
        law.gains, 0.01, law.limits, follower, leader, memory
    )
    return result


# -- what is drawn --------------------------------------------------------------------------------------------------

angles = st.one_of(
    st.sampled_from([0.0, 1e-12, -1e-12, PI, -PI, PI + 1e-9, -PI - 1e-9, PI / 2, PI + 0.3, -PI - 0.3, 3 * PI, 1e-300]),
    st.floats(-20.0, 20.0),
)
# No lengths whose squares underflow: the array form's `hypot` knows a direction 1e-200 m from the leader.
places = st.one_of(st.sampled_from([0.0, 1e-12, 0.004, 0.007]), st.floats(-20.0, 20.0).map(lambda x: round(x, 12)))
rates = st.one_of(st.sampled_from([0.0, 0.01, 0.03]), st.floats(-3.0, 3.0).map(lambda x: round(x, 12)))


@st.composite
def followers(draw_one: st.DrawFn) -> Follower:
    return Follower(*draw_one(st.tuples(places, places, angles, rates, st.one_of(st.just(0.0), rates), rates)))


@st.composite
def leaders(draw_one: st.DrawFn) -> Leader:
    """Moving, at rest (one in four), or with lateral velocity (one in four)."""
    pose = draw_one(st.tuples(places, places, angles))
    (v, aside, omega), u = draw_one(st.tuples(rates, rates, rates)), draw_one(st.tuples(rates, rates, rates))
    match draw_one(st.integers(0, 3)):
        case 0:
            return Leader(*pose, 0.0, 0.0, 0.0, *draw_one(st.sampled_from([(0.0, 0.0, 0.0), (u[0], 0.0, u[2])])))
        case 1:
            return Leader(*pose, v, aside, omega, *u)
    return Leader(*pose, v, 0.0, omega, u[0], 0.0, u[2])


@st.composite
def encounters(draw_one: st.DrawFn) -> list[tuple[Follower, Leader]]:
    """A follower and its leader over a few periods: both turn a little or by whole turns, and the leader may stop."""
    follower, leader = draw_one(followers()), draw_one(leaders())
    if draw_one(st.integers(0, 5)) == 0:
        follower = follower._replace(x=leader.x, y=leader.y)
    found = [(follower, leader)]
    for _ in range(draw_one(st.integers(0, 4))):
        turn, step = draw_one(st.tuples(st.one_of(st.floats(-1.0, 1.0), angles), places))
        follower = follower._replace(theta=follower.theta + turn, x=follower.x + step, v_x=draw_one(rates))
        leader = leader._replace(v_x=draw_one(rates), u_theta=draw_one(rates))
        found.append((follower, leader))
    return found


# -- laws -----------------------------------------------------------------------------------------------------------


def as_robots(follower: Follower) -> arrays.Robots:
    values = np.array(follower)
    return arrays.Robots(values[..., :3], values[..., 3:])


def as_leader(leader: Leader) -> arrays.Leader:
    values = np.array(leader)
    return arrays.Leader(values[..., :3], values[..., 3:6], values[..., 6:])


def same(found: Any, expected: Any) -> bool:
    found, expected = np.array(found, dtype=float), np.array(expected, dtype=float)
    return bool(np.abs(found - expected).max() <= ROUNDING * (1 + np.abs(expected).max()))


def memories(memory: Any) -> tuple[float, ...]:
    """The memory of an array law, or of a scalar one, as numbers."""
    return tuple(float(value) for value in (memory if isinstance(memory, tuple) else (memory,)))


@every_law
@settings(max_examples=40)
@given(encounter=encounters())
def test_scalar_law_is_the_array_law(name: str, encounter: list[tuple[Follower, Leader]]) -> None:
    law = LAWS[name]
    memory = begin(law, *encounter[0])
    expected_memory = law.array.init(as_robots(encounter[0][0]), as_leader(encounter[0][1]))
    assert memories(memory) == memories(expected_memory)
    for follower, leader in encounter:
        u_x, u_theta, memory = command(law, follower, leader, memory)
        expected, expected_memory = law.array(as_robots(follower), as_leader(leader), expected_memory)
        assert same((u_x, u_theta), expected)
        assert memories(memory) == memories(expected_memory)


def walks(count: int, periods: int) -> Iterator[np.ndarray]:
    """States of followers and leaders, shape (count, 15), period by period: from 5 m apart to where they dock."""
    rng = np.random.default_rng(1)
    place = rng.uniform(-1, 1, (count, 15)) * [5, 5, 6, 2, 0, 2, 5, 5, 6, 2, 0, 2, 2, 0, 2]
    place[::3, 9:] = 0.0
    for _ in range(periods):
        place = place + rng.normal(size=place.shape) * [0, 0, 0.5, 0.1, 0, 0.1, 0, 0, 0.5, 0, 0, 0, 0, 0, 0]
        place[::2, :2] = place[::2, 6:8] + 0.7 * (place[::2, :2] - place[::2, 6:8])
        place[1::2, :2] += rng.normal(size=place[1::2, :2].shape)
        yield place


@every_law
def test_scalar_law_is_the_array_law_on_the_way_to_its_leader(name: str) -> None:
    law, memory, expected_memory = LAWS[name], None, None
    seen = set()
    for place in walks(60, 25):
        robots, ahead = as_robots(place[:, :6]), as_leader(place[:, 6:])
        pairs = [(Follower(*row[:6]), Leader(*row[6:])) for row in place.tolist()]
        if memory is None:
            memory = [begin(law, *pair) for pair in pairs]
            expected_memory = law.array.init(robots, ahead)
        expected, expected_memory = law.array(robots, ahead, expected_memory)
        results = [command(law, *pair, kept) for pair, kept in zip(pairs, memory, strict=True)]
        memory = [result[2] for result in results]
        seen |= set(memory)
        assert all(same(result[:2], row) for result, row in zip(results, expected, strict=True))
        if law.module.__name__.endswith("universal"):
            expected_modes = [tuple(map(float, modes)) for modes in zip(*expected_memory, strict=True)]
            assert [memories(kept) for kept in memory] == expected_modes
    # Modes change on the way: whole turns, and with `universal` side, gear and docking.
    assert memory == [()] * 60 or len(seen) > 2
    if name == "universal":
        assert [len({kept[mode] for kept in seen}) for mode in range(3)] == [2, 2, 2]


@every_law
def test_memory_keeps_the_types_of_its_fields(name: str) -> None:
    law = LAWS[name]
    follower, leader = Follower(1.0, 2.0, 3.0, 0.5, 0.0, 0.3), Leader(3.0, 1.0, -2.5, 1.0, 0.0, 0.2, 0.1, 0.0, 0.3)
    memory = begin(law, follower, leader)
    for kept in (memory, command(law, follower, leader, memory)[2]):
        for field, value in zip(getattr(kept, "_fields", ()), kept, strict=True):
            assert type(value) is (bool if field == "docked" else int)


@every_law
def test_python_says_what_machine_code_says(name: str) -> None:
    law = LAWS[name]
    follower, leader = Follower(1.0, 2.0, 3.0, 0.5, 0.0, 0.3), Leader(3.0, 1.0, -2.5, 1.0, 0.0, 0.2, 0.1, 0.0, 0.3)
    memory = begin(law, follower, leader)
    found = command(law, follower, leader, memory)
    expected = law.module.command(law.gains, 0.01, law.limits, follower, leader, memory)
    assert same(found[:2], expected[:2])
    assert found[2] == expected[2]


@settings(max_examples=20)
@given(encounter=encounters(), largest=st.floats(0.1, 3.0))
def test_one_limit_alone_leaves_no_number_undefined(encounter: list[tuple[Follower, Leader]], largest: float) -> None:
    for field in Limits._fields:
        law = LAWS["universal"]._replace(limits=Limits()._replace(**{field: largest}))
        memory = begin(law, *encounter[0])
        for pair in encounter:
            u_x, u_theta, memory = command(law, *pair, memory)
            assert math.isfinite(u_x)
            assert math.isfinite(u_theta)


# -- virtual leaders ------------------------------------------------------------------------------------------------


def parts(leader: arrays.Leader) -> np.ndarray:
    return np.concatenate(leader)


@pytest.mark.parametrize("exact", [False, True])
@settings(max_examples=50)
@given(pairs=st.lists(st.tuples(leaders(), leaders()), min_size=1, max_size=3), weight=st.floats(0.0, 1.0))
def test_scalar_fold_is_the_array_fold(exact: bool, pairs: list[tuple[Leader, Leader]], weight: float) -> None:
    turns, expected_turns = 0.0, None
    kind = "exact" if exact else "convex"
    for a, b in pairs:
        found, turns = virtual_leader.fold(a, b, weight, exact, turns, expected_turns is not None)
        expected, expected_turns = array_leaders.fold(
            as_leader(a), as_leader(b), np.asarray(weight), kind, expected_turns
        )
        assert turns == expected_turns
        assert same(found, parts(expected))


@pytest.mark.parametrize("exact", [False, True])
@settings(max_examples=50)
@given(
    leader=leaders(),
    offset=st.tuples(places, places),
    dead_zone=st.sampled_from([0.0, 1e-3]),
    limit=st.sampled_from([1.0, math.inf]),
)
def test_scalar_displacement_is_the_array_s(
    exact: bool, leader: Leader, offset: tuple[float, float], dead_zone: float, limit: float
) -> None:
    found, rate = virtual_leader.displace(leader, *offset, exact, dead_zone, limit)
    kind = "exact" if exact else "printed"
    expected, expected_rate = array_leaders.displace(as_leader(leader), np.array(offset), kind, dead_zone, limit)
    assert same(rate, expected_rate)
    assert same(found, parts(expected))


# -- SE(2) ----------------------------------------------------------------------------------------------------------


def near(found: Any, expected: np.ndarray, size: float) -> bool:
    return bool(np.abs(np.array(found) - expected).max() <= ROUNDING * (1 + size))


def size_of(*vectors: np.ndarray) -> float:
    """Largest product of components, one of each vector."""
    return float(np.prod([1 + np.abs(vector).max() for vector in vectors]))


@given(draw.poses, draw.poses, draw.twists)
def test_scalar_poses_are_the_array_s(a: np.ndarray, b: np.ndarray, xi: np.ndarray) -> None:
    poses, size = (tuple(map(float, a)), tuple(map(float, b))), size_of(a, b)
    assert near(planar.compose(*poses), se2.compose(a, b), size)
    assert near(planar.between(*poses), se2.between(a, b), size)
    twist = tuple(map(float, xi))
    assert near(planar.Ad_inverse(poses[0], twist), se2.Ad_inverse(a, xi), size_of(a, xi))
    assert near(planar.ad(poses[0], twist), se2.ad(a, xi), size_of(a, xi))


@given(draw.log_poses, draw.twists, draw.twists)
def test_scalar_exponential_is_the_array_s(X: np.ndarray, dX: np.ndarray, v: np.ndarray) -> None:
    coordinates, rate, vector = (tuple(map(float, values)) for values in (X, dX, v))
    assert near(planar.exp(coordinates), se2.exp(X), size_of(X))
    log = se2.log(X)
    assert near(planar.log(coordinates), log, size_of(log))
    assert near(planar.right_jacobian(coordinates, vector), se2.right_jacobian(X) @ v, size_of(X, v))
    inverse = se2.right_jacobian_inverse(X)
    assert near(planar.right_jacobian_inverse(coordinates, vector), inverse @ v, size_of(inverse, X, v))
    derivative = se2.right_jacobian_derivative(X, dX)
    assert near(planar.right_jacobian_derivative(coordinates, rate, vector), derivative @ v, size_of(X, dX, v))


@given(draw.any_angles, st.integers(-3, 3), st.floats(0.01, 3.0))
def test_scalar_angles_are_the_array_s(theta: float, previous: int, hysteresis: float) -> None:
    angle = np.asarray(theta)
    assert planar.wrap(theta) == se2.wrap(angle)
    assert planar.winding_number(theta) == se2.winding_number(angle)
    after = se2.winding_number(angle, np.asarray(float(previous)), hysteresis)
    assert planar.winding_number_after(theta, float(previous), hysteresis) == after
    assert same(planar.sinc_and_slope(theta), array_sinc(angle))


@pytest.mark.parametrize("half_turns", range(-9, 10))
def test_scalar_angles_at_half_turns(half_turns: int) -> None:
    exact = half_turns * PI
    for theta in (exact, math.nextafter(exact, math.inf), math.nextafter(exact, -math.inf)):
        assert planar.wrap(theta) == se2.wrap(np.asarray(theta))
        assert planar.winding_number(theta) == se2.winding_number(np.asarray(theta))


def test_clip_keeps_what_is_not_a_number() -> None:
    assert [planar.clip(x, -1.0, 2.0) for x in (-3.0, 0.5, 3.0)] == [-1.0, 0.5, 2.0]
    assert math.isnan(planar.clip(math.nan, -1.0, 2.0))
