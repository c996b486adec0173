"""What the figures of a campaign show of tables made of random numbers."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from campaign_tables import FAMILIES, HEADING_LIMIT, LAWS, POSITION_LIMIT, campaign_cells, campaign_starts
from nhtrack.colours import ROOT
from nhtrack.plots.style import styled
from nhtrack.presentation.numbers import percent
from nhtrack.studies.campaign.plots import (
    files,
    late_errors,
    save_campaign_figures,
    settling,
    share_map,
    start_map,
)

DART_LENGTH = 1.0  # nose to tail of a dart, in units of its size
ON_CANVAS = 0.5  # [px] letters may reach over the edge: the extent of a letter is that of its box, rounded


def texts(axes) -> list[str]:
    return [text.get_text() for text in axes.texts]


def glyphs(axes, colour: str | None = None) -> list[np.ndarray]:
    """Returns the corners of the darts and dots of a panel but for the leader's, of one colour or of any."""
    found = []
    for collection in axes.collections:
        if isinstance(collection, PolyCollection) and collection.get_zorder() < 5:
            colours = np.broadcast_to(collection.get_facecolor(), (len(collection.get_paths()), 4))
            for path, own in zip(collection.get_paths(), colours, strict=True):
                if colour is None or to_hex(own) == colour.lower():
                    found.append(path.vertices[:-1])
    return found


def luminance(colour) -> float:
    """Returns the relative luminance of an sRGB colour (WCAG 2.2)."""
    channels = np.array(mpl.colors.to_rgb(colour))
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


# -- per cent ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("count", "of", "said"),
    [
        (0, 50, "0"), (50, 50, "100"), (49, 50, "98"), (1, 3, "33.3"), (9999, 10_000, "99.99"), (1, 10_000, "0.01"),
        (9950, 10_000, "99.5"), (999_999, 1_000_000, "99.9999"), (9996, 10_000, "99.96"),
    ],
)  # fmt: skip
def test_per_cent_are_exact_at_their_ends(count, of, said):
    assert percent(count / of) == said


# -- shares -----------------------------------------------------------------------------------------


def test_every_cell_says_its_share_and_interval_in_its_place():
    cells = campaign_cells(campaign_starts(LAWS, FAMILIES[:4], 200, lost=0.5, seed=3))
    figure = share_map(cells)
    (axes,) = figure.axes
    assert [label.get_text() for label in axes.get_yticklabels()] == list(LAWS)
    assert [label.get_text() for label in axes.get_xticklabels()] == list(FAMILIES[:4])
    for row, law in enumerate(LAWS):
        for column, family in enumerate(FAMILIES[:4]):
            cell = cells[(cells["law"] == law) & (cells["family"] == family)].iloc[0]
            own = [
                text.get_text()
                for text in axes.texts
                if column < text.get_position()[0] < column + 1 and row < text.get_position()[1] < row + 1
            ]
            interval = f"[{percent(cell['share_low'])}, {percent(cell['share_high'])}]"
            lost = [f"{cell['lost']} lost"] if cell["lost"] else []
            assert own == [percent(cell["share"]), interval, *lost]
    assert cells["lost"].any()
    assert axes.get_ylim() == (len(LAWS), 0)  # the first law stands above


def test_what_was_measured_stands_below_the_map():
    caption = share_map(campaign_cells(campaign_starts(count=50), "mujoco")).get_supxlabel()
    said = " ".join(caption.split())
    assert "Wheels in MuJoCo, 50 starts a cell" in said
    assert "converged: stays within 10 mm and 20 mrad of its place until the end" in said


def test_what_was_not_measured_is_blank():
    cells = campaign_cells(campaign_starts(LAWS[:2], FAMILIES[:2], 50))
    (axes,) = share_map(cells.drop(index=2)).axes
    (blank,) = [text for text in axes.texts if text.get_text() == "not run"]
    assert blank.get_position() == (0.5, 1.5)
    assert np.ma.getmaskarray(axes.collections[0].get_array()).tolist() == [[False, False], [True, False]]


# -- starts -----------------------------------------------------------------------------------------


