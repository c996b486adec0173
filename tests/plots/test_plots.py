"""What the figures show of recordings made of formulas."""

from __future__ import annotations

import json
import re
from functools import cache

import numpy as np
import pytest
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, Polygon, Rectangle
from matplotlib.text import Text

from nhtrack import se2
from nhtrack.colours import FOLLOWERS, PAPER, ROOT, ink_on, letter_colour, robot_colour
from nhtrack.effects.patches import Patches
from nhtrack.effects.slope import Slope
from nhtrack.ground import Patch
from nhtrack.plots import run_figures
from nhtrack.plots.event_marks import covered
from nhtrack.plots.figures.errors import errors
from nhtrack.plots.figures.gap import gap
from nhtrack.plots.figures.graph import graph
from nhtrack.plots.figures.inputs import inputs
from nhtrack.plots.figures.slip import slip
from nhtrack.plots.figures.trajectories import trajectories
from nhtrack.plots.margins import Numbers
from nhtrack.presentation.numbers import common_prefix
from nhtrack.report.panels import make_panels
from nhtrack.simulation.scene import SceneSpec
from recordings import HALF_SEPARATION, TORQUE_LIMIT, WHEEL_RADIUS, synthetic_recording

CLEARANCE = 1.0  # [pt] between curves and the names and bars of events
HAIR = 2.0  # [pixels at 100 dpi] Boxes of letters are rounded up to pixels, and have some air.

# [rad] Darts are of points a hundredth of a robot's way apart in the panel: rounding of coordinates of a few metres.
ROUNDING = 1e-10

EVERY_FIGURE = [*run_figures().values()]


# Runs that every figure is drawn of: followers, and what is particular.
RUNS = {
    "diverged": (6, {"outcome": "diverged: " + "far too fast " * 8}),
    "crowd": (15, {"outcome": "diverged: " + "far too fast " * 8}),
    "ideal": (2, {"backend": "ideal"}),
    "first row": (1, {"stop": 0.0}),
}


@cache
def figure_of(draw, run) -> Figure | None:
    """Returns a figure of one of `RUNS`, drawn without pixels; those of what an ideal run lacks are None."""
    followers, changes = RUNS[run]
    figure = draw(synthetic_recording(followers, samples=101, **changes))
    assert (figure is None) == (run == "ideal" and draw in (slip, gap))
    if figure is not None:
        figure.draw_without_rendering()
    return figure


def darts(axes, *, filled: bool = True) -> list[Polygon]:
    patches = [patch for patch in axes.patches if isinstance(patch, Polygon)]
    return [patch for patch in patches if (to_hex(patch.get_facecolor()) != "#ffffff") == filled]


def curves(axes, colour: str) -> list[np.ndarray]:
    """Returns the data (k, 2) of the lines of one colour."""
    return [line.get_xydata() for line in axes.lines if to_hex(line.get_color()) == colour.lower()]


def drawn(axes, colour: str) -> list[np.ndarray]:
    """Returns the data (t, 2) of the curves of one colour, not the lines from their ends to their names."""
    return [curve for curve in curves(axes, colour) if len(curve) > 2]


def names(axes) -> list[str]:
    """Returns the names beside a panel."""
    return [text.get_text() for text in axes.texts if text.get_transform() == axes.transAxes]


def note(figure: Figure) -> str:
    """Returns the note below a figure, in one line."""
    return " ".join(figure.get_supxlabel().split())


@pytest.mark.parametrize("followers", [1, 15])
def test_every_panel_has_every_robot_where_it_is(followers):
    recording = synthetic_recording(followers, samples=201)
    figure = trajectories(recording)
    assert len(figure.axes) == 4
    pose = recording["pose"].values[-1]
    glyphs = darts(figure.axes[3])
    assert len(glyphs) == followers + 1
    assert len(darts(figure.axes[3], filled=False)) == followers + 1
    for place, glyph in enumerate(glyphs):
        corners = glyph.get_xy()
        nose, notch = corners[0], corners[2]
        heading = np.arctan2(*(nose - notch)[::-1])
        assert np.cos(heading - pose[place, 2]) == pytest.approx(1.0, abs=ROUNDING)
        weights = np.array([0.20, 0.62]) / 0.82  # the axle midpoint lies between nose and notch
        assert weights @ np.array([nose, notch]) == pytest.approx(pose[place, :2])
        assert to_hex(glyph.get_facecolor()) == robot_colour(place).lower()


