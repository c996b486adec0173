"""Leaders on curves by formulas and through waypoints: exact derivatives, limits kept, and what no unicycle follows."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import Chebyshev

import tolerances as tol
from nhtrack.references import Expression, Motion, ReferenceInputError
from nhtrack.references.path import PathInput
from nhtrack.simulation.ideal import propagate

PERIOD = 0.01
SQUARE = [[0, 0], [2, 0], [2, 1], [0, 1]]
LIMITS = {"speed": 0.5, "acceleration": 0.3}


@pytest.mark.parametrize("t", [0.7, 1.7])
@pytest.mark.parametrize(
    "text",
    [
        "sin(t)*cos(2*t)/(1 + t**2) - 3",
        "tan(t/3) + tanh(t)*sinh(t) - cosh(t)",
        "asin(t/4) + acos(t/5)*atan(t)",
        "atan2(sin(t), cos(t) - 2) - atan2(cos(t) - 2, sin(t))",
        "log(t + 2)**1.5 + exp(-t) + sqrt(1 + t)",
        "t**3 - 2**t + t**t + t**-2 + t**5.5",
        "(1 + t) % 5 - 1/t + 7 // (t + 9) + 4 % (t/9 + 1.2)",
        "log(t + 3, 2) + abs(-t)*min(t, 9) - max(t**2, 1)",
        "where(t < 1, t**2, -t) + floor(t) + ceil(t)*sign(t) + (t > 1)",
    ],
)
def test_derivatives_are_those_of_a_polynomial_through_the_values(text: str, t: float) -> None:
    expression = Expression(text)
    near = Chebyshev.interpolate(expression, 14, domain=[t - 0.12, t + 0.12])
    expected = [near(t), *(near.deriv(k)(t) for k in (1, 2, 3))]
    found = expression.derivatives(np.array([t]))[0]
    np.testing.assert_allclose(found[0], expression(np.array([t]))[0], rtol=tol.HAND)
    np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-7)  # of a polynomial of order 14


@pytest.mark.parametrize(
    ("text", "powers"), [("t**2", [0, 0, 2, 0]), ("t**4.5 + 1", [1, 0, 0, 0]), ("(0*t)**0.5", [0, 0, 0, 0])]
)
def test_powers_have_derivatives_where_their_base_is_zero(text: str, powers: list[float]) -> None:
    assert Expression(text).derivatives(np.zeros(1))[0].tolist() == powers


@pytest.mark.parametrize("text", ["sqrt(t)", "t**2.5", "asin(1 - t)", "1/t"])
def test_a_derivative_that_is_infinite_is_told(text: str) -> None:
    with pytest.raises(ReferenceInputError, match="at t = 0"):
        Expression(text).derivatives(np.zeros(1))


def path_of(**given: Any) -> PathInput:
    return PathInput.model_validate({"path": given})


def driven(motion: Motion, until: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns instants, and poses and twists that the exact flow makes of the accelerations."""
    instants = np.arange(round(until / PERIOD) + 1) * PERIOD
    g, (v, omega) = motion.poses(instants[:1])[0], motion.speeds(instants[:1])[0]
    xi = np.array([v, 0.0, omega])
    poses, twists = [g], [xi]
    for u in motion.held(instants):
        g, xi = propagate(g, xi, u, PERIOD)
        poses.append(g)
        twists.append(xi)
    return instants, np.array(poses), np.array(twists)


@pytest.mark.parametrize(
    ("x", "y"),
    [
        ("cos(t)", "sin(2*t)/2"),
        ("sin(t)", 0.0),
        ("1 - cos(t)", "0"),  # begins at rest, and rests and turns back again and again
        ("t - sin(t)", "1 - cos(t)"),  # begins at a cusp, and has more
        ("cos(t)**3", "sin(t)**3"),  # four cusps a round
        ("where(t < 5, (5 - t)**3, where(t < 8, 0, -(t - 8)**3))", "1"),  # stands still in between
    ],
)
def test_the_ideal_robot_is_on_the_curve(x: str | float, y: str | float) -> None:
    motion = path_of(x=x, y=y).reference()
    instants, poses, twists = driven(motion, 20.0)
    for column, text in enumerate((x, y)):
        np.testing.assert_allclose(poses[:, column], Expression(str(text))(instants), atol=2e-5)
    np.testing.assert_allclose(twists[:, [0, 2]], motion.speeds(instants), atol=5e-3)  # by what mends poses
    assert path_of(x=x, y=y).start() == (tuple(motion.poses(instants)[0]), tuple(motion.speeds(instants)[0]))
    assert list(PathInput.findings({"path": {"x": x, "y": y}}, instants[1:])) == []


@pytest.mark.parametrize(
    ("x", "y", "message"),
    [
        ("t % 3", "t", "at t = 3: it jumps by 3"),
        ("where(t < 5, t, 5)", "0", "at t = 5: its velocity jumps by 1"),
        ("abs(t - 5)", "t", "at t = 5: its velocity jumps by 2"),
        ("where(t < 5, (t - 5)**2, 0)", "where(t < 5, 0, (t - 5)**2)", "at t = 5: its tangent turns by 1.57 rad"),
        ("1", "2", "stands still at t = 0"),
        ("where(t < 2, 0, t - 2)", "0", "stands still at t = 0"),
        ("sqrt(t)", "t", "has no value at t = 0"),
    ],
)
def test_curves_that_no_unicycle_follows_are_refused_with_the_time(x: str, y: str, message: str) -> None:
    ((path, told),) = PathInput.findings({"path": {"x": x, "y": y}}, (np.arange(1000) + 0.5) * PERIOD)
    assert path == ("path",)
    assert message in told