def test_every_start_is_a_dart_at_its_place_along_its_heading():
    starts = campaign_starts(families=FAMILIES[:3], count=60, share=0.5, seed=5)
    for axes, family in zip(start_map(starts, campaign_cells(starts), LAWS[0]).axes, FAMILIES[:3], strict=False):
        own = starts[starts["family"] == family]
        order = [own[own["converged"]].sort_values("settling_time"), own[~own["converged"]]]
        poses = pd.concat(order)[["x", "y", "theta"]].to_numpy()
        darts = glyphs(axes)
        assert len(darts) == len(poses)
        for corners, pose in zip(darts, poses, strict=True):
            nose, notch = corners[0], corners[2]
            heading = np.arctan2(*(nose - notch)[::-1])
            assert np.cos(heading - pose[2]) == pytest.approx(1.0, abs=1e-12)
            weights = np.array([0.20, 0.62]) / 0.82  # the axle midpoint lies between nose and notch
            assert weights @ np.array([nose, notch]) == pytest.approx(pose[:2])


def test_the_slower_the_darker_and_failures_on_top_in_their_own_colour():
    starts = campaign_starts(families=FAMILIES[:1], count=100, share=0.7)
    axes = start_map(starts, campaign_cells(starts), LAWS[0]).axes[0]
    good, bad, lost = [each for each in axes.collections if each.get_zorder() < 5]
    shades = [luminance(colour) for colour in good.get_facecolor()]
    assert len(shades) == 70
    assert (np.diff(shades) <= 1e-12).all()  # drawn from the fastest to the slowest
    assert shades[0] > 3 * shades[-1]
    assert len(bad.get_paths()) == 30
    assert to_hex(bad.get_facecolor()[0]) == ROOT.lower()
    assert bad.get_zorder() > good.get_zorder()
    assert len(lost.get_paths()) == 0


def test_very_many_starts_are_dots_and_the_few_that_fail_still_darts():
    starts = campaign_starts(families=FAMILIES[:1], count=5000, share=0.999)
    axes = start_map(starts, campaign_cells(starts), LAWS[0]).axes[0]
    good, bad, _ = [each for each in axes.collections if each.get_zorder() < 5]
    assert good.get_rasterized()
    assert {len(path.vertices) - 1 for path in good.get_paths()} == {6}
    centres = np.array([path.vertices[:-1].mean(axis=0) for path in good.get_paths()])
    expected = starts[starts["converged"]].sort_values("settling_time")[["x", "y"]].to_numpy()
    assert centres == pytest.approx(expected)
    assert {len(path.vertices) - 1 for path in bad.get_paths()} == {4}
    widest = max(float(np.ptp(path.vertices[:, 0])) for path in good.get_paths())
    assert DART_LENGTH * 0.14 * 10 > 5 * widest  # a failure is seen among them


@pytest.mark.slow
def test_the_worst_is_ringed_and_numbered():
    starts = campaign_starts(families=FAMILIES[:2], count=40)
    figure = start_map(starts, campaign_cells(starts), LAWS[0], {FAMILIES[1]: 17})
    assert [line for line in figure.axes[0].lines if line.get_marker() == "o"] == []
    rings = [line for line in figure.axes[1].lines if line.get_marker() == "o"]
    place = starts[(starts["family"] == FAMILIES[1]) & (starts["start"] == 17)][["x", "y"]].to_numpy()[0]
    assert all(ring.get_xydata()[0] == pytest.approx(place) for ring in rings)
    assert len(rings) == 2  # ink on a wider white
    assert texts(figure.axes[1]) == ["17", "all 40 converge"]


def test_disc_and_leader_are_to_scale():
    starts = campaign_starts(families=FAMILIES[:1], count=2000)
    axes = start_map(starts, campaign_cells(starts), LAWS[0]).axes[0]
    (disc,) = axes.patches
    assert (disc.center, disc.radius) == ((0, 0), 10.0)
    assert axes.get_aspect() == 1.0
    (leader,) = [each for each in axes.collections if each.get_zorder() == 5]
    nose, notch = leader.get_paths()[0].vertices[[0, 2]]
    assert nose[1] == notch[1] == 0.0
    assert nose[0] > 0 > notch[0]


def test_a_law_without_runs_is_refused():
    starts = campaign_starts(LAWS[:2], FAMILIES[:1], 5)
    cells = campaign_cells(starts)
    with pytest.raises(ValueError, match="no run of a law 'nobody'; there are universal, published"):
        start_map(starts, cells, "nobody")


# -- distributions ----------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("count", [40, 3000])
def test_curves_are_the_distributions_of_settling_times(count):
    starts = campaign_starts(LAWS[:3], FAMILIES[:2], count, share=0.8)
    figure = settling(starts, campaign_cells(starts))
    for axes, family in zip(figure.axes, FAMILIES[:2], strict=True):
        curves = [line for line in axes.lines if line.get_drawstyle() == "steps-post"]
        assert len(curves) == 3
        for curve, law in zip(curves, LAWS[:3], strict=True):
            own = starts[(starts["law"] == law) & (starts["family"] == family)]["settling_time"].to_numpy()
            for time, share in curve.get_xydata():
                assert share == pytest.approx(100 * np.mean(own <= time))
            assert curve.get_ydata()[-1] == pytest.approx(80.0)
            assert axes.get_xlim()[1] == curve.get_xdata()[-1] >= np.nanmax(own)


