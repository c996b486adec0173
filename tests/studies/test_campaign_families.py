"""Families of campaigns over grids, by any input of a leader, in sets, and drawn: what each is, and its maps."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import tolerances as tol
from campaign_tables import campaign_cells, campaign_starts
from elements import Elements
from nhtrack import se2
from nhtrack.config.campaign import Campaign, Starts
from nhtrack.config.documentation import json_schema
from nhtrack.config.edit import scenario_text
from nhtrack.config.families import QUICK, SETS
from nhtrack.experiment.build import build
from nhtrack.experiment.load import load_campaign, load_text
from nhtrack.report.page import render_page
from nhtrack.studies.campaign import run as campaigns
from nhtrack.studies.campaign.beforehand import campaign_beforehand
from nhtrack.studies.campaign.cell import Cell
from nhtrack.studies.campaign.draw import draw_walks
from nhtrack.studies.campaign.grids import by_reference, grid_labels, grid_maps, whole_percent
from nhtrack.studies.campaign.parts import run_starts
from nhtrack.studies.campaign.plots import grid_map
from nhtrack.studies.campaign.report import Account, campaign_page
from nhtrack.studies.campaign.run import run_campaign
from nhtrack.studies.run.run import run

CASE = """
name: case
duration: 12
similarity: {length: 0.1, time: 0.9}
laws:
  k: {name: kanayama}
  universal: {name: universal}
families:
  - name: reverse
    grid: {f: {from: 0.5, to: 8, count: 3, log: true}, A: [0.25, 1]}
    u_x: A*f*cos(f*t)
    u_theta: where(A > 0.5, -0.1, 1e-1)
    twist: [-A, f/2]
    labels: {f: "frequency [rad/s]"}
  - {name: turning, grid: {omega: [-2, 0, 3]}, twist: [0.5, omega], u_x: 0, u_theta: 0.1*omega**2}
  - sinus
  - {name: curve, input: {path: {x: 1 + 2*sin(0.3*t), y: 3 - sin(0.6*t)}}}
starts: {count: 4, seed: 3, special: 0.5}
arrival: {last: 3}
"""
BY_HAND = """
  - {name: reverse-a, u_x: 0.25*0.5*cos(0.5*t), u_theta: 0.1, twist: [-0.25, 0.25]}
  - {name: reverse-b, u_x: 1*2*cos(2*t), u_theta: -0.1, twist: [-1, 1]}
  - {name: reverse-c, u_x: 0.25*8*cos(8*t), u_theta: 0.1, twist: [-0.25, 4]}
  - {name: turning-a, u_x: 0, u_theta: 0.1*(-2)**2, twist: [0.5, -2]}
