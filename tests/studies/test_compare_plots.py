"""The figure of a comparison: what is in it, read back from its artists, and names that keep off each other."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon

from nhtrack import se2
from nhtrack.colours import ROOT, letter_colour, robot_colour
from nhtrack.plots.names import Path, name_paths
from nhtrack.plots.style import column_styled
from nhtrack.presentation.spread import spread
from nhtrack.recording import Recording
from nhtrack.studies.compare.figure import overlay
from nhtrack.studies.compare.result import room_of
from recordings import synthetic_recording

# Places are means of a few numbers from 0 to 1.
ROUNDING = 1e-12

LABELS = ("published", "universal", "kanayama", "samson", "look_ahead", "feedback_linearisation")


def several(laws: int, followers: int = 1, **changes: object) -> dict[str, Recording]:
    """Returns runs of one leader whose followers come to it on ways of their own."""
    runs = {}
    for k, label in enumerate(LABELS[:laws]):
        run = synthetic_recording(followers, samples=201, **changes)
        decay = np.exp(-run.time / (8.0 + 4 * k))[:, None]
        pose, told = run["pose"].values, run["leader_pose"].values
        pose[:, 1:, 0] += 0.5 * k * (decay - decay**2)
        error = np.asarray(se2.between(told, pose))
        error[..., 2] = np.asarray(se2.wrap(error[..., 2]))
        run["error"].values[:] = error
        runs[label] = run
    return runs


def drawn(runs: dict[str, Recording]) -> Figure:
    return overlay(runs, room_of(list(runs.values())))


def curves(axes: Axes, colour: str) -> list[Line2D]:
    return [
        line for line in axes.lines if to_hex(line.get_color()) == colour.lower() and len(line.get_xdata()) > 2
    ]


def darts(axes: Axes, colour: str) -> list[Polygon]:
    return [
        patch
        for patch in axes.patches
        if isinstance(patch, Polygon) and patch.get_fill() and to_hex(patch.get_facecolor()) == colour.lower()
    ]


@pytest.mark.parametrize(("laws", "followers"), [(6, 1), (2, 9)])
def test_every_law_is_drawn_where_it_was(laws: int, followers: int) -> None:
    runs = several(laws, followers)
    floor, position, heading = drawn(runs).axes[:3]
    for place, run in enumerate(runs.values(), start=1):
        colour = robot_colour(place)
        pose = run["pose"].values
        paths = curves(floor, colour)
        assert len(paths) == followers
        for follower, path in enumerate(paths, start=1):
            assert path.get_xydata() == pytest.approx(pose[:, follower, :2])
        ends = [dart.get_xy()[0] - dart.get_xy()[2] for dart in darts(floor, colour)]
        assert np.arctan2(*np.transpose(ends)[::-1]) == pytest.approx(np.asarray(se2.wrap(pose[-1, 1:, 2])))
        error = run["error"].values[:, 1:]
        (line,) = curves(position, colour)
        assert line.get_ydata() == pytest.approx(np.hypot(error[..., 0], error[..., 1]).max(axis=1))
        (line,) = curves(heading, colour)
        assert line.get_ydata() == pytest.approx(np.abs(error[..., 2]).max(axis=1))
    (leader,) = curves(floor, ROOT)
    assert leader.get_xydata() == pytest.approx(pose[:, 0, :2])
    assert all(axes.get_yscale() == "log" for axes in (position, heading))


@pytest.mark.slow
@pytest.mark.parametrize(("laws", "followers"), [(6, 1), (3, 3), (6, 15)])
def test_names_stand_beside_their_curves_and_not_upon_each_other(laws: int, followers: int) -> None:
    runs = several(laws, followers)
    figure = drawn(runs)
    figure.draw_without_rendering()
    for axes, extra in zip(figure.axes[:3], (["leader"], [], []), strict=True):
        texts = [text for text in axes.texts if text.get_text() in (*runs, *extra)]
        assert sorted(text.get_text() for text in texts) == sorted([*runs, *extra])
        boxes = [text.get_window_extent() for text in texts]
        for i, box in enumerate(boxes):
            assert not any(box.overlaps(other) for other in boxes[:i]), texts[i].get_text()
        for text in texts:
            place = 0 if text.get_text() == "leader" else 1 + list(runs).index(text.get_text())
            assert to_hex(text.get_color()) == letter_colour(robot_colour(place)).lower()
    frame = figure.axes[0].get_window_extent()
    for text in figure.axes[0].texts:
        box = text.get_window_extent()
        assert frame.x0 <= box.x0
        assert box.x1 <= frame.x1


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_name_stands_where_it_covers_no_line(side: float) -> None:
    """A line of its own so near to others, above or below, that its name would lie upon them."""
    axes = Figure().subplots()
    axes.set(xlim=(0, 1), ylim=(0, 1))
    x = np.linspace(0, 1, 50)
    own, *others = (np.stack([x, np.full(50, 0.5 + side * up)], axis=-1)[:, None] for up in (0.0, 0.02, 0.03))
    column_styled(name_paths)(axes, {"own": Path(own, "#000000")}, others)
    (name,) = axes.texts
    assert (name.get_position()[1] - 0.5) * side < 0


def test_a_law_that_diverged_is_drawn_as_far_as_it_makes_sense() -> None:
    """It neither widens the axes nor hides that it ended."""
    runs = several(2)
    plain = [axes.get_ylim() for axes in drawn(runs).axes[:3]]
    wild = synthetic_recording(1, samples=201, stop=20.0, outcome="diverged: state is not finite: ...")
    wild["pose"].values[40:, 1, :2] = 1e200
    wild["error"].values[40:, 1, :2] = 1e200
    runs["kanayama"] = wild
    figure = drawn(runs)
    assert [axes.get_ylim() for axes in figure.axes[:3]] == [pytest.approx(limits) for limits in plain]
    (path,) = curves(figure.axes[0], robot_colour(3))
    assert np.isfinite(path.get_xydata()[:40]).all()
    assert np.isnan(path.get_xydata()[40:]).all()
    (dart,) = darts(figure.axes[0], robot_colour(3))
    nose, notch = dart.get_xy()[[0, 2]]
    last = wild["pose"].values[39, 1, :2]
    assert np.array([0.20, 0.62]) / 0.82 @ np.array([nose, notch]) == pytest.approx(last)
    assert "kanayama, diverged" in [text.get_text() for text in figure.axes[1].texts]
    with mpl.rc_context({"savefig.dpi": 50}):
        figure.draw_without_rendering()  # warnings are errors: no axis may overflow


def test_units_are_the_robots_and_the_scenarios_are_told() -> None:
    figure = drawn(several(2))
    position, heading = figure.axes[1:3]
    assert heading.get_xlabel() == "robot time [s]"
    assert position.get_xlim() == heading.get_xlim() == (0.0, 80.0)
    assert "The scenario's 1 m is 4 mm and its 1 s is 4 s here." in " ".join(figure.get_supxlabel().split())


@pytest.mark.parametrize("step", [0.05, 0.1])
def test_names_are_moved_apart_and_no_further(step: float) -> None:
    random = np.random.default_rng(4)
    for count in (1, 2, 5, 9):
        for _ in range(20):
            places = random.uniform(0, 1, count) ** 3
            moved = spread(places, step)
            order = np.argsort(places)
            assert (np.diff(moved[order]) >= step - ROUNDING).all()
            assert moved.min() >= 0
            assert moved.max() <= 1
            # The least sum of squares: no single name, and no two that touch, can move nearer to their places.
            free = np.flatnonzero(np.abs(moved - places) > ROUNDING)
            for i in free:
                nearer = moved.copy()
                nearer[i] += 1e-3 * np.sign(places[i] - moved[i])
                touches = np.diff(np.sort(nearer)).min(initial=1.0) < step - ROUNDING
                assert touches, (places, moved)


def test_names_far_apart_stay_and_a_pair_shares_the_way() -> None:
    assert spread(np.array([0.7, 0.2]), 0.1) == pytest.approx([0.7, 0.2])
    assert spread(np.array([0.5, 0.5]), 0.1) == pytest.approx([0.45, 0.55])
    assert spread(np.array([0.0, 0.0, 0.9]), 0.1) == pytest.approx([0.0, 0.1, 0.9])
    assert spread(np.array([1.0, 1.0]), 0.1) == pytest.approx([0.9, 1.0])