def test_panels_stand_at_the_fractions():
    recording = synthetic_recording(1, samples=801)
    figure = trajectories(recording, (0.25, 0.75))
    assert [axes.get_title("left") for axes in figure.axes] == [
        "(a) t = 20 s  (25%)",
        "(b) t = 60 s  (75%)",
    ]
    for axes, last in zip(figure.axes, (200, 600), strict=True):
        (leader,) = curves(axes, ROOT)
        assert leader[-1] == pytest.approx(recording["pose"].values[last, 0, :2])
        assert len(leader) == last + 1


@pytest.mark.slow
def test_a_scaled_scenario_says_what_its_metre_and_its_second_are():
    figures = {draw: draw(synthetic_recording(1, samples=51)) for draw in (trajectories, errors, gap)}
    for figure in figures.values():
        assert "The scenario's 1 m is 4 mm and its 1 s is 4 s here." in note(figure)
    assert figures[errors].axes[-1].get_xlabel() == "robot time [s]"
    unscaled = errors(synthetic_recording(1, samples=51, length_scale=1.0, time_scale=1.0))
    assert "scenario" not in note(unscaled)
    assert unscaled.axes[-1].get_xlabel() == "time [s]"


def test_robots_are_to_scale_where_they_can_be_seen():
    """The whole run goes 6 m; in its first thousandth the robots hardly move."""
    recording = synthetic_recording(1, samples=8001)
    recording["pose"].values[..., :2] *= 0.02
    recording.dataset.attrs.update(wheel_radius=WHEEL_RADIUS, half_separation=HALF_SEPARATION)
    (axes,) = trajectories(recording, (1.0,)).axes
    shapes = [patch.get_xy()[:-1] for patch in axes.patches]
    assert len(shapes) == 2 * 2 * 3  # robots, start and end, body and two wheels
    for place, pose in enumerate(recording["pose"].values[-1]):
        _, *wheels = shapes[6 + 3 * place : 9 + 3 * place]
        for side, wheel in zip((1.0, -1.0), wheels, strict=True):
            local = se2.act(se2.inverse(pose)[None], wheel)
            assert np.ptp(local[:, 0]) == pytest.approx(2 * WHEEL_RADIUS)
            assert local.mean(axis=0) == pytest.approx([0.0, side * HALF_SEPARATION], abs=ROUNDING)
    recording["pose"].values[..., :2] *= 50
    (axes,) = trajectories(recording, (1.0,)).axes
    assert len(axes.patches) == 2 * 2
    assert "wheels 86 mm apart" in note(axes.figure)


def test_twin_is_dashed_and_only_where_there_is_one():
    def dashed(recording):
        return [line for line in trajectories(recording).axes[3].lines if line.is_dashed()]

    recording = synthetic_recording(1, samples=201)
    (twin,) = dashed(recording)
    assert twin.get_xydata() == pytest.approx(recording["ideal_pose"].values[:, 1, :2])
    assert dashed(synthetic_recording(1, samples=201, backend="ideal")) == []


def test_errors_are_those_recorded():
    recording = synthetic_recording(1, samples=201)
    position, position_log, heading, heading_log = errors(recording).axes
    error = recording["error"].values[:, 1]
    for axes in (position, position_log):
        assert drawn(axes, FOLLOWERS[0])[0][:, 1] == pytest.approx(np.hypot(error[:, 0], error[:, 1]))
    assert drawn(heading, FOLLOWERS[0])[0][:, 1] == pytest.approx(error[:, 2])
    assert drawn(heading_log, FOLLOWERS[0])[0][:, 1] == pytest.approx(np.abs(error[:, 2]))
    assert position_log.get_yscale() == heading_log.get_yscale() == "log"
    assert position.get_yscale() == heading.get_yscale() == "linear"


def test_no_line_is_drawn_across_the_antipode():
    recording = synthetic_recording(1, samples=51)
    recording["error"].values[:, 1, 2] = np.where(np.arange(51) < 25, 3.0, -3.0)
    (curve,) = drawn(errors(recording).axes[2], FOLLOWERS[0])
    assert np.flatnonzero(np.isnan(curve[:, 1])).tolist() == [25]