"""
POINTS = {
    "reverse-a": "reverse f=0.5 A=0.25", "reverse-b": "reverse f=2 A=1", "reverse-c": "reverse f=8 A=0.25",
    "turning-a": "turning omega=-2",
}  # fmt: skip


def case(folder: Path, *overrides: str, text: str = CASE) -> Campaign:
    path = folder / "case.yaml"
    path.write_text(text)
    return load_campaign(path, overrides)


# -- over grids -------------------------------------------------------------------------------------


@pytest.mark.slow
def test_points_are_the_families_written_out_by_hand(tmp_path: Path) -> None:
    gridded = case(tmp_path)
    by_hand = case(tmp_path, text=CASE.replace("  - sinus\n", f"{BY_HAND.strip(chr(10))}\n  - sinus\n"))
    for own, point in POINTS.items():
        (scenario, same) = (Cell(each, "k", name).scenario(1) for each, name in ((gridded, point), (by_hand, own)))
        assert scenario.leader.start == same.leader.start
        np.testing.assert_array_equal(build(scenario).inputs, build(same).inputs)
    cells = Cell(gridded, "k", POINTS["reverse-b"]), Cell(by_hand, "k", "reverse-b")
    here, there = (run_starts(cell, slice(0, 4)) for cell in cells)
    pd.testing.assert_frame_equal(here.drop(columns="family"), there.drop(columns="family").assign(**{
        "grid": "reverse", "grid.f": 2.0, "grid.A": 1.0,
    })[[*here.columns.drop("family")]], check_exact=True)  # fmt: skip


def test_every_point_is_a_family_of_its_own(tmp_path: Path) -> None:
    campaign = case(tmp_path)
    assert campaign.family_names == (
        *(f"reverse f={f} A={amplitude}" for f in ("0.5", "2", "8") for amplitude in ("0.25", "1")),
        *(f"turning omega={omega}" for omega in (-2, 0, 3)),
        "sinus",
        "curve",
    )
    turning = [campaign.family(f"turning omega={omega}") for omega in (-2, 0, 3)]
    assert [leader.start.twist for leader in turning if leader] == [(0.5, -2), (0.5, 0), (0.5, 3)]
    sinus, point = (run_starts(Cell(campaign, "k", name), slice(0, 1)) for name in ("sinus", "turning omega=3"))
    assert sinus["grid"].tolist() == [""]
    assert point["grid"].tolist() == ["turning"]
    assert point[["grid.f", "grid.A", "grid.omega"]].to_numpy()[0] == pytest.approx([np.nan, np.nan, 3], nan_ok=True)
    assert sinus[["grid.f", "grid.A", "grid.omega"]].isna().all(axis=None)


def test_ranges_have_both_ends_and_are_even(tmp_path: Path) -> None:
    families = json.dumps([{
        "name": "g", "u_x": "a*b", "u_theta": 0,
        "grid": {"a": {"from": 0.05, "to": 20, "count": 7, "log": True}, "b": {"from": -1, "to": 2, "count": 4}},
    }])  # fmt: skip
    points = list(case(tmp_path, f"families={families}").grids[0].points.values())
    a, b = (np.array(sorted({point[name] for point in points})) for name in "ab")
    assert len(points) == 28
    assert b.tolist() == [-1, 0, 1, 2]
    assert (a[0], a[-1]) == (0.05, 20)
    np.testing.assert_allclose(a[1:] / a[:-1], 400 ** (1 / 6), rtol=2e-4)
    assert all(f"{value:.4g}" == f"{value:.12g}" for value in a)


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns the folder of a campaign that was run in this process, one law tuned."""
    folder = tmp_path_factory.mktemp("grids")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(campaigns, "_all", lambda tasks, work, *_: [work(task) for task in tasks])
        run_campaign(case(folder, "tuning={laws: [k], budget: 8, starts: 2}"), folder / "out")
    return folder / "out"


@pytest.mark.slow
def test_a_grid_is_tuned_once_in_its_middle(done: Path) -> None:
    assert sorted(path.stem for path in (done / "tuning").iterdir()) == [
        "k-curve", "k-reverse_f=2_A=1", "k-sinus", "k-turning_omega=0",
    ]  # fmt: skip
    cells = pd.read_csv(done / "cells.csv")
    for grid, middle in (("reverse", "reverse_f=2_A=1"), ("turning", "turning_omega=0")):
        found = json.loads((done / "tuning" / f"k-{middle}.json").read_text())["gains"]
        (told,) = cells.loc[(cells["law"] == "k") & (cells["grid"] == grid), "gains"].unique()
        assert told == " ".join(f"{name}={value:g}" for name, value in found.items())


@pytest.mark.slow
def test_the_worst_point_runs_again(done: Path) -> None:
    runs = pd.read_parquet(done / "runs.parquet")
    recording = run(done / "worst" / "universal.yaml").recording
    error = recording["error"].values[recording.time / 0.9 > 9 - 1e-9, 1]
    worst = runs[runs["law"] == "universal"]["late_position"].max()
    assert np.hypot(error[:, 0], error[:, 1]).max() / 0.1 == worst


