"""What the figures show of recordings made of formulas."""

from __future__ import annotations

import re
import subprocess
import sys

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon, Rectangle

from nhtrack import plots
from nhtrack.ground import Patch
from nhtrack.plots.marks import covered
from nhtrack.simulation.palette import FOLLOWERS, ROOT, robot_colour
from nhtrack.simulation.scene import SceneSpec
from recordings import HALF_SEPARATION, TORQUE_LIMIT, WHEEL_RADIUS, synthetic_recording

# [pt] A figure is laid out anew when it is drawn, after room was made for names: panels grow, so that room does too.
CLEARANCE = 1.0

EVERY_FIGURE = [plots.trajectories, plots.errors, plots.inputs, plots.slip]


def darts(axes, *, filled: bool = True) -> list[Polygon]:
    patches = [patch for patch in axes.patches if isinstance(patch, Polygon)]
    return [patch for patch in patches if (to_hex(patch.get_facecolor()) != "#ffffff") == filled]


def curves(axes, colour: str) -> list[np.ndarray]:
    """Returns the data (k, 2) of the lines of one colour."""
    return [line.get_xydata() for line in axes.lines if to_hex(line.get_color()) == colour.lower()]


def data_axes(figure: Figure) -> list:
    return [axes for axes in figure.axes if axes.get_ylabel() or axes.get_xlabel()]


@pytest.mark.parametrize("followers", [1, 3, 15, 63])
def test_every_panel_has_every_robot_where_it_is(followers):
    recording = synthetic_recording(followers, samples=201)
    figure = plots.trajectories(recording)
    assert len(figure.axes) == 4
    pose = recording["pose"].values[-1]
    glyphs = darts(figure.axes[3])
    assert len(glyphs) == followers + 1
    assert len(darts(figure.axes[3], filled=False)) == followers + 1
    for place, glyph in enumerate(glyphs):
        corners = glyph.get_xy()
        nose, notch = corners[0], corners[2]
        heading = np.arctan2(*(nose - notch)[::-1])
        assert np.cos(heading - pose[place, 2]) == pytest.approx(1.0, abs=1e-12)
        weights = np.array([0.20, 0.62]) / 0.82  # the axle midpoint lies between nose and notch
        assert weights @ np.array([nose, notch]) == pytest.approx(pose[place, :2] / recording.length_scale)
        assert to_hex(glyph.get_facecolor()) == robot_colour(place).lower()


def test_panels_stand_at_the_fractions():
    recording = synthetic_recording(1, samples=801)
    figure = plots.trajectories(recording, (0.25, 0.75))
    assert [axes.get_title("left") for axes in figure.axes] == [
        "(a) $t$ = 5 s  (25% of the run)",
        "(b) $t$ = 15 s  (75% of the run)",
    ]
    for axes, last in zip(figure.axes, (200, 600), strict=True):
        (leader,) = curves(axes, ROOT)
        assert leader[-1] == pytest.approx(recording["pose"].values[last, 0, :2] / 0.004)
        assert len(leader) == last + 1


def test_lengths_are_the_scenarios_and_axes_equal():
    recording = synthetic_recording(1, samples=201)
    figure = plots.trajectories(recording)
    for axes in figure.axes:
        assert axes.get_aspect() == 1.0
    assert figure.axes[2].get_xlabel() == "$x$ [m]"
    assert figure.axes[2].get_ylabel() == "$y$ [m]"
    assert "1 m is 4 mm" in figure.legends[0].get_title().get_text()
    (path,) = curves(figure.axes[3], FOLLOWERS[0])
    assert path == pytest.approx(recording["pose"].values[:, 1, :2] / 0.004)


def test_twin_is_dashed_and_only_where_there_is_one():
    def dashed(recording):
        return [line for line in plots.trajectories(recording).axes[3].lines if line.is_dashed()]

    recording = synthetic_recording(1, samples=201)
    (twin,) = dashed(recording)
    assert twin.get_xydata() == pytest.approx(recording["ideal_pose"].values[:, 1, :2] / 0.004)
    assert dashed(synthetic_recording(1, samples=201, backend="ideal")) == []


