"""Robots that overlap where they are placed: by how much, by hand, and what a scenario says of it."""

from pathlib import Path

import numpy as np
import pytest

from nhtrack.effects import Effect
from nhtrack.effects.planar_base import PlanarBase
from nhtrack.errors import ScenarioError
from nhtrack.experiment.load import load_text
from nhtrack.simulation.overlaps import overlaps
from nhtrack.simulation.robot_models import read_robot
from nhtrack.simulation.spec import SceneSpec

HULL = 0.06  # [m] radius of nh_mini, a cylinder about the middle of its axle
FOUND = 2e-6  # [m] MuJoCo finds contacts of cylinders within 1e-6, and an overlap is one above that

SCENARIO = """
name: near
duration: 1
backend: mujoco
physics: {robot_contact: true}
law: {name: universal}
leader: {virtual: false, start: {pose: [0, 0, 0]}, input: {u_x: "0", u_theta: "0"}}
followers:
- {name: a, parents: [leader], start: {pose: [1, 0, 0]}}
- {name: b, parents: [a], start: {pose: [1.05, 0.08, 2]}}
- {name: c, parents: [a], start: {pose: [0.03, 0.04, 1]}}
"""


@pytest.mark.parametrize(
    ("distance", "effects"),
    [(0.0, ()), (0.001, ()), (0.0999, (PlanarBase(),)), (0.1199, ()), (0.1201, ()), (0.1201, (PlanarBase(),))],
)
def test_round_robots_overlap_by_two_radii_less_their_distance(distance: float, effects: tuple[Effect, ...]) -> None:
    spec = SceneSpec(("one", "other", "far"), robot_contact=True, effects=effects)
    along = distance * np.array([np.cos(2.0), np.sin(2.0)])
    pose = np.array([[0.3, -0.2, 0.4], [0.3 + along[0], -0.2 + along[1], 1.9], [5.0, 0.0, 0.0]])
    found = [(first, second, depth) for first, second, depth in overlaps(spec, read_robot(spec), pose)]
    expected = [(0, 1, pytest.approx(2 * HULL - distance, abs=FOUND))] if distance < 2 * HULL else []
    assert found == expected


def test_who_overlaps_at_the_start_is_refused_by_name_with_the_line() -> None:
    with pytest.raises(ScenarioError) as refused:
        load_text(SCENARIO)
    told = [(fault.line, fault.key, fault.message) for fault in refused.value.faults]
    rest = "at the start, and robots collide (physics.robot_contact): start them farther apart"
    depth = 120 - np.hypot(50, 80)
    assert told == [
        (10, "followers[1].start", f"the hulls of 'b' and 'a' overlap by {depth:.3g} mm {rest}"),
        (11, "followers[2].start", f"the hulls of 'c' and 'leader' overlap by 70 mm {rest}"),
    ]


@pytest.mark.parametrize(
    ("before", "after", "refused"),
    [
        ("robot_contact: true", "robot_contact: false", 0),
        ("backend: mujoco", "backend: ideal", 0),
        ("virtual: false", "virtual: true", 1),  # nobody overlaps a leader without a body
        ("duration: 1", "duration: 1\nsimilarity: {length: 10}", 0),
        ("duration: 1", "duration: 1\nsimilarity: {length: 0.1, time: auto}", 3),
    ],
)
def test_only_hulls_that_collide_are_refused(before: str, after: str, refused: int) -> None:
    assert len(faults_of(SCENARIO.replace(before, after))) == refused


def faults_of(text: str) -> list[str]:
    try:
        load_text(text, directory=Path())
    except ScenarioError as error:
        return [fault.message for fault in error.faults]
    return []
