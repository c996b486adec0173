"""The paper's examples: what its figures and page show of runs made by hand, and what Examples 4 and 5 come to."""

from __future__ import annotations

import re
from functools import cache

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.patches import Circle, FancyArrowPatch, Polygon
from scipy.spatial.distance import pdist

from nhtrack import assets
from nhtrack.analysis.metrics import smallest_separation, summary
from nhtrack.colours import FOLLOWERS, ROOT, robot_colour
from nhtrack.experiment.build import build
from nhtrack.experiment.load import load
from nhtrack.network import Network
from nhtrack.studies.feasibility.run import ideal_motion
from nhtrack.studies.paper.examples import EXAMPLES, ExampleError, examples_of
from nhtrack.studies.paper.figure import (
    START,
    leader_motion,
    panels,
    reference_path,
    side_by_side,
    topology,
    tracks,
)
from nhtrack.studies.paper.page import angle, initial_conditions
from nhtrack.studies.run.run import simulate
from recordings import synthetic_recording
from tolerances import HAND

LENGTH, TIME = 0.004, 4.0  # scales of the synthetic recordings
HULL = 0.13  # [m] a robot's diameter and some air
TARGETS = {"paper/example4": 0.015, "paper/example5": 0.025}  # late position error, of the leader's path


def lines(axes, colour: str, width: float) -> list[np.ndarray]:
    """Returns the data (k, 2) of the lines of one colour and width."""
    found = [line for line in axes.lines if to_hex(line.get_color()) == colour.lower()]
    return [line.get_xydata() for line in found if line.get_linewidth() == width]


def darts(axes, colour: str) -> list[Polygon]:
    return [patch for patch in axes.patches if isinstance(patch, Polygon) and to_hex(patch.get_facecolor()) == colour]


# -- figures ---------------------------------------------------------------------------------------


def test_panels_stand_at_the_papers_instants_in_its_units():
    recording = synthetic_recording(3, samples=401)
    figure = panels(tracks(recording), (0.15, 0.25, 0.5, 1.0), "title")
    assert [axes.get_title("left") for axes in figure.axes] == [
        "(a) $t$ = 15% $T$ = 3 s",
        "(b) $t$ = 25% $T$ = 5 s",
        "(c) $t$ = 50% $T$ = 10 s",
        "(d) $t$ = 100% $T$ = 20 s",
    ]
    pose = recording["pose"].values / [LENGTH, LENGTH, 1.0]
    for axes, last in zip(figure.axes, (60, 100, 200, 400), strict=True):
        assert axes.get_aspect() == 1.0
        for place in range(4):
            (path,) = lines(axes, robot_colour(place), 1.2)
            np.testing.assert_allclose(path, pose[: last + 1, place, :2], rtol=HAND)
            (dart,) = darts(axes, robot_colour(place).lower())
            nose, notch = dart.get_xy()[0], dart.get_xy()[2]
            heading = np.arctan2(*(nose - notch)[::-1])
            assert np.cos(heading - pose[last, place, 2]) == pytest.approx(1.0, abs=HAND)


def test_mujoco_lies_over_a_broad_ideal_twin():
    recording = synthetic_recording(1, samples=101)
    (axes,) = panels(tracks(recording), (1.0,), "title").axes
    found = [line for line in axes.lines if to_hex(line.get_color()) == FOLLOWERS[0].lower()]
    thin, broad = sorted(found, key=lambda line: line.get_linewidth())
    assert broad.get_linewidth() > 3 * thin.get_linewidth()
    assert thin.get_zorder() > broad.get_zorder()
    np.testing.assert_allclose(broad.get_xydata(), recording["ideal_pose"].values[:, 1, :2] / LENGTH, rtol=HAND)
    np.testing.assert_allclose(thin.get_xydata(), recording["pose"].values[:, 1, :2] / LENGTH, rtol=HAND)