def test_gap_is_between_the_recorded_poses():
    recording = synthetic_recording(2, samples=201)
    position, heading = gap(recording).axes
    difference = recording["pose"].values - recording["ideal_pose"].values
    assert position.get_ylabel() == "position gap [µm]"  # 0.28 mm at most
    assert heading.get_ylabel() == "heading gap [µrad]"
    for place in range(3):
        (curve,) = drawn(position, robot_colour(place))
        assert curve[:, 1] == pytest.approx(1e6 * np.hypot(*difference[:, place, :2].T))
        (curve,) = drawn(heading, robot_colour(place))
        angle = 1e6 * np.abs(difference[:, place, 2])
        assert curve[angle > 0, 1] == pytest.approx(angle[angle > 0])
    assert position.get_yscale() == heading.get_yscale() == "log"
    assert names(position) == names(heading) == ["leader", "f1", "f2"]


def test_a_root_without_wheels_is_not_named():
    """A virtual root is exactly where its twin is, and has no wheels to slip."""
    recording = synthetic_recording(1, samples=101)
    recording["ideal_pose"].values[:, 0] = recording["pose"].values[:, 0]
    for name in ("lateral_slip", "longitudinal_slip", "wheel_load", "friction_utilisation_predicted"):
        recording[name].values[:, 0] = np.nan
    assert [names(axes) for axes in gap(recording).axes] == [["follower"]] * 2
    figure = slip(recording)
    assert [names(axes) for axes in figure.axes[:3]] == [["follower"]] * 3
    predicted = recording["friction_utilisation_predicted"].values[:, 1].max(axis=-1)
    long = [line.get_ydata() for line in figure.axes[3].lines if len(line.get_ydata()) == 101]
    assert any(np.allclose(values, predicted) for values in long)


def test_motor_limit_is_drawn_where_torques_come_near_it_and_told_elsewhere():
    def levels(recording):
        axes = inputs(recording).axes[2]
        told = [text.get_text() for text in axes.texts if text.get_text() not in recording.robots]
        flat = [line for line in axes.lines if list(line.get_xdata()) == [0, 1]]
        return sorted(float(line.get_ydata()[0]) for line in flat), told

    recording = synthetic_recording(1, samples=101)
    assert levels(recording) == ([], ["motor limit: 30 mN m"])
    recording["wheel_torque"].values[7, 1, 0] = -0.5 * TORQUE_LIMIT
    assert levels(recording) == (pytest.approx([-1e3 * TORQUE_LIMIT, 1e3 * TORQUE_LIMIT]), ["motor limit"])
    del recording.dataset.attrs["torque_limit"]
    assert levels(recording) == ([], [])


def test_utilisation_shows_measured_predicted_and_limit():
    recording = synthetic_recording(1, samples=101)
    axes = slip(recording).axes[3]
    measured = recording["friction_utilisation"].values.max(axis=-1)
    assert curves(axes, FOLLOWERS[0])[0][:, 1] == pytest.approx(measured[:, 1])
    predicted = recording["friction_utilisation_predicted"].values.max(axis=(1, 2))
    assert any(line.get_ydata() == pytest.approx(predicted) for line in axes.lines if len(line.get_ydata()) == 101)
    assert any(np.allclose(line.get_ydata(), 1.0) for line in axes.lines)
    assert any(text.get_text() == "wheels break away" for text in axes.texts)


@pytest.mark.parametrize(
    ("largest", "factor", "prefix"),
    [(2.0, 1.0, ""), (3e-2, 1e3, "m"), (4e-5, 1e6, "µ"), (5e-9, 1e9, "n"), (0.0, 1.0, ""), (np.nan, 1.0, "")],
)
def test_values_are_read_with_the_prefix_that_suits_them(largest, factor, prefix):
    assert common_prefix(np.array([0.0, -largest])) == (factor, prefix)


def test_ideal_backend_has_neither_slip_nor_gap_nor_torques():
    assert figure_of(slip, "ideal") is figure_of(gap, "ideal") is None
    assert len(figure_of(inputs, "ideal").axes) == 2


def test_crowd_is_drawn_as_its_median_and_its_worst():
    recording = synthetic_recording(15, samples=51)
    figure = errors(recording)
    distance = np.hypot(*np.moveaxis(recording["error"].values[:, 1:, :2], -1, 0))
    median, worst = drawn(figure.axes[0], FOLLOWERS[0])
    assert median[:, 1] == pytest.approx(np.median(distance, axis=1))
    assert worst[:, 1] == pytest.approx(distance.max(axis=1))
    (band,) = figure.axes[0].collections
    low, high = band.get_paths()[0].get_extents().get_points()
    assert (low[1], high[1]) == pytest.approx((np.median(distance, axis=1).min(), distance.max()))
    assert [sorted(names(axes)) for axes in figure.axes] == [
        ["median", "worst"], ["median", "worst"], ["highest", "lowest", "median"], ["median", "worst"],
    ]  # fmt: skip
    assert "15 followers" in note(figure)