def test_errors_are_those_recorded():
    recording = synthetic_recording(1, samples=201)
    figure = plots.errors(recording)
    position, position_log, heading, heading_log, gap, _ = data_axes(figure)[:6]
    error = recording["error"].values[:, 1]
    for axes in (position, position_log):
        assert curves(axes, FOLLOWERS[0])[0][:, 1] == pytest.approx(np.hypot(error[:, 0], error[:, 1]))
    assert curves(heading, FOLLOWERS[0])[0][:, 1] == pytest.approx(error[:, 2])
    assert curves(heading_log, FOLLOWERS[0])[0][:, 1] == pytest.approx(np.abs(error[:, 2]))
    difference = recording["pose"].values[:, 1] - recording["ideal_pose"].values[:, 1]
    assert gap.get_ylabel() == "gap to ideal twin [µm]"  # 0.28 mm at most
    assert curves(gap, FOLLOWERS[0])[0][:, 1] == pytest.approx(1e6 * np.hypot(*difference.T[:2]))
    assert position_log.get_yscale() == heading_log.get_yscale() == "log"


def test_exact_tracking_leaves_a_gap_in_the_logarithm():
    recording = synthetic_recording(1, samples=101)
    recording["error"].values[50:, 1] = 0.0
    position_log = plots.errors(recording).axes[1]
    values = curves(position_log, FOLLOWERS[0])[0][:, 1]
    assert np.isnan(values[50:]).all()
    assert np.isfinite(values[:50]).all()


def test_motor_limit_is_drawn_where_known():
    def levels(recording):
        axes = plots.inputs(recording).axes[2]
        return sorted({float(line.get_ydata()[0]) for line in axes.lines if len(line.get_ydata()) == 2})

    recording = synthetic_recording(1, samples=101)
    assert levels(recording) == pytest.approx([-1e3 * TORQUE_LIMIT, 1e3 * TORQUE_LIMIT])
    del recording.dataset.attrs["torque_limit"]
    assert levels(recording) == []


def test_utilisation_shows_measured_predicted_and_limit():
    recording = synthetic_recording(1, samples=101)
    axes = plots.slip(recording).axes[3]
    measured = recording["friction_utilisation"].values.max(axis=-1)
    assert curves(axes, FOLLOWERS[0])[0][:, 1] == pytest.approx(measured[:, 1])
    predicted = recording["friction_utilisation_predicted"].values.max(axis=(1, 2))
    assert any(line.get_ydata() == pytest.approx(predicted) for line in axes.lines if len(line.get_ydata()) == 101)
    assert any(np.allclose(line.get_ydata(), 1.0) for line in axes.lines)
    assert any(text.get_text() == "wheels break away" for text in axes.texts)


@pytest.mark.parametrize(("slip", "unit"), [(2.0, "m/s"), (3e-2, "mm/s"), (4e-5, "µm/s"), (5e-9, "nm/s"), (0.0, "m/s")])
def test_slip_is_read_in_the_unit_that_suits_it(slip, unit):
    recording = synthetic_recording(1, samples=21)
    recording["lateral_slip"].values[:] = 0.0
    recording["lateral_slip"].values[5, 1] = slip
    axes = plots.slip(recording).axes[0]
    factor = {"m/s": 1.0, "mm/s": 1e3, "µm/s": 1e6, "nm/s": 1e9}[unit]
    assert axes.get_ylabel() == f"lateral slip [{unit}]"
    assert curves(axes, FOLLOWERS[0])[0][5, 1] == pytest.approx(factor * slip)


def test_ideal_backend_has_no_slip_to_show():
    figure = plots.slip(synthetic_recording(2, backend="ideal", samples=51))
    (axes,) = figure.axes
    assert "no slip" in axes.texts[0].get_text()


def test_crowd_is_drawn_as_its_range_and_median():
    recording = synthetic_recording(15, samples=51)
    axes = plots.errors(recording).axes[0]
    distance = np.hypot(*np.moveaxis(recording["error"].values[:, 1:, :2], -1, 0))
    (median,) = curves(axes, FOLLOWERS[0])
    assert median[:, 1] == pytest.approx(np.median(distance, axis=1))
    (band,) = axes.collections
    low, high = band.get_paths()[0].get_extents().get_points()
    assert (low[1], high[1]) == pytest.approx((distance.min(), distance.max()))
    assert [text.get_text() for text in plots.errors(recording).legends[0].get_texts()] == [
        "median of 15 followers",
        "their range",
    ]