def test_two_runs_share_one_plot_and_their_start_is_marked():
    one, other = synthetic_recording(1, samples=101), synthetic_recording(1, samples=101)
    other["pose"].values[:, 1, 1] *= -1
    figure = panels(side_by_side({"pi": one, "minus pi": other}), (0.25, 1.0), "title", shared_start=1)
    assert len(figure.axes) == 2
    for axes, last in zip(figure.axes, (25, 100), strict=True):
        for colour, run in zip((ROOT, *FOLLOWERS[:2]), (one, one, other), strict=True):
            (path,) = lines(axes, colour, 1.2)
            place = int(colour != ROOT)
            np.testing.assert_allclose(path, run["pose"].values[: last + 1, place, :2] / LENGTH, rtol=HAND)
        (start,) = darts(axes, START.lower())
        nose, notch = start.get_xy()[0], start.get_xy()[2]  # the axle midpoint lies between them
        midpoint = (0.20 * nose + 0.62 * notch) / 0.82
        assert midpoint == pytest.approx(one["pose"].values[0, 1, :2] / LENGTH)


def test_a_formation_is_joined_along_its_edges():
    recording = synthetic_recording(3, samples=51)
    (axes,) = panels(tracks(recording, joined=True), (1.0,), "title").axes
    joins = lines(axes, "#888888", 0.9)
    ends = recording["pose"].values[-1, :, :2] / LENGTH
    assert len(joins) == 3  # the synthetic followers all track the leader
    for join, follower in zip(joins, ends[1:], strict=True):
        np.testing.assert_allclose(join, [ends[0], follower], rtol=HAND)


def test_the_leaders_motion_is_in_scenario_units():
    recording = synthetic_recording(1, samples=101)
    left, right = leader_motion(recording, "title").axes
    (u_x,), (u_theta,) = (lines(left, colour, 1.2) for colour in (ROOT, FOLLOWERS[0]))
    (v,), (omega,) = (lines(right, colour, 1.2) for colour in (ROOT, FOLLOWERS[0]))
    np.testing.assert_allclose(u_x[:, 0], recording.time / TIME, rtol=HAND)
    np.testing.assert_allclose(u_x[:, 1], recording["input"].values[:, 0, 0] * TIME**2 / LENGTH, rtol=HAND)
    np.testing.assert_allclose(u_theta[:, 1], recording["input"].values[:, 0, 1] * TIME**2, rtol=HAND)
    np.testing.assert_allclose(v[:, 1], recording["twist"].values[:, 0, 0] * TIME / LENGTH, rtol=HAND)
    np.testing.assert_allclose(omega[:, 1], recording["twist"].values[:, 0, 2] * TIME, rtol=HAND)


def test_halts_are_ringed_and_turns_on_the_spot_are_not():
    recording = synthetic_recording(1, samples=101)
    twist = recording["twist"].values
    twist[:, 0] = [1.0, 0.0, 0.0]
    twist[20:31, 0] = 0.0  # a halt
    twist[50:61, 0] = [0.0, 0.0, 1.0]  # a turn on the spot
    twist[90:, 0] = 0.0  # the end
    (axes,) = reference_path(recording, "title").axes
    (rings,) = [line for line in axes.lines if line.get_marker() == "o"]
    np.testing.assert_allclose(rings.get_xydata(), recording["pose"].values[[25], 0, :2] / LENGTH, rtol=HAND)
    assert not lines(axes, FOLLOWERS[0], 1.2)


def test_the_graph_goes_left_to_right_by_level():
    parents = {"a": (), "b": ("a",), "c": ("a",), "d": ("b", "c"), "e": ("a", "d")}
    (axes,) = topology(parents).axes
    x = dict(zip(parents, (p.center[0] for p in axes.patches if isinstance(p, Circle)), strict=True))
    assert x["a"] < x["b"] == x["c"] < x["d"] < x["e"]
    assert sum(isinstance(patch, FancyArrowPatch) for patch in axes.patches) == 6
    assert [text.get_text() for text in axes.texts] == ["A", "B", "C", "D", "E"]


# -- the page --------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [f"paper/{name}" for example in EXAMPLES.values() for name in example.scenarios])
def test_initial_conditions_are_the_scenarios(name: str):
    scenario = load(name)
    _, _, *rows = initial_conditions(scenario).splitlines()
    for robot, row in zip((scenario.leader, *scenario.followers), rows, strict=True):
        title, *cells = (cell.strip() for cell in row.strip("|").split("|"))
        theta, x, y, omega, v = (number(cell) for cell in cells)
        assert title == robot.name
        assert (x, y, v, omega) == (*robot.start.pose[:2], *robot.start.twist)
        assert theta == pytest.approx(robot.start.pose[2], abs=HAND)