def test_curves_are_named_where_they_end():
    figure = figure_of(errors, "diverged")
    for axes in figure.axes:
        texts = [text for text in axes.texts if re.fullmatch(r"f\d", text.get_text())]
        assert [text.get_text() for text in texts] == [f"f{k}" for k in range(1, 7)]
        colours = [letter_colour(robot_colour(k)).lower() for k in range(1, 7)]
        assert [to_hex(text.get_color()) for text in texts] == colours
        boxes = [text.get_window_extent() for text in texts]
        assert all(box.x0 > axes.get_window_extent().x1 and box.x1 <= figure.bbox.x1 for box in boxes)
        heights = sorted((box.y0 + box.y1) / 2 for box in boxes)
        assert np.diff(heights).min() > 6.5 * figure.dpi / 72  # lines of letters of 6.5 pt


@pytest.mark.parametrize(
    ("places", "texts"),
    [
        ([-1.0, 0.0, 1.0], ["-1", "0", "1"]),
        ([0.0, 0.5, 1.0], ["0.0", "0.5", "1.0"]),
        ([-0.0025, 0.0, 0.0025], ["-0.0025", "0.0000", "0.0025"]),
        ([0.0, 2e-5, 4e-5], ["0", "2x10⁻⁵", "4x10⁻⁵"]),
        ([0.0, 10000.0, 25000.0], ["0", "1.0x10⁴", "2.5x10⁴"]),
        ([-0.1, 0.0, 0.1, 0.2 + 1e-16], ["-0.1", "0.0", "0.1", "0.2"]),
        ([], []),
    ],
)
def test_numbers_have_the_decimals_of_their_steps(places, texts):
    letters = str.maketrans({"\N{MINUS SIGN}": "-", "\N{MULTIPLICATION SIGN}": "x"})
    assert [text.translate(letters) for text in Numbers().format_ticks(places)] == texts


@pytest.mark.slow
def test_dollars_in_names_are_letters():
    recording = synthetic_recording(2, samples=51, outcome="diverged: $x$")
    recording.dataset = recording.dataset.assign_coords(robot=["$a", "b$c$", "$\\nonsense{$"])
    recording.dataset.attrs["parents"] = json.dumps({"$a": [], "b$c$": ["$a"], "$\\nonsense{$": ["$a"]})
    written = [text.get_text() for draw in EVERY_FIGURE for text in draw(recording).findobj(Text)]
    assert {"\\$a", "b\\$c\\$", "example1: diverged: \\$x\\$"} <= set(written)
    assert not [text for text in written if re.search(r"(?<!\\)\$", text)]  # such begin a formula


@pytest.mark.parametrize("colour", [ROOT, *FOLLOWERS])
def test_ink_on_a_colour_can_be_read(colour):
    def luminance(shown):
        rgb = np.array(to_rgb(shown))
        return np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4) @ [0.2126, 0.7152, 0.0722]

    def contrast(one, other):
        dark, light = sorted(luminance(each) for each in (one, other))
        return (light + 0.05) / (dark + 0.05)

    assert contrast(colour, ink_on(colour)) >= 4.2  # WCAG asks 4.5 of small letters and 3 of bold ones
    assert contrast(letter_colour(colour), PAPER) >= 4.5


def in_graph(parents):
    """Returns circles' centres by robots, their radius, the arrows and the figure of a communication graph [in]."""
    recording = synthetic_recording(len(parents) - 1, samples=11)
    recording.dataset = recording.dataset.assign_coords(robot=list(parents))
    recording.dataset.attrs["parents"] = json.dumps(parents)
    figure = graph(recording)
    circles = [patch for patch in figure.axes[0].patches if isinstance(patch, Circle)]
    arrows = [patch for patch in figure.axes[0].patches if isinstance(patch, FancyArrowPatch)]
    return dict(zip(parents, (circle.center for circle in circles), strict=True)), circles[0].radius, arrows, figure


