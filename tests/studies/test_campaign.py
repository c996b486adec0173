"""Campaigns: starts and references drawn, figures against recordings, tables by hand, work gone on with."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import tolerances as tol
from nhtrack.config.campaign import Campaign, Starts
from nhtrack.config.edit import scenario_text
from nhtrack.config.families import FAMILIES, RANDOM
from nhtrack.errors import SimulationDiverged
from nhtrack.execution import Done, Serial
from nhtrack.execution.contract import Result, Task
from nhtrack.experiment.build import build
from nhtrack.experiment.load import load_campaign, load_text
from nhtrack.experiment.recorder import Shape
from nhtrack.recording import Recording
from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.scene import make_scene
from nhtrack.simulation.state import State
from nhtrack.studies.campaign import run as campaigns
from nhtrack.studies.campaign.cell import Cell
from nhtrack.studies.campaign.draw import draw_pieces, draw_starts
from nhtrack.studies.campaign.outcomes import outcomes_of, simulation_of, statistics_of
from nhtrack.studies.campaign.parts import run_starts
from nhtrack.studies.campaign.run import CampaignError, run_campaign
from nhtrack.studies.campaign.tables import COLUMNS, cells_of, worst_first
from nhtrack.studies.run.run import run
from watching import Memories

CASE = """
name: case
duration: 12
similarity: {length: 0.1, time: 0.9}
laws:
  universal: {name: universal, limits: {utilisation: 0.5}}
  k: {name: kanayama}