@pytest.mark.slow
def test_the_points_of_a_grid_are_one_reference_in_sum(done: Path) -> None:
    runs, cells = pd.read_parquet(done / "runs.parquet"), pd.read_csv(done / "cells.csv")
    whole, summed = by_reference(runs, cells)
    assert summed["family"].tolist() == ["reverse", "turning", "sinus", "curve"] * 2
    assert summed["starts"].tolist() == [24, 12, 4, 4] * 2
    assert len(whole) == len(runs)
    for _, row in summed.iterrows():
        points = cells["grid"].fillna(cells["family"]) == row["family"]
        own = cells[(cells["law"] == row["law"]) & points]
        assert row["converged"] == own["converged"].sum()
        assert row["late_position_max"] == pytest.approx(own["late_position_max"].max(), rel=1e-5)
        assert row["backend"] == "ideal"
    plain = runs.drop(columns=["grid", "grid.f", "grid.A", "grid.omega"])
    assert by_reference(plain, plain)[0] is plain


def test_points_beyond_a_law_are_told_once(tmp_path: Path) -> None:
    grid = "{name: g, grid: {w: [3, 4, 5]}, twist: [0.5, w], u_x: 0, u_theta: 0}"
    alone = "{name: own, twist: [0.5, 4], u_x: 0, u_theta: 0}"
    campaign = case(tmp_path, f"families=[{grid}, {alone}]", "laws={universal: {name: universal}}")
    told = [line for line in campaign_beforehand(campaign) if " under universal: " in line]
    assert [line.split(" under ")[0] for line in told] == ["g w=3", "own"]
    assert told[0].endswith("; likewise at 1 other corner of its grid")
    assert "likewise" not in told[1]


# -- maps -------------------------------------------------------------------------------------------