GRAPHS = {
    "pair": {"leader": [], "follower": ["leader"]},
    "five": {"r0": [], "r1": ["r0"], "r2": ["r0"], "r3": ["r1", "r2"], "r4": ["r0", "r3"]},
    "star": {"r0": []} | {f"r{k}": ["r0"] for k in range(1, 65)},
    "chain": {"r0": []} | {f"r{k}": [f"r{k - 1}"] for k in range(1, 26)},
    "tree": {"r0": []} | {f"r{k}": [f"r{(k - 1) // 3}"] for k in range(1, 41)},
}


@pytest.mark.slow
@pytest.mark.parametrize("name", GRAPHS)
def test_graph_can_be_read(name):
    parents = GRAPHS[name]
    spots, radius, arrows, figure = in_graph(parents)
    assert len(arrows) == sum(map(len, parents.values()))
    places = np.array(list(spots.values()))
    apart = np.linalg.norm(places[:, None] - places, axis=-1) + 10 * np.eye(len(places))
    assert apart.min() > 2 * radius
    axes = figure.axes[0]
    low, high = np.transpose([axes.get_xlim(), axes.get_ylim()])
    assert (places - radius >= low).all()
    assert (places + radius <= high).all()
    assert tuple(high - low) == pytest.approx(tuple(figure.get_size_inches()))  # a unit is an inch
    assert min(text.get_fontsize() for text in axes.texts) >= 4.5
    for parent, child in ((parent, child) for child, others in parents.items() for parent in others):
        assert name == "chain" or name in ("star", "tree") or spots[parent][0] < spots[child][0]


def test_interrupted_run_says_so():
    assert figure_of(errors, "first row").get_suptitle() == "example1: interrupted"
    assert figure_of(errors, "ideal").get_suptitle() == ""


@pytest.mark.slow
@pytest.mark.parametrize("draw", EVERY_FIGURE)
@pytest.mark.parametrize("run", RUNS)
def test_figures_are_a_column_wide_and_nothing_is_cut_off(draw, run):
    figure = figure_of(draw, run)
    if figure is None:
        return
    assert figure.get_figwidth() == 3.5
    boxes = [axes.get_tightbbox() for axes in figure.axes] + [text.get_window_extent() for text in figure.texts]
    for box in boxes:
        assert (box.min >= figure.bbox.min - HAIR).all()
        assert (box.max <= figure.bbox.max + HAIR).all()
    for text in figure.findobj(Text):
        assert text.get_fontsize() >= (6.0 if draw is not graph else 5.0), text


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


def said(axes) -> list[str]:
    """Returns what is written in a panel of events."""
    beside = names(axes)
    return [text.get_text() for text in axes.texts if text.get_text() not in ("wheels break away", *beside)]


def test_slides_are_shaded_named_and_say_whose_they_are():
    recording = with_slides(3, {1: slice(101, 201), 3: slice(151, 301)})
    lateral, longitudinal, load, utilisation = slip(recording).axes[:4]
    for axes in (lateral, longitudinal):
        assert shades(axes) == [pytest.approx((10.0, 30.0))]
        first, second = bars(axes)
        assert first == (robot_colour(1).lower(), pytest.approx(10.0), pytest.approx(20.0))
        assert second == (robot_colour(3).lower(), pytest.approx(15.0), pytest.approx(30.0))
        assert said(axes) == ["slipping"]
        (name,) = [text for text in axes.texts if text.get_text() == "slipping"]
        assert name.xy[0] == pytest.approx(15.0)  # where the longest begins
    assert said(load) == said(utilisation) == []


def test_the_errors_show_the_events_of_those_that_have_them():
    """The root tracks nothing: what happens to it is seen in the figure of slip."""
    panels = errors(with_slides(2, {0: slice(501, 601), 2: slice(101, 201)})).axes
    assert all(shades(axes) == [pytest.approx((10.0, 20.0))] for axes in panels)
    assert [said(axes) for axes in panels] == [["slipping"], *[[]] * 3]
    assert all(bars(axes) == [] for axes in panels)


def test_a_crowd_is_shaded_as_one():
    slides = {place: slice(1 + 10 * place, 11 + 10 * place) for place in range(20, 40)}
    figure = slip(with_slides(63, slides))
    assert shades(figure.axes[0]) == [pytest.approx((20.0, 40.0))]
    assert bars(figure.axes[0]) == []
    assert said(figure.axes[0]) == ["slipping: 20 robots"]
    assert said(slip(with_slides(63, {5: slice(100, 200)})).axes[0]) == ["slipping: 1 robot"]