families: [sinus, random]
starts: {count: 6, seed: 3, special: 0.5}
arrival: {last: 3}
"""


def case(tmp_path: Path, *overrides: str) -> Campaign:
    path = tmp_path / "case.yaml"
    path.write_text(CASE)
    return load_campaign(path, overrides)


def replayed(cell: Cell, start: int) -> Recording:
    """Returns the recording of one start, by way of the text of its scenario."""
    return run(load_text(scenario_text(cell.scenario(start)))).recording


# -- starts and references --------------------------------------------------------------------------


def test_the_first_starts_of_many_are_those_of_few() -> None:
    few, many = (draw_starts(Starts(count=count, seed=5)) for count in (70, 500))
    np.testing.assert_array_equal(few.pose, many.pose[:70])
    np.testing.assert_array_equal(few.twist, many.twist[:70])
    pieces = [draw_pieces(Starts(count=count, seed=5), 30.0, 0.01) for count in (7, 50)]
    np.testing.assert_array_equal(pieces[0].ends, pieces[1].ends[:7])
    np.testing.assert_array_equal(pieces[0].values, pieces[1].values[:7])


def test_starts_fill_the_disc_evenly() -> None:
    starts = Starts(count=20_000, seed=1, radius=4.0, speed=0.5, turning=2.0, special=0.0)
    pose, twist = draw_starts(starts)
    radius = np.hypot(pose[:, 0], pose[:, 1])
    spread = 4 / np.sqrt(starts.count)  # four standard deviations of a share
    assert radius.max() <= 4.0
    assert np.mean(radius < 2.0) == pytest.approx(0.25, abs=spread)
    assert np.mean(pose[:, 2] > 0) == pytest.approx(0.5, abs=spread)
    assert 0.499 < np.abs(twist[:, 0]).max() <= 0.5
    assert 1.99 < np.abs(twist[:, 1]).max() <= 2.0


def test_special_starts_are_what_they_are_said_to_be() -> None:
    pose, twist = draw_starts(Starts(count=1000, seed=2))
    block = np.arange(1000) % 50
    on_leader, opposite = np.isin(block, (0, 3)), np.isin(block, (1, 3, 4))
    assert (pose[on_leader, :2] == 0).all()
    assert set(np.abs(pose[opposite, 2])) == {np.pi}
    assert set(pose[opposite, 2]) == {np.pi, -np.pi}
    assert (pose[np.isin(block, (2, 4)), 1] == 0).all()
    at_rest = (twist == 0).all(axis=1)
    assert (at_rest[block < 5]).mean() == 0.5
    assert not at_rest[block >= 5].any()
    ordinary = pose[block >= 5]
    assert (ordinary[:, 1] != 0).all()


def test_a_random_reference_is_that_of_its_scenario() -> None:
    starts, duration, period = Starts(count=5, seed=9), 40.0, 0.0125
    pieces = draw_pieces(starts, duration, period)
    periods = round(duration / period)
    sampled = pieces.sample(periods, slice(1, 4))
    assert sampled.shape == (periods, 3, 2)
    campaign = Campaign.model_validate({
        "name": "c", "duration": duration, "laws": {"u": {"name": "universal"}}, "families": ["random"],
        "starts": starts, "control_rate": 80.0,
    })  # fmt: skip
    middles = (np.arange(periods) + 0.5) * period
    for start in (1, 2, 3):
        given = Cell(campaign, "u", RANDOM).scenario(start).leader.input.reference().sample(middles)
        np.testing.assert_array_equal(given, sampled[:, start - 1])


def test_random_references_keep_their_bounds_and_come_to_a_stop() -> None:
    period = 0.01
    pieces = draw_pieces(Starts(count=200, seed=4), 80.0, period)
    twist = pieces.sample(8000, slice(0, 200)).cumsum(axis=0) * period
    assert 1.45 < np.abs(twist[..., 0]).max() < 1.5 + tol.HAND
    assert 0.97 < np.abs(twist[..., 1]).max() < 1.0 + tol.HAND
    stands = (np.abs(twist[..., 0]) < tol.HAND) & (pieces.sample(8000, slice(0, 200))[..., 0] == 0)
    assert stands.any(axis=0).mean() > 0.9


@pytest.mark.slow
def test_every_bundled_family_is_a_reference_with_its_twist(tmp_path: Path) -> None:
    campaign = case(tmp_path, "families=" + json.dumps([*FAMILIES, RANDOM]))
    speeds = {}
    for name in campaign.family_names:
        experiment = build(Cell(campaign, "universal", name).scenario(0))
        u = experiment.similarity.inputs_to_scenario(experiment.inputs)
        start = experiment.similarity.twists_to_scenario(experiment.start.xi[0])
        step = campaign.duration / len(u)
        speeds[name] = tuple(np.round(start[[0, 2]] + u.sum(axis=0) * step, 2))
    assert speeds["rest"] == (0, 0)
    assert speeds["line"] == (1, 0)
    assert speeds["circle"] == (1, 0.5)
    assert speeds["spin"] == (0, 0.5)
    assert speeds["slow-decay"] == (pytest.approx(1 / 13, abs=0.01),) * 2


# -- figures ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("label", "family", "backend"),
    [
        ("universal", "random", "ideal"),
        ("k", "sinus", "ideal"),
        pytest.param("universal", "random", "mujoco", marks=pytest.mark.slow),
    ],
)
def test_figures_are_those_of_the_recorded_run(label: str, family: str, backend: str, tmp_path: Path) -> None:
    campaign = case(tmp_path, f"backend={backend}", "physics.timestep=0.002")
    cell = Cell(campaign, label, family)
    rows = run_starts(cell, slice(0, 6))
    assert list(rows.columns) == list(COLUMNS)
    for start in (0, 2, 5):
        row, recording = rows.iloc[start], replayed(cell, start)
        error, u = recording["error"].values[:, 1], recording["input"].values[:-1, 1]
        distance, heading = np.hypot(error[:, 0], error[:, 1]) / 0.1, np.abs(error[:, 2])
        late = recording.time / 0.9 > 9 - 1e-9
        assert row["late_position"] == distance[late].max()
        assert row["late_heading"] == heading[late].max()
        outside = np.flatnonzero((distance > 0.01) | (heading > 0.02))
        settled = (outside[-1] + 1) / 1080 * 12
        if not row["converged"]:
            assert np.isnan(row["settling_time"])
        else:
            assert row["settling_time"] == pytest.approx(settled, rel=tol.HAND)
        assert row["converged"] == bool((distance[late] <= 0.01).all() and (heading[late] <= 0.02).all())
        used = np.nanmax(recording["friction_utilisation"].values[:, 1])
        assert row["peak_utilisation"] == pytest.approx(used, rel=tol.HAND)
        effort = np.sqrt((u**2).mean(axis=0)) * np.array([0.9**2 / 0.1, 0.9**2])
        np.testing.assert_allclose(row[["effort_x", "effort_theta"]].to_numpy(float), effort, rtol=tol.HAND)
        pose, twist = recording["pose"].values[0, 1], recording["twist"].values[0, 1]
        np.testing.assert_allclose(row[["x", "y", "theta"]].to_numpy(float), pose / [0.1, 0.1, 1], rtol=tol.HAND)
        np.testing.assert_allclose(row[["v", "omega"]].to_numpy(float), twist[[0, 2]] * [9, 0.9], rtol=tol.HAND)


@pytest.mark.parametrize("backend", ["ideal", pytest.param("mujoco", marks=pytest.mark.slow)])
def test_a_start_with_delay_and_noise_is_the_same_in_every_part_and_in_its_scenario(
    backend: str, tmp_path: Path
) -> None:
    """Lengths and times of the scenario: noise of a millimetre and a hundredth of a unit of speed."""
    link = ("delay=4", "noise={position: 0.001, heading: 0.002, speed: 0.01, turning: 0.01}")
    campaign = case(tmp_path, f"backend={backend}", "physics.timestep=0.002", "laws.k.delay_periods=4", *link)
    cell = Cell(campaign, "k", "random")
    rows = run_starts(cell, slice(0, 6))
    parts = [run_starts(cell, slice(*ends)) for ends in ((0, 1), (1, 4), (4, 6))]
    pd.testing.assert_frame_equal(rows, pd.concat(parts, ignore_index=True), check_exact=True)
    for start in (1, 5):
        recording = replayed(cell, start)
        late = recording.time / 0.9 > 9 - 1e-9
        error = recording["error"].values[late, 1]
        assert rows["late_position"][start] == (np.hypot(error[:, 0], error[:, 1]) / 0.1).max()
        assert rows["late_heading"][start] == np.abs(error[:, 2]).max()
    other = run_starts(Cell(case(tmp_path, f"backend={backend}", "physics.timestep=0.002"), "k", "random"), slice(0, 6))
    assert (other["late_position"] != rows["late_position"]).all()


def test_deviations_of_noise_scale_with_similarity(tmp_path: Path) -> None:
    noise = "noise={position: 0.5, heading: 0.25, speed: 2, turning: 3}"
    link = build(Cell(case(tmp_path, noise, "starts.seed=18446744073709551615"), "k", "sinus").scenario(2)).link
    assert link.deviations == pytest.approx((0.05, 0.25, 2 * 0.1 / 0.9, 3 / 0.9), rel=tol.HAND)
    assert link.seeds.tolist() == [1]  # of 2**64 + 1, its last bits


def test_a_part_is_what_its_starts_are_alone(tmp_path: Path) -> None:
    cell = Cell(case(tmp_path, "control_rate=50"), "universal", "random")
    alone = pd.concat([run_starts(cell, slice(start, start + 1)) for start in range(4)], ignore_index=True)
    pd.testing.assert_frame_equal(run_starts(cell, slice(0, 4)), alone, check_exact=True)


def test_switches_are_periods_in_which_a_mode_of_the_law_changes(tmp_path: Path) -> None:
    cell = Cell(case(tmp_path, "duration=30", "control_rate=50"), "universal", "random")
    experiment = cell.experiment(slice(0, 6))
    recorder = Memories()
    experiment.record(simulation_of(experiment, "ideal"), recorder)
    counted = (np.diff(recorder.rows[:, :, 1], axis=0) != 0).any(axis=2).sum(axis=0)
    assert counted.max() > 2
    np.testing.assert_array_equal(run_starts(cell, slice(0, 6))["switches"], counted)


def test_a_lost_run_is_told_and_leaves_the_others_alone(tmp_path: Path) -> None:
    overrides = ("laws.k={name: feedback_linearisation, v_min: 1.0e-4, k_inner: 20}", "starts.count=20")
    cell = Cell(case(tmp_path, *overrides), "k", "sinus")
    rows = run_starts(cell, slice(0, 20))
    lost = rows["lost"].to_numpy()
    assert 0 < lost.sum() < 20, "a test needs both"
    assert not rows["converged"][lost].any()
    assert rows[["late_position", "late_heading", "settling_time"]][lost].isna().all(axis=None)
    kept = int(np.flatnonzero(~lost)[0])
    pd.testing.assert_frame_equal(
        rows.iloc[[kept]].reset_index(drop=True), run_starts(cell, slice(kept, kept + 1)), check_exact=True
    )


@pytest.mark.slow
def test_on_wheels_a_lost_simulation_stands_still_and_the_others_go_on(tmp_path: Path) -> None:
    experiment = Cell(case(tmp_path, "backend=mujoco"), "universal", "sinus").experiment(slice(0, 3))
    scene = make_scene(experiment.scene)

    def commands(k: int) -> np.ndarray:
        u = np.zeros((3, 2, 2))
        u[:, 1] = [0.2, 1.0]
        if k == 20:
            u[1, 1] = np.nan
        return u

    together = MujocoSimulation(scene, experiment.dt, (3,), keep_going=True)
    state, path = together.reset(experiment.start), []
    for k in range(60):
        state = together.step(commands(k))
        path.append(state.g)
    assert together.lost.tolist() == [False, True, False]
    assert (path[-1][1] == path[19][1]).all()
    assert (state.xi[1] == 0).all()
    np.testing.assert_allclose(together.qvel[1], 0, atol=1e-3)  # it settles on its wheels
    for member in (0, 2):
        alone = MujocoSimulation(scene, experiment.dt, (1,))
        single = alone.reset(State(0.0, experiment.start.g[[member]], experiment.start.xi[[member]]))
        for _ in range(60):
            single = alone.step(commands(0)[[member]])
        np.testing.assert_array_equal(single.g[0], path[-1][member])
    strict = MujocoSimulation(scene, experiment.dt, (3,))
    strict.reset(experiment.start)
    wrong = commands(20)
    with pytest.raises(SimulationDiverged):
        strict.step(wrong)


# -- tables -----------------------------------------------------------------------------------------


def rows(**columns: object) -> pd.DataFrame:
    count = len(columns["converged"])  # type: ignore[arg-type]
    plain = dict.fromkeys(COLUMNS, 0.0) | {"law": "a", "family": "f", "start": np.arange(count), "lost": False}
    return pd.DataFrame(plain | columns, index=range(count))


@pytest.mark.slow
def test_shares_have_the_interval_of_wilson() -> None:
    table = cells_of(rows(converged=[True] * 45 + [False] * 5), {("a", "f"): {"k": 2.0}}, backend="ideal")
    (row,) = table.to_dict("records")
    n, z, p = 50, 1.959963984540054, 0.9
    centre, half = p + z**2 / (2 * n), z * np.sqrt(p * (1 - p) / n + z**2 / (4 * n**2))
    assert row["share"] == 0.9
    assert row["share_low"] == pytest.approx((centre - half) / (1 + z**2 / n), rel=tol.HAND)
    assert row["share_high"] == pytest.approx((centre + half) / (1 + z**2 / n), rel=tol.HAND)
    assert (row["gains"], row["backend"], row["starts"], row["converged"]) == ("k=2", "ideal", 50, 45)


def test_the_worst_run_is_a_lost_one_then_the_farthest_then_the_slowest() -> None:
    table = rows(
        converged=[True, False, False, True, True],
        lost=[False, False, True, False, False],
        late_position=[0.004, 0.5, np.nan, 0.004, 1e-15],
        settling_time=[3.0, np.nan, np.nan, 9.0, 20.0],
    )
    assert worst_first(table)["start"].tolist() == [2, 1, 3, 0, 4]


# -- the work ---------------------------------------------------------------------------------------


TUNED = "tuning={laws: [k], budget: 8, starts: 2}"


class Here(Serial):
    """Does the work of campaigns in this process; keeps the files written, in the order of the work."""

    def __init__(self) -> None:
        self.files: list[Path] = []

    def __call__(self, tasks: Sequence[Task], work: Callable[[Task], Result]) -> Done[Result]:
        self.files += [task.path for task in tasks]
        yield from super().__call__(tasks, work)


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns the folder of a campaign that was run."""
    folder = tmp_path_factory.mktemp("campaign")
    run_campaign(case(folder, TUNED), folder / "out", executor=Here())
    return folder