@pytest.mark.parametrize("closed", [False, True])
@given(
    st.lists(st.tuples(st.floats(-5, 5), st.floats(-5, 5)), min_size=3, max_size=6),
    st.floats(0.1, 2),
    st.floats(0.1, 2),
    st.floats(0.1, 2),
)
@settings(max_examples=15, deadline=None)
def test_a_smooth_line_meets_its_waypoints_within_its_limits(
    closed: bool, points: list[tuple[float, float]], speed: float, acceleration: float, lateral: float
) -> None:
    given = {"waypoints": points, "closed": closed, "speed": speed, "acceleration": acceleration}
    given |= {"lateral_acceleration": lateral, "yaw_rate": 1.5, "laps": 2 if closed else 1}
    if list(PathInput.findings({"path": given}, None)) or list(path_of(**given).path.faults()):  # type: ignore[union-attr]
        return  # it turns as good as on the spot, or two points are the same
    motion = path_of(**given).reference()
    t = np.linspace(0, motion.end, 20_001)
    poses, speeds = motion.poses(t), motion.speeds(t)
    for x, y in points:
        assert np.hypot(poses[:, 0] - x, poses[:, 1] - y).min() < 1.1 * speed * motion.end / 20_000
    v, omega = abs(speeds.T)
    assert v.max() < speed * (1 + 1e-9)
    assert abs(np.diff(v)).max() / t[1] < acceleration * (1 + 1e-6)
    assert omega.max() < 1.5 * 1.05  # between the places of the line at which limits are asked for
    assert (v * omega).max() < lateral * 1.05
    assert v[0] == 0
    assert v[-1] < 1e-6 * speed
    if closed:
        np.testing.assert_allclose(poses[-1, :2], poses[0, :2], atol=1e-9)


def test_a_smooth_line_is_driven_as_fast_as_its_limits_allow() -> None:
    """On a straight line the time is known; a bend is driven at one of the limits at every moment."""
    straight = path_of(waypoints=[[0, 0], [1, 0], [3, 0]], **LIMITS).reference()
    assert straight.end == pytest.approx(3 / 0.5 + 0.5 / 0.3, rel=1e-4)
    bent = path_of(waypoints=SQUARE, closed=True, lateral_acceleration=0.2, **LIMITS).reference()
    t = np.linspace(0, bent.end, 5001)
    v, omega = bent.speeds(t).T
    change = abs(np.gradient(v, t))
    assert (np.maximum(np.maximum(v / 0.5, change / 0.3), abs(v * omega) / 0.2) > 0.99).mean() > 0.995


def test_stop_and_turn_drives_straight_from_rest_to_rest() -> None:
    given = {"waypoints": SQUARE, "closed": True, "corner": "stop-and-turn", "yaw_rate": 0.8, "pause": 0.5, "laps": 2}
    motion = path_of(**given, **LIMITS).reference()
    instants, poses, twists = driven(motion, 80.0)
    sides = 2 * (2 / 0.5 + 0.5 / 0.3) + 2 * (1 / 0.5 + 0.5 / 0.3)
    turns = 4 * (0.5 * math.pi / 0.8 + 0.8 / 1.0)
    assert motion.end == pytest.approx(2 * (sides + turns + 4 * 0.5))
    np.testing.assert_allclose(poses, motion.poses(instants), atol=5e-5)
    np.testing.assert_allclose(poses[-1], [0, 0, 4 * math.pi], atol=1e-6)
    assert abs(twists[-1]).max() < 1e-9
    x, y, _ = poses.T
    assert np.minimum(abs(x) + abs(x - 2), 9).max() < 2 + 1e-4
    assert np.minimum.reduce([abs(x), abs(x - 2), abs(y), abs(y - 1)]).max() < 5e-6
    speeds = motion.speeds(instants)
    assert (speeds.prod(axis=1) == 0).all()
    assert abs(np.diff(speeds, axis=0) / PERIOD).max(axis=0) == pytest.approx([0.3, 1.0])
    for corner in SQUARE:
        assert np.hypot(*(poses[speeds[:, 0] == 0][:, :2] - corner).T).min() < 5e-6


def test_a_way_back_is_a_turn_to_the_left_and_collinear_waypoints_are_none() -> None:
    given = {"waypoints": [[0, 0], [1, 1], [3, 3], [0, 0]], "corner": "stop-and-turn"}
    motion = path_of(**given, **LIMITS).reference()
    theta = motion.poses(np.linspace(0, motion.end, 101))[:, 2]
    assert theta[[0, -1]] == pytest.approx([math.pi / 4, 5 * math.pi / 4])
    assert (np.diff(theta) >= 0).all()


@pytest.mark.parametrize(
    ("given", "place", "message"),
    [
        ({"waypoints": [[0, 0], [1, 0], [1, 0]]}, 2, "the same place"),
        ({"waypoints": [*SQUARE, [0, 0]], "closed": True}, 0, "the same place"),
        ({"waypoints": SQUARE, "curvature": 1.0}, 2, "bends by 1.94 near here, more than the 1 allowed"),
        ({"waypoints": [[0, 0], [1, 0], [0, 0]]}, 1, "turns as good as on the spot"),
    ],
)
def test_waypoints_that_cannot_be_driven_through_are_told(given: dict[str, Any], place: int, message: str) -> None:
    ((path, told),) = PathInput.findings({"path": given | LIMITS}, np.array([0.5, 1.0]))
    assert path == ("path", "waypoints", place)
    assert message in told
    with pytest.raises(ReferenceInputError, match=f"waypoint {place + 1}"):
        path_of(**given, **LIMITS).reference()