@pytest.mark.parametrize("draw", EVERY_FIGURE)
@pytest.mark.parametrize("changes", [{}, {"backend": "ideal"}, {"stop": 21.0}, {"stop": 0.0}, {"length_scale": 1.0}])
@pytest.mark.parametrize("followers", [1, 9])
def test_every_axis_has_a_unit(draw, changes, followers):
    figure = draw(synthetic_recording(followers, samples=51, **changes))
    labelled = [axes for axes in figure.axes if axes.axison]
    labels = [label for axes in labelled for label in (axes.get_xlabel(), axes.get_ylabel()) if label]
    assert all(re.search(r"\[[^\]]+\]", label) for label in labels), labels
    for axes in labelled:  # every panel says what it shows, or shares the axis of one that does
        shared = axes.get_shared_y_axes().get_siblings(axes)
        assert any(other.get_ylabel() for other in shared) or draw is plots.trajectories


def test_interrupted_run_says_so():
    figure = plots.errors(synthetic_recording(1, samples=81, stop=21.0))
    assert figure.get_suptitle() == "example1  (interrupted)"
    assert plots.errors(synthetic_recording(1, samples=81)).get_suptitle() == "example1"


def test_scenario_time_stands_above_where_it_differs():
    figure = plots.errors(synthetic_recording(1, samples=51))
    assert figure.axes[-2].get_xlabel() == "robot time [s]"
    (top, *_) = figure.axes[0].child_axes
    assert top.get_xlabel() == "scenario time [s]"
    unscaled = plots.errors(synthetic_recording(1, samples=51, time_scale=1.0))
    assert unscaled.axes[0].child_axes == []
    assert unscaled.axes[-2].get_xlabel() == "time [s]"


# -- events -----------------------------------------------------------------------------------------


def with_slides(followers: int, slides: dict[int, slice], **changes):
    """Returns a run of 80 s in which robots, by their places, slide during some of its 801 rows."""
    recording = synthetic_recording(followers, **changes)
    for place, rows in slides.items():
        recording["friction_utilisation"].values[rows, place, 0] = 1.0
        recording["longitudinal_slip"].values[rows, place, 0] = 0.5
    return recording


def shades(axes) -> list[tuple[float, float]]:
    """Returns start and end of the shaded spans of a panel."""
    spans = [patch for patch in axes.patches if isinstance(patch, Rectangle)]
    return [(span.get_x(), span.get_x() + span.get_width()) for span in spans]


def bars(axes) -> list[tuple[str, float, float]]:
    """Returns colour, start and end of the bars along a panel's upper edge."""
    lines = [line for line in axes.lines if line.get_marker() == "o"]
    return [(to_hex(line.get_color()), *map(float, line.get_xdata())) for line in lines]


def names(axes) -> list[str]:
    return [text.get_text() for text in axes.texts if text.get_text() != "wheels break away"]


@pytest.mark.parametrize("draw", [plots.slip, plots.errors])
def test_a_run_without_events_has_no_marks(draw):
    figure = draw(synthetic_recording(3, samples=101))
    assert all(shades(axes) == bars(axes) == names(axes) == [] for axes in figure.axes)


def test_slides_are_shaded_named_and_say_whose_they_are():
    recording = with_slides(3, {1: slice(101, 201), 3: slice(151, 301)})
    lateral, longitudinal, load, utilisation = plots.slip(recording).axes[:4]
    for axes in (lateral, longitudinal):
        assert shades(axes) == [pytest.approx((10.0, 30.0))]
        first, second = bars(axes)
        assert first == (robot_colour(1).lower(), pytest.approx(10.0), pytest.approx(20.0))
        assert second == (robot_colour(3).lower(), pytest.approx(15.0), pytest.approx(30.0))
        assert names(axes) == ["slipping"]
        assert [text.xy[0] for text in axes.texts] == [pytest.approx(15.0)]  # where the longest begins
    assert names(load) == names(utilisation) == []


def test_the_errors_show_the_events_of_those_that_have_them():
    """The root tracks nothing: what happens to it is seen in the figure of slip."""
    panels = plots.errors(with_slides(2, {0: slice(501, 601), 2: slice(101, 201)})).axes[:6]
    assert all(shades(axes) == [pytest.approx((10.0, 20.0))] for axes in panels)
    assert [names(axes) for axes in panels] == [["slipping"], *[[]] * 5]
    assert all(bars(axes) == [] for axes in panels)


def test_a_crowd_is_shaded_as_one():
    slides = {place: slice(1 + 10 * place, 11 + 10 * place) for place in range(20, 40)}
    figure = plots.slip(with_slides(63, slides))
    assert shades(figure.axes[0]) == [pytest.approx((20.0, 40.0))]
    assert bars(figure.axes[0]) == []
    assert names(figure.axes[0]) == ["slipping: 20 robots"]
    assert names(plots.slip(with_slides(63, {5: slice(100, 200)})).axes[0]) == ["slipping: 1 robot"]