@pytest.mark.slow
def test_a_campaign_goes_on_where_it_was_left(done: Path) -> None:
    here = Here()
    out = done / "out"
    runs, cells = (out / "runs.parquet").read_bytes(), (out / "cells.csv").read_bytes()
    parts = sorted((out / "parts").iterdir())
    assert len(parts) == 4
    parts[1].unlink()
    (out / "runs.parquet").unlink()
    results = run_campaign(case(done, TUNED), out, executor=here)
    assert here.files == [parts[1]]
    assert (out / "runs.parquet").read_bytes() == runs
    assert (out / "cells.csv").read_bytes() == cells
    assert len(results.runs) == 24
    assert results.cells[["law", "family"]].values.tolist() == [
        ["universal", "sinus"], ["universal", "random"], ["k", "sinus"], ["k", "random"],
    ]  # fmt: skip
    assert set(results.worst) == {"universal", "k"}


@pytest.mark.slow
def test_the_worst_run_again_has_the_figures_of_the_table(done: Path) -> None:
    table = pd.read_parquet(done / "out" / "runs.parquet")
    for label in ("universal", "k"):
        worst = worst_first(table[table["law"] == label]).iloc[0]
        recording = run(done / "out" / "worst" / f"{label}.yaml").recording
        error = recording["error"].values[recording.time / 0.9 > 9 - 1e-9, 1]
        assert np.hypot(error[:, 0], error[:, 1]).max() / 0.1 == worst["late_position"]