def number(cell: str) -> float:
    """Returns the number that a cell such as `-pi/2` says."""
    match = re.fullmatch(r"(-?)(?:(\d+) )?pi(?:/(\d+))?", cell)
    if match is None:
        return float(cell)
    return (-1 if match[1] else 1) * int(match[2] or 1) * np.pi / int(match[3] or 1)


@pytest.mark.parametrize(
    ("theta", "text"),
    [(0.0, "0"), (np.pi, "pi"), (-np.pi / 2, "-pi/2"), (-3 * np.pi / 4, "-3 pi/4"), (1.0, "1"), (3.14159, "3.14159")],
)
def test_angles_are_fractions_of_pi_only_where_they_are(theta: float, text: str):
    assert angle(theta) == text


def test_every_paper_scenario_belongs_to_one_example():
    named = sorted(name for example in EXAMPLES.values() for name in example.scenarios)
    assert [f"paper/{name}" for name in named] == [n for n in assets.bundled_scenarios() if n.startswith("paper/")]
    assert [example.number for example in examples_of([5, 1, 5])] == [1, 5]
    with pytest.raises(ExampleError, match=r"no Example 6 in the paper; .*available: 1, 2, 3, 4, 5"):
        examples_of([1, 6])


# -- what Examples 4 and 5 come to -----------------------------------------------------------------


@cache
def ideal_run(name: str):
    run, lost = ideal_motion(build(load(name)))
    assert not lost
    return run


@pytest.mark.parametrize("name", TARGETS)
def test_followers_end_near_their_places_on_the_ideal_model(name: str):
    run = ideal_run(name)
    error = run.variables["error"][int(0.85 * len(run.time)) :, 1:]
    path = np.abs(run.variables["twist"][:-1, 0, 0]).sum() * (run.time[1] - run.time[0])
    assert np.hypot(error[..., 0], error[..., 1]).max() <= TARGETS[name] * path


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "changes"),
    [("paper/example4", ["duration=2"]), ("paper/example5", []), ("stress/formation64", ["duration=1"])],
)
def test_wheels_hold_and_go_where_the_ideal_model_goes(name: str, changes: list[str]):
    """Robots ask most of their wheels in the beginning; one run is whole."""
    scenario = load(name, changes)
    outcome = simulate(scenario)
    recording, figures = outcome.recording, summary(outcome.recording)
    assert recording.outcome == "completed"
    assert outcome.summary["events"] == []
    for robot in figures["robots"].values():
        assert robot["gap_position_max"] <= 1e-3
        assert max(robot["peak_utilisation"], robot["peak_utilisation_predicted"]) <= 0.7
        assert robot["torque_saturation_share"] == 0
    if scenario.physics.robot_contact:
        assert smallest_separation(recording).distance > HULL
    if not changes:
        assert [said for said in outcome.summary["warnings"] if "followers end on a cycle about it" not in said] == []
        path = figures["robots"]["robot0"]["path_length"]
        for follower in figures["followers"].values():
            assert follower["late_position_error"] <= TARGETS[name] * path


# -- the wedge of 64 -------------------------------------------------------------------------------


def test_the_wedge_has_64_robots_on_six_levels_and_starts_apart():
    scenario = load("stress/formation64")
    network = Network.from_parents(scenario.parents, scenario.weights)
    assert [len(level) for level in network.levels] == [1, 3, 6, 9, 12, 15, 18]
    assert sum(len(parents) == 2 for parents in network.parents) == 40
    starts = [scenario.leader.start.pose[:2], *(follower.start.pose[:2] for follower in scenario.followers)]
    assert pdist(starts).min() > HULL
    assert scenario.physics.robot_contact


@pytest.mark.slow
def test_the_wedge_closes_up_without_a_collision_on_the_ideal_model():
    run = ideal_run("stress/formation64")
    distance = np.hypot(*np.moveaxis(run.variables["error"][:, 1:, :2], -1, 0))
    assert distance[0].max() > 0.3
    assert distance[int(0.85 * len(run.time)) :].max() < 0.05
    assert min(pdist(row).min() for row in run.variables["pose"][::10, :, :2]) > HULL