def test_every_kind_has_its_panel():
    end = {"diverged_robot": "f1", "diverged_time": 80.1, "diverged_reason": "tipped over"}
    size = {"wheel_radius": WHEEL_RADIUS, "half_separation": HALF_SEPARATION, "no_load_speed": 30.0}
    recording = synthetic_recording(2, samples=801, **end, **size)
    recording["wheel_load"].values[700:750, 1, 1] = 0.0
    recording["wheel_clearance"].values[700:750, 1, 1] = WHEEL_RADIUS
    touch = np.full((801, 3, 3, 5), np.nan)
    touch[400:501, 1, 0] = 2, 0.1, 0.5, 0.3, 0.001
    recording.dataset["touch"] = ("time", "robot", "touch", "touch_component"), touch
    recording["tilt"].values[720:, 1] = 0.2
    recording["pose"].values[101:201, 2] = recording["pose"].values[100, 2]
    recording["wheel_speed"].values[101:201, 2] = 30.0
    recording.dataset["torque_saturation"] = 0.0 * recording["wheel_torque"]
    lateral, longitudinal, load, utilisation = slip(recording).axes[:4]
    assert said(lateral) == said(longitudinal) == ["touched", "tipped"]
    assert shades(lateral) == shades(longitudinal) == [pytest.approx((39.9, 50.0))]
    assert len(bars(lateral)) == 2  # one for each of the two robots
    assert "Robots touch first at 39.9 s; twins pass through" in note(gap(recording))
    for line in gap(recording).axes[0].lines[:3]:
        assert line.get_xdata()[np.isfinite(line.get_ydata())].max() == pytest.approx(39.9)
    titles = {panel["key"]: panel["title"] for panel in make_panels(recording, 6)}
    assert titles["gap"] == "distance from the twin; robots touch first at 39.9 s, twins pass through"
    assert said(load) == ["wheel off the floor", "leaning", "tipped"]
    assert said(utilisation) == ["stuck", "tipped"]
    assert shades(utilisation) == [pytest.approx((10.0, 20.0))]
    assert shades(load) == [pytest.approx((69.9, 80.0))]
    for axes in (lateral, longitudinal, load, utilisation):  # the last row is at 80 s: the panel ends there
        assert any(list(line.get_xdata()) == [80.0, 80.0] for line in axes.lines)


@pytest.mark.slow
@pytest.mark.parametrize("place", [0, 3])
def test_names_and_bars_stand_above_the_curves(place):
    recording = with_slides(3, {place: slice(1, 400), 2: slice(200, 600)})
    recording["lateral_slip"].values[:, place] = 1.0
    figure = slip(recording)
    figure.canvas.draw()
    for axes, highest in zip(figure.axes[:2], (1.0, 0.5), strict=True):
        factor = 1e3 if "[mm/s]" in axes.get_ylabel() else 1.0
        top_of_curves = axes.transData.transform((0.0, factor * highest))[1]
        lowest = min(text.get_window_extent().y0 for text in axes.texts if text.get_text() in said(axes))
        assert lowest > top_of_curves + CLEARANCE * figure.dpi / 72


def test_covered_time_counts_once():
    assert covered([]) == []
    assert covered([(3.0, 4.0), (0.0, 1.0), (0.5, 2.0), (2.0, 2.5), (3.2, 3.5)]) == [(0.0, 2.5), (3.0, 4.0)]


def test_patches_and_slope_are_drawn_and_named():
    recording = synthetic_recording(1, samples=201)
    x, y = recording["pose"].values[-1, 1, :2]
    patches = (Patch(0.05, disc=(x, y, 0.5)), Patch(1.5, rectangle=(90.0, 91.0, 90.0, 91.0)))
    scene = SceneSpec(recording.robots, friction=0.8, effects=(Patches(patches), Slope(0.1, np.pi / 2)))
    recording.dataset.attrs["scene"] = scene.to_json()
    figure = trajectories(recording, (1.0,))
    axes = figure.axes[0]
    (disc,) = (each for each in axes.get_children() if isinstance(each, Circle))
    assert disc.center == pytest.approx((x, y))
    assert disc.radius == pytest.approx(0.5)
    written = [text.get_text() for text in axes.texts]
    assert "friction 0.05" in written
    assert "friction 1.5" not in written  # out of the picture
    assert "Arrow: uphill, 5.73°." in note(figure)