def test_every_kind_has_its_panel():
    end = {"diverged_robot": "f1", "diverged_time": 80.1, "diverged_reason": "tipped over"}
    size = {"wheel_radius": WHEEL_RADIUS, "half_separation": HALF_SEPARATION, "no_load_speed": 30.0}
    recording = synthetic_recording(2, samples=801, **end, **size)
    recording["wheel_load"].values[700:750, 1, 1] = 0.0
    recording["tilt"].values[720:, 1] = 0.2
    recording["pose"].values[101:201, 2] = recording["pose"].values[100, 2]
    recording["wheel_speed"].values[101:201, 2] = 30.0
    recording.dataset["torque_saturation"] = 0.0 * recording["wheel_torque"]
    lateral, longitudinal, load, utilisation = plots.slip(recording).axes[:4]
    assert names(lateral) == names(longitudinal) == ["tipped"]
    assert names(load) == ["wheel off the floor", "leaning", "tipped"]
    assert names(utilisation) == ["stuck", "tipped"]
    assert shades(utilisation) == [pytest.approx((10.0, 20.0))]
    assert shades(load) == [pytest.approx((69.9, 80.0))]
    for axes in (lateral, longitudinal, load, utilisation):  # the last row is at 80 s: the panel ends there
        assert any(list(line.get_xdata()) == [80.0, 80.0] for line in axes.lines)


@pytest.mark.parametrize("place", [0, 3])
def test_names_and_bars_stand_above_the_curves(place):
    recording = with_slides(3, {place: slice(1, 400), 2: slice(200, 600)})
    recording["lateral_slip"].values[:, place] = 1.0
    figure = plots.slip(recording)
    figure.canvas.draw()
    for axes, highest in zip(figure.axes[:2], (1.0, 0.5), strict=True):
        factor = 1e3 if "[mm/s]" in axes.get_ylabel() else 1.0
        top_of_curves = axes.transData.transform((0.0, factor * highest))[1]
        lowest = min(text.get_window_extent().y0 for text in axes.texts)
        assert lowest > top_of_curves + CLEARANCE * figure.dpi / 72


def test_covered_time_counts_once():
    assert covered([]) == []
    assert covered([(3.0, 4.0), (0.0, 1.0), (0.5, 2.0), (2.0, 2.5), (3.2, 3.5)]) == [(0.0, 2.5), (3.0, 4.0)]


def test_patches_and_slope_are_drawn_in_the_scenarios_units():
    recording = synthetic_recording(1, samples=201)
    x, y = recording["pose"].values[-1, 1, :2]
    patches = (Patch(0.05, disc=(x, y, 0.5)), Patch(1.5, rectangle=(90.0, 91.0, 90.0, 91.0)))
    scene = SceneSpec(recording.robots, friction=0.8, patches=patches, slope=0.1, uphill=np.pi / 2)
    recording.dataset.attrs["scene"] = scene.to_json()
    axes = plots.trajectories(recording, (1.0,)).axes[0]
    (disc,) = (each for each in axes.get_children() if isinstance(each, Circle))
    assert disc.center == pytest.approx((x / 0.004, y / 0.004))
    assert disc.radius == pytest.approx(0.5 / 0.004)
    said = [text.get_text() for text in axes.texts]
    assert "friction\n0.05" in said
    assert "friction\n1.5" not in said  # out of the picture
    assert "uphill, 5.73°" in said


def test_style_ends_with_the_figure():
    before = dict(mpl.rcParams)
    plots.errors(synthetic_recording(1, samples=21))
    assert dict(mpl.rcParams) == before


def test_recording_is_left_as_it_was():
    recording = synthetic_recording(1, samples=21)
    before = recording.dataset.copy(deep=True)
    for draw in EVERY_FIGURE:
        draw(recording)
    assert recording.dataset.identical(before)


def test_pyplot_is_never_imported():
    script = "import sys, nhtrack.plots; print('matplotlib.pyplot' in sys.modules, 'mujoco' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120, check=True)
    assert done.stdout.strip() == "False False"


def test_colours_are_all_different_and_the_roots_its_own():
    assert len({ROOT, *FOLLOWERS}) == len(FOLLOWERS) + 1
    assert robot_colour(0) == ROOT
    assert ROOT not in {robot_colour(place) for place in range(1, 64)}