@pytest.mark.slow
def test_another_campaign_is_not_mixed_in(done: Path, tmp_path: Path) -> None:
    with pytest.raises(CampaignError, match="another campaign"):
        run_campaign(case(done, TUNED, "starts.seed=4"), done / "out")
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "letter.txt").write_text("dear")
    with pytest.raises(CampaignError, match="holds no campaign"):
        run_campaign(case(tmp_path), tmp_path / "full")
    assert [path.name for path in (tmp_path / "full").iterdir()] == ["letter.txt"]


@pytest.mark.slow
def test_gains_are_tuned_once_and_taken_over(done: Path, tmp_path: Path) -> None:
    here = Here()
    first = Path(shutil.copytree(done / "out", tmp_path / "first"))
    cells = pd.read_csv(first / "cells.csv").set_index(["law", "family"])
    for family in ("sinus", "random"):
        account = first / "tuning" / f"k-{family}.json"
        gains = json.loads(account.read_text())["gains"]
        shown = dict(item.split("=") for item in cells.loc[("k", family), "gains"].split())
        assert {name: float(value) for name, value in shown.items()} == gains
        account.write_text(json.dumps({"gains": gains | {"k_x": 7.0}}))
    other = case(tmp_path, TUNED, "starts={count: 1, seed: 8}")
    second = run_campaign(other, tmp_path / "second", executor=here, tuned_by=first)
    taken = second.cells.set_index("law").loc["k", "gains"]
    assert all("k_x=7 " in gains for gains in taken)
    assert load_text(second.worst["k"].read_text()).law.k_x == 7.0
    assert {path.parent.name for path in here.files} == {"parts"}
    other = case(tmp_path, TUNED, "families=[rest]", "duration=20")
    with pytest.raises(CampaignError, match=r"duration, families differ"):
        run_campaign(other, tmp_path / "third", tuned_by=first)