def made_up(laws: tuple[str, ...] = ("one", "two")) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Returns tables of a grid of 3 x 2 points that was never run, rows in no order, and of a plain family."""
    at = {f"g a={a:g} b={b:g}": (a, b) for a in (0.5, 4.0, 20.0) for b in (-1.0, 3.0)}
    runs = campaign_starts(laws, (*at, "rest"), 20, share=None, seed=2).sample(frac=1.0, random_state=1)
    cells = campaign_cells(runs)
    for table in (runs, cells):
        table["grid"] = np.where(table["family"] == "rest", "", "g")
        for place, name in enumerate(("grid.a", "grid.b")):
            table[name] = [at.get(family, (np.nan, np.nan))[place] for family in table["family"]]
    return runs, cells


def test_a_map_has_the_shares_of_its_table() -> None:
    _, cells = made_up()
    maps = {each.law: each for each in grid_maps(cells.drop(index=cells.index[cells["family"] == "g a=4 b=3"][0]))}
    assert set(maps) == {"one", "two"}
    missing = cells.loc[cells.index[cells["family"] == "g a=4 b=3"][0], "law"]
    for law, found in maps.items():
        assert (found.columns, found.rows) == (("0.5", "4", "20"), ("-1", "3"))
        assert (found.across, found.up) == ("a", "b")
        for (row, column), share in np.ndenumerate(found.shares):
            point = f"g a={found.columns[column]} b={found.rows[row]}"
            cell = cells[(cells["law"] == law) & (cells["family"] == point)].iloc[0]
            if (law, point) == (missing, "g a=4 b=3"):
                assert np.isnan(share)
            else:
                assert share == cell["share"]


@pytest.mark.slow
def test_a_map_over_one_number_has_a_row_a_law(done: Path) -> None:
    cells = pd.read_csv(done / "cells.csv")
    (found,) = [each for each in grid_maps(cells) if each.name == "turning"]
    assert (found.columns, found.rows, found.up) == (("-2", "0", "3"), ("k", "universal"), "")
    expected = cells[cells["grid"] == "turning"].set_index(["law", "grid.omega"])["share"].unstack()
    np.testing.assert_array_equal(found.shares, expected.loc[["k", "universal"], [-2, 0, 3]])


def test_the_figure_writes_every_share_in_its_place_on_one_scale() -> None:
    _, cells = made_up()
    for found in grid_maps(cells):
        axes, bar = grid_map(cells, found, {"a": "frequency [rad/s]"}).axes
        assert (axes.get_xlabel(), axes.get_ylabel()) == ("frequency [rad/s]", "b")
        written = {text.get_position(): text.get_text() for text in axes.texts}
        assert written == {(k + 0.5, i + 0.5): whole_percent(share) for (i, k), share in np.ndenumerate(found.shares)}
        assert axes.collections[0].get_clim() == (0, 1)
        assert bar.get_ylim() == (0, 100)
        assert axes.get_ylim() == (0, 2)  # small numbers below


def test_no_share_is_rounded_to_all_or_none() -> None:
    assert [whole_percent(share) for share in (0, 0.001, 0.5, 0.999, 1)] == ["0", "1", "50", "99", "100"]


def test_the_page_has_the_maps_and_no_starts_of_theirs() -> None:
    runs, cells = made_up()
    tree = load_campaign("campaign/small").model_dump(mode="json")
    tree["families"] = [{"name": "g", "grid": {"a": [], "b": []}, "labels": {"b": "speed [m/s]"}}, "rest"]
    page = Elements(render_page(campaign_page(runs, cells, Account(tree, {}, {}, json_schema(Campaign)))))
    rows = [row for row in page.rows if row[0] in ("-1", "3")]
    expected = [[name, *map(whole_percent, row)] for each in grid_maps(cells) for name, row in
                reversed(list(zip(each.rows, each.shares, strict=True)))]  # fmt: skip
    assert rows == expected
    assert "Across: a. Up: speed [m/s]." in page.texts["p"]
    assert next(row for row in page.rows if row[0] == "law")[1:] in (["g", "rest"], ["rest", "g"])
    data = json.loads(page.texts["script"][0])
    for law in data["starts"]:
        kept = dict(zip(data["families"], law, strict=True))
        assert kept["g"] is None
        assert len(kept["rest"]["start"]) == 20
    assert grid_labels(tree) == {"g": {"b": "speed [m/s]"}}


# -- by input ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("given", ["{path: {x: 1 + 2*sin(0.3*t), y: 3 - sin(0.6*t)}}", "{poses: drive.csv}"])
def test_a_family_by_input_is_the_leader_of_a_scenario(given: str, tmp_path: Path) -> None:
    t = np.linspace(0, 14, 29)
    rows = np.stack([t, 5 + t, 2 + 0 * t, 0 * t], axis=-1)
    (tmp_path / "drive.csv").write_text("t,x,y,theta\n" + "\n".join(",".join(map(repr, row)) for row in rows.tolist()))
    campaign = case(tmp_path, f"families=[{{name: own, input: {given}}}]")
    cell = Cell(campaign, "universal", "own")
    scenario = load_text(
        f"name: s\nduration: 12\nsimilarity: {{length: 0.1, time: 0.9}}\nbackend: ideal\nlaw: {{name: universal}}\n"
        f"leader: {{virtual: true, input: {given}}}\n"
        "followers: [{name: follower, parents: [leader], start: {pose: [0, 0, 0]}}]\n",
        directory=tmp_path,
    )
    assert cell.scenario(2).leader == scenario.leader
    began = se2.compose(np.array(scenario.leader.start.pose), cell.draw.pose)
    experiment = cell.experiment(slice(0, 4))
    np.testing.assert_array_equal(experiment.inputs[:, 1], build(scenario).inputs)
    np.testing.assert_allclose(experiment.start.g[:, 1] * [10, 10, 1], began, rtol=tol.HAND)
    found = run_starts(cell, slice(0, 4))
    np.testing.assert_array_equal(found[["x", "y", "theta"]], cell.draw.pose)  # as seen from the leader
    recording = run(load_text(scenario_text(cell.scenario(2)))).recording
    error = recording["error"].values[recording.time / 0.9 > 9 - 1e-9, 1]
    assert found["late_position"][2] == np.hypot(error[:, 0], error[:, 1]).max() / 0.1
    first = se2.between(recording["pose"].values[0, 0], recording["pose"].values[0, 1]) * [10, 10, 1]
    np.testing.assert_allclose(first, cell.draw.pose[2], atol=tol.HAND)


# -- bundled ----------------------------------------------------------------------------------------


def test_sets_stand_for_all_their_members(tmp_path: Path) -> None:
    campaign = case(tmp_path, "families=[line, quick]")
    assert campaign.family_names == ("line", *SETS["quick"])
    assert {*QUICK, "random-walk"} == {*SETS["quick"]}
    default = Campaign.model_validate({"name": "c", "laws": {"k": {"name": "kanayama"}}})
    assert default.family_names == SETS["slow"]


@pytest.mark.slow
def test_quick_leaders_are_what_their_names_say(tmp_path: Path) -> None:
    campaign = case(tmp_path, "families=[quick]", "duration=80", "similarity.time=1")
    twist = {}
    for name in QUICK:
        experiment = build(Cell(campaign, "k", name).scenario(0))
        u = experiment.similarity.inputs_to_scenario(experiment.inputs)
        begun = experiment.similarity.twists_to_scenario(experiment.start.xi[0])[[0, 2]]
        twist[name] = np.concatenate([[begun], begun + u.cumsum(axis=0) * 0.01])
    for name, period in {"reverse-300ms": 0.3, "reverse-1s": 1, "reverse-20s": 20}.items():
        v = twist[name][:, 0]
        assert abs(v).max() == pytest.approx(0.5, rel=1e-2)
        assert np.sum(np.diff(np.sign(v[1:-1] + 1e-9)) != 0) == pytest.approx(160 / period, abs=2)
    for omega in (2, 3, 4, 6, 10, 20):
        assert (twist[f"circle-{omega}"] == [0.5, omega]).all()
    assert (twist["spin-20"] == [0, 20]).all()
    bursts = twist["bursts"][:, 0]
    assert bursts.max() == pytest.approx(1.0)
    assert (abs(bursts) < tol.HAND).mean() == pytest.approx(0.92, abs=0.005)
    for time in (1, 10, 30):
        assert twist[f"decay-{time}s"][-1] == pytest.approx(np.exp(-80 / time) * np.ones(2), abs=1e-4)
    square = twist["square"]
    assert abs(square[:, 0] * square[:, 1]).max() < 1e-5  # it either drives or turns, but for what keeps it on its path
    assert (abs(square).max(axis=1) < 1e-3).mean() > 0.1  # and stands between
    assert square[:, 1].sum() * 0.01 > 4 * np.pi
    assert twist["eight"][:, 0].min() > 0.3
    assert twist["eight"][:, 1].min() < -0.5 < 0.5 < twist["eight"][:, 1].max()
    assert twist["ever-faster"][-1, 0] == pytest.approx(16)


@pytest.mark.slow
def test_random_walks_keep_to_their_accelerations_and_are_those_of_few() -> None:
    period = 0.01
    few, many = (draw_walks(Starts(count=count, seed=4), 80.0, period) for count in (5, 400))
    np.testing.assert_array_equal(few.values, many.values[:5])
    u = many.sample(8000, slice(0, 400))
    twist = u.cumsum(axis=0) * period
    assert abs(u).max() <= 1.0 + tol.HAND
    assert (abs(u) > 0.999).mean() > 1e-4  # some are held back
    late = twist[4000:]
    np.testing.assert_allclose(late.std(axis=(0, 1)), [0.6, 0.5], rtol=0.1)
    np.testing.assert_allclose(late.mean(axis=(0, 1)), 0, atol=0.06)
    lag = 400  # what is remembered after the memory of 4 s
    kept = (late[lag:] * late[:-lag]).mean(axis=(0, 1)) / (late**2).mean(axis=(0, 1))
    np.testing.assert_allclose(kept, np.exp(-1), atol=0.08)
    assert len({tuple(row) for row in many.values[:, 0]}) == 400