def test_nine_laws_are_told_apart_in_colour_and_in_grey():
    labels = tuple(f"law {k}" for k in range(9))
    starts = campaign_starts(labels, FAMILIES[:1], 20)
    legend = settling(starts, campaign_cells(starts)).legends[0]
    lines = legend.get_lines()
    assert [text.get_text() for text in legend.get_texts()] == list(labels)
    assert len({to_hex(line.get_color()) for line in lines}) == 9
    assert len({str(line._unscaled_dash_pattern) for line in lines}) == 9


def test_late_errors_show_medians_worst_and_the_lost():
    starts = campaign_starts(LAWS[:2], FAMILIES[:2], 101, share=0.6, lost=0.1, seed=4)
    starts.loc[starts["lost"], ["late_position", "late_heading"]] = np.nan  # not known
    starts.loc[starts["law"] == LAWS[0], "lost"] = False
    figure = late_errors(starts.fillna({"late_position": 5.0, "late_heading": 1.0}), campaign_cells(starts))
    clean, lossy = figure.axes
    for axes, law in ((clean, LAWS[0]), (lossy, LAWS[1])):
        for row, family in enumerate(FAMILIES[:2]):
            own = starts[(starts["law"] == law) & (starts["family"] == family)]
            for marker, name, offset in (("o", "late_position", -0.16), ("D", "late_heading", 0.16)):
                known = own[name].where(~own["lost"], np.inf).fillna({"late_position": 5.0, "late_heading": 1.0}[name])
                (middle,) = [
                    line for line in axes.lines if line.get_marker() == marker and line.get_ydata()[0] == row + offset
                ]
                assert middle.get_xdata()[0] == pytest.approx(np.median(known))
    assert [line for line in clean.lines if line.get_marker() == ">"] == []
    assert len([line for line in lossy.lines if line.get_marker() == ">"]) == 4
    assert {line.get_xdata()[0] for line in clean.lines if line.get_linestyle() == "--" and line.get_zorder() == 1} == {
        POSITION_LIMIT,
        HEADING_LIMIT,
    }


# -- all of them ------------------------------------------------------------------------------------


def every_figure(starts: pd.DataFrame, cells: pd.DataFrame) -> list[Figure]:
    starting = start_map(starts, cells, LAWS[0], {FAMILIES[0]: 3})
    return [share_map(cells), starting, settling(starts, cells), late_errors(starts, cells)]


@pytest.mark.slow
@pytest.mark.parametrize(("laws", "families", "share"), [(1, 1, 0.0), (1, 1, 0.5), (7, 1, 0.5), (2, 10, None)])
def test_titles_and_legends_stay_on_the_canvas(laws, families, share):
    starts = campaign_starts(LAWS[:laws], FAMILIES[:families], 20, share, lost=0.3)
    for figure in every_figure(starts, campaign_cells(starts)):
        styled(figure.draw_without_rendering)()
        names = [axes._left_title for axes in figure.axes]
        rows = [label for axes in figure.axes[::7] for label in axes.get_yticklabels()]  # the others share theirs
        for artist in [figure._suptitle, *figure.legends, *names, *rows]:
            box = artist.get_window_extent()
            assert box.x0 >= -ON_CANVAS
            assert box.y0 >= -ON_CANVAS
            assert box.x1 <= figure.bbox.x1 + ON_CANVAS
            assert box.y1 <= figure.bbox.y1 + ON_CANVAS


def test_labels_make_file_names_that_differ():
    names = files.file_names(["universal", "Universal, limited", "a b", "a-b", "a_b", "a b 2"])
    assert list(names.values()) == ["universal", "universal_limited", "a_b", "a_b_2", "a_b_3", "a_b_2_2"]


def test_every_figure_is_for_print_if_asked(tmp_path, monkeypatch):
    print_too = []
    monkeypatch.setattr(files, "save_figure", lambda figure, stem, *, pdf: print_too.append(pdf) or [stem])
    starts = campaign_starts(LAWS[:2], FAMILIES[:1], 20)
    assert len(save_campaign_figures(starts, campaign_cells(starts), tmp_path, pdf=True)) == 5
    assert print_too == [True] * 5