@pytest.mark.slow
def test_auto_takes_the_time_that_every_family_needs(tmp_path: Path) -> None:
    auto = case(tmp_path, "similarity.time=auto", "families=[rest, stop-and-go]", "probes=3")
    each = [campaigns.at_fitting_time(auto.model_copy(update={"families": (name,)})) for name in auto.family_names]
    times = [campaign.similarity.time_scale for campaign in each]
    assert campaigns.at_fitting_time(auto).similarity.time_scale == max(times)
    assert 0.3 < min(times) < max(times) < 1.5


@pytest.mark.slow
def test_universal_converges_in_the_small_campaign() -> None:
    small = load_campaign("campaign/small")
    assert small.family_names == ("rest", "sinus", "forward-reverse", "random")
    for family in small.family_names:
        found = run_starts(Cell(small, "universal", family), slice(0, 10))
        assert found["converged"].all()
        assert not found["lost"].any()
        assert (found["saturated"] == 0).all()
        assert found["peak_utilisation"].max() < 0.5


def test_a_lost_run_has_not_converged_wherever_it_was(tmp_path: Path) -> None:
    campaign = case(tmp_path)
    experiment = Cell(campaign, "k", "sinus").experiment(slice(0, 2))
    statistics = statistics_of(campaign, experiment)
    statistics.begin(Shape(len(experiment.inputs), 2, 2, False, 0, (0, 0), experiment.dt, 0.0))  # no error in any row
    found = outcomes_of(statistics, campaign, experiment, np.array([False, True]))
    assert found["converged"].tolist() == [True, False]
    assert np.isnan(found["settling_time"]).tolist() == [False, True]
