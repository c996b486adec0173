"""Sweeps: every row is the run that its changes make, however the sweep is divided; what stops one is told."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.stats import norm
from typer.testing import CliRunner

import nhtrack
from elements import Elements
from nhtrack.cli import app
from nhtrack.config.sweep import METRICS, ON_WHEELS, Sweep
from nhtrack.execution import Processes, serial
from nhtrack.experiment.load import LOADER, load, load_sweep
from nhtrack.studies.run.result import Outcome
from nhtrack.studies.sweep.account import SweepError
from nhtrack.studies.sweep.drawn import MOST_RUNS_SHOWN, drawn, shown_rows
from nhtrack.studies.sweep.front import all_fronts, pareto_rows
from nhtrack.studies.sweep.indices import sobol_indices
from nhtrack.studies.sweep.look import ticks_of
from nhtrack.studies.sweep.parts import FAILED, LOST_RUN, Part, part_rows
from nhtrack.studies.sweep.plan import drawn_shares
from nhtrack.studies.sweep.result import SweepResults
from nhtrack.studies.sweep.run import plan_of, run_sweep, sweep
from nhtrack.studies.sweep.stubborn import do_parts
from reports import HOSTILE

WHEELS = """\
name: wheels
base: paper/example1
set: {duration: 0.3, noise: {position: 0.001, heading: 0.002}}
axes:
  physics.friction: [0.7, 0.02]
  law.k: [6, 4.5]
  followers[0].start.pose[1]: {from: -0.4, to: 0.4, count: 2}
repeats: 2
"""
IDEAL = """\
name: ideal
base: paper/example5
set: {duration: 2, backend: ideal}
axes:
  law: {choices: {printed: published, own: {name: universal, field_speed: 0.5}}}
  law.delay_periods: [0, 1]
  leader.input.u_x: {uniform: [0.0, 0.1]}
  formation: [printed, exact]
sample: {count: 6, seed: 2}
expressions: {cost: "late_position_error/0.01 - 2*switches"}
"""


def sweep_of(folder: Path, text: str) -> Sweep:
    """Returns the sweep of a text."""
    file = folder / "case.yaml"
    file.write_text(text)
    return load_sweep(file)


def figures_of(run: Outcome) -> dict[str, float]:
    """Returns what a sweep's metrics are by a run's summary and recording, written down a second time."""
    followers, robots = run.summary["followers"].values(), list(run.summary["robots"].values())
    with_wheels = [each for each in robots if each["peak_utilisation"] is not None]
    times = [each["settling_time"] for each in followers]
    inputs = run["input"].values[:-1, 1:]
    found = {name: max(each[name] for each in followers) for name in METRICS if name.endswith("_error")}
    shared = {name for name in METRICS if name in with_wheels[0]}
    found |= {name: max(each[name] for each in with_wheels) for name in shared if with_wheels[0][name] is not None}
    found |= {"settled": np.mean([time is not None for time in times])}
    found |= {"settling_time": np.nan if None in times else max(times)}
    effort = np.sqrt((inputs**2).sum(axis=0) / len(inputs)).max(axis=0)
    return found | {"effort_x": effort[0], "effort_theta": effort[1]}


@pytest.mark.parametrize(("text", "runs"), [(WHEELS, (0, 3, 10, 15)), (IDEAL, range(6))], ids=["wheels", "ideal"])
def test_every_row_is_the_run_that_its_changes_make(text: str, runs: Any, tmp_path: Path) -> None:
    plan = plan_of(sweep_of(tmp_path, text))
    table = part_rows(plan, np.arange(plan.sweep.runs))
    assert len(table) == plan.sweep.runs
    assert (table["outcome"] == "completed").all(), table["reason"]
    for run in runs:
        alone = nhtrack.run(plan.base, set=[*plan.changes(run)])
        for name, value in figures_of(alone).items():
            if name in table:
                # sums of squares are summed in another order there
                rounding = 1e-12 if name.endswith("rms") or name.startswith(("effort", "path", "torque")) else 0.0
                np.testing.assert_allclose(table[name][run], value, rtol=rounding, err_msg=f"{name} of run {run}")
    if plan.sweep.expressions:
        np.testing.assert_allclose(table["cost"], table["late_position_error"] / 0.01 - 2 * table["switches"])
    varied = [name for name in METRICS if name in table and table[name].nunique() > 1]
    assert len(varied) > 6, "a test needs runs that differ"


def test_a_table_does_not_depend_on_how_the_sweep_is_divided_or_stopped(tmp_path: Path) -> None:
    ideal = WHEELS.replace("duration: 0.3", "duration: 0.3, backend: ideal")
    case = sweep_of(tmp_path, ideal)
    plan = plan_of(case)
    whole = part_rows(plan, np.arange(case.runs))
    for size in (1, 3):
        parts = list(plan.parts(size))
        assert sorted(np.concatenate(parts)) == list(range(case.runs))
    apart = pd.concat([part_rows(plan, part) for part in list(plan.parts(3))[:3]], ignore_index=True)
    pd.testing.assert_frame_equal(apart, whole.loc[apart["run"]].reset_index(drop=True))
    folder = tmp_path / "out"
    done = run_sweep(case, folder, executor=serial)
    pd.testing.assert_frame_equal(done.runs, whole)
    stamps = {path.name: path.stat().st_mtime_ns for path in (folder / "parts").iterdir()}
    (folder / "parts" / "1.parquet").unlink()
    (folder / "runs.parquet").unlink()
    again = run_sweep(case, folder, executor=Processes(1))
    pd.testing.assert_frame_equal(again.runs, whole)
    kept = {path.name: path.stat().st_mtime_ns for path in (folder / "parts").iterdir()}
    assert {name for name in kept if kept[name] != stamps[name]} == {"1.parquet"}
    with pytest.raises(SweepError, match="holds another sweep"):
        run_sweep(sweep_of(tmp_path, ideal.replace("[6, 4.5]", "[6, 5]")), folder, executor=serial)
    (tmp_path / "used").mkdir()
    (tmp_path / "used" / "file").touch()
    with pytest.raises(SweepError, match="holds no sweep"):
        run_sweep(case, tmp_path / "used", executor=serial)


def test_what_a_run_cannot_do_is_its_row_and_stops_no_other(tmp_path: Path) -> None:
    (tmp_path / "wild.py").write_text(_WILD)
    text = """\
name: wild
base: paper/example1
set: {duration: 0.3, leader.virtual: true, backend: ideal, law: {file: wild.py}}
axes: {law.kick: [1.0, 1.0e+9, 3.0], law.limit: [1, 0.5]}
metrics: [late_position_error, settled]
"""
    table = part_rows(plan_of(sweep_of(tmp_path, text)), np.arange(6))
    by_kick = table.groupby("law.kick")
    assert set(by_kick.get_group(1.0)["outcome"]) == {"completed"}
    assert set(by_kick.get_group(1e9)["outcome"]) == {LOST_RUN}
    assert by_kick.get_group(1e9)["late_position_error"].isna().all()
    assert (by_kick.get_group(1e9)["settled"] == 0).all()
    failed = by_kick.get_group(3.0)
    assert set(failed["outcome"]) == {FAILED}
    assert failed["reason"].str.contains("raised ValueError: three").all()


_IMPORT = "from typing import NamedTuple"
_WILD = '''\
"""A law that does as it is told."""

from typing import NamedTuple


class Gains(NamedTuple):
    """Gains."""

    kick: float = 1.0
    limit: float = 1.0


def command(gains, period, limits, follower, leader, memory):
    """Returns a push, or an exception."""
    if gains.kick == 3.0 and leader.v_x == 0.0:  # it is tried with a leader that moves
        raise ValueError("three")
    return gains.kick * gains.limit, 0.0, memory
'''


@pytest.mark.slow
def test_a_run_that_ends_its_process_is_a_row_and_stops_no_other(tmp_path: Path) -> None:
    deadly = _WILD.replace('raise ValueError("three")', "os._exit(9)").replace(_IMPORT, f"import os\n{_IMPORT}")
    (tmp_path / "deadly.py").write_text(deadly)
    text = """\
name: deadly
base: paper/example1
set: {duration: 0.05, leader.virtual: true, backend: ideal, law: {file: deadly.py}}
axes: {law.kick: [1.0, 3.0, 2.0]}
metrics: [late_position_error]
"""
    parts = [Part(np.array(runs), tmp_path / "parts" / f"{runs[0]}.parquet") for runs in ([2, 1], [0])]
    done = list(do_parts(plan_of(sweep_of(tmp_path, text)), parts, Processes(1, begin=print)))
    assert sorted(part.path for part in done) == sorted((tmp_path / "parts").iterdir()) == sorted(p.path for p in parts)
    rows = pd.concat([pd.read_parquet(part.path) for part in parts], ignore_index=True)
    assert list(rows["run"]) == [2, 1, 0]
    assert list(rows["outcome"]) == ["completed", FAILED, "completed"]
    assert rows["reason"][1] == "ended the process that ran it, 3 times"


@pytest.mark.parametrize("method", ["sobol", "latin_hypercube", "random"])
def test_points_that_are_drawn_fill_the_space(method: str, tmp_path: Path) -> None:
    text = f"""\
name: drawn
base: tour/hello
axes:
  law.kp: {{uniform: [2, 4]}}
  law.kd: {{log_uniform: [0.1, 10]}}
  law.ke: {{normal: [5, 0.5]}}
  law.k: [7, 8, 9, 10]
sample: {{method: {method}, count: 256, seed: 4}}
"""
    plan = plan_of(sweep_of(tmp_path, text))
    shares = drawn_shares(plan.sweep.sample, 4)  # type: ignore[arg-type]
    assert shares.shape == (256, 4)
    assert 0 <= shares.min() < shares.max() < 1
    tolerance = 0.15 if method == "random" else 0.02
    np.testing.assert_allclose(shares.mean(axis=0), 0.5, atol=tolerance)
    points = pd.DataFrame([plan.values(point) for point in range(256)])
    assert points["law.kp"].between(2, 4).all()
    np.testing.assert_allclose(np.log10(points["law.kd"]).mean(), 0.0, atol=2 * tolerance)
    np.testing.assert_allclose([points["law.ke"].mean(), points["law.ke"].std()], [5, 0.5], atol=tolerance)
    counts = points["law.k"].value_counts()
    assert counts.min() > (40 if method == "random" else 60)


def test_a_robot_is_read_anew_where_its_load_is_of_another_size(tmp_path: Path) -> None:
    text = "name: sizes\nbase: stress/payload\nset: {duration: 0.1}\naxes: {similarity.length: [1, 2]}\n"
    table = part_rows(plan_of(sweep_of(tmp_path, text)), np.arange(2))
    assert list(table["outcome"]) == ["completed", "completed"]
    assert table["path_length"].nunique() == 2


def test_every_metric_has_one_value(tmp_path: Path) -> None:
    text = "name: one\nbase: tour/hello\nset: {duration: 0.1}\naxes: {law.k: [4]}\n"
    case = sweep_of(tmp_path, text)
    assert [*METRICS] == [name for name in part_rows(plan_of(case), np.arange(1)) if name in METRICS]
    ideal = sweep_of(tmp_path, text.replace("{duration: 0.1}", "{duration: 0.1, backend: ideal}"))
    assert not {*part_rows(plan_of(ideal), np.arange(1))} & {*ON_WHEELS}


def test_the_command_tells_how_much_it_is_then_runs_and_draws(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    runner = CliRunner()
    assert runner.invoke(app, ["init", "--sweep"]).exit_code == 0
    assert "2 axes, 12 points, 12 runs" in runner.invoke(app, ["validate", "sweep.yaml"]).stdout
    told = runner.invoke(app, ["sweep", "sweep.yaml", "--dry-run"])
    assert "12 points, 12 runs, mujoco backend" in told.stdout
    assert {path.name for path in tmp_path.iterdir()} == {"sweep.yaml"}
    text = (tmp_path / "sweep.yaml").read_text().replace("duration: 10", "duration: 0.2")
    (tmp_path / "sweep.yaml").write_text(text.replace("[late_position_error, gap", "[gap"))
    done = runner.invoke(app, ["sweep", "sweep.yaml", "--out", "out", "--processes", "1"])
    assert done.exit_code == 0, done.stderr
    assert "12 completed" in done.stdout
    names = ("gap_position_max", "peak_utilisation", "cost")
    drawn = {path.name for path in Path("out/figures").iterdir()}
    assert drawn == {*(f"map_{name}.png" for name in names), "matrix.png"}
    assert Path("out/report.html").is_file()
    assert json.loads(Path("out/sweep.json").read_text())["asked"]["repeats"] == 1
    assert len(pd.read_parquet("out/runs.parquet")) == 12
    refused = runner.invoke(app, ["run", "sweep.yaml"])
    assert refused.exit_code == 2
    assert "run it with `nhtrack sweep`" in refused.stderr


def test_python_has_it_too_with_figures_of_every_axis(tmp_path: Path) -> None:
    text = """\
name: drawn
base: tour/hello
set: {duration: 0.2, backend: ideal}
axes:
  law.k: {log_uniform: [4, 8]}
  formation: [printed, exact]
sample: {count: 6}
metrics: [path_length]
expressions: {cost: path_length/2}
"""
    (tmp_path / "case.yaml").write_text(text)
    done = sweep(tmp_path / "case.yaml", out=tmp_path / "out", processes=1, figures=True, progress=False)
    assert repr(done).startswith("SweepResults('drawn', 6 runs in ")
    assert [path.name for path in done.files] == ["runs.parquet", "axes_path_length.png", "axes_cost.png", "matrix.png"]


def test_repetitions_without_anything_random_are_told(tmp_path: Path) -> None:
    text = "name: twice\nbase: tour/hello\naxes: {law.k: [4]}\nrepeats: 2\n"
    told = CliRunner().invoke(app, ["validate", str(tmp_path / "case.yaml")]) if sweep_of(tmp_path, text) else None
    assert told is not None
    assert told.exit_code == 0
    assert "repeats: nothing is random without `noise`" in told.stderr


def not_run(folder: Path, text: str) -> SweepResults:
    """Returns the results of a sweep of a text whose table has no metrics yet."""
    plan = plan_of(sweep_of(folder, text))
    table = plan.labels(np.arange(plan.sweep.runs))
    table["outcome"] = "completed"
    return SweepResults(plan.sweep, plan.base, table, plan.sweep.metrics or (), folder)


SHARES = """\
name: shares
base: tour/hello
axes:
  law.kp: {uniform: [1, 2]}
  law.kd: {log_uniform: [0.1, 10]}
  law.ke: {normal: [5, 0.5]}
sample: {method: saltelli, count: 1024, seed: 3}
metrics: [path_length, effort_x]
repeats: 2
"""


def test_sobol_indices_are_those_of_functions_whose_shares_are_known(tmp_path: Path) -> None:
    """Ishigami and Homma's function (1990), a = 7 and b = 0.1, and a sum, both of the axes' own distributions."""
    results = not_run(tmp_path, SHARES)
    table = results.runs
    u, v, w = table["law.kp"] - 1, (np.log10(table["law.kd"]) + 1) / 2, norm.cdf(table["law.ke"], 5, 0.5)
    x, y, z = (2 * np.pi * np.asarray(each) - np.pi for each in (u, v, w))
    table["path_length"] = np.sin(x) + 7 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x)
    table["effort_x"] = u * np.sqrt(12) + 2 * v * np.sqrt(12) + 2 * 2 * (table["law.ke"] - 5)  # variances 1, 4, 4
    apart = np.random.default_rng(0).uniform(0, 9, len(table) // 2).repeat(2)  # of repetitions the mean counts
    table["path_length"] += np.where(table["repeat"] == 0, apart, -apart)
    found = sobol_indices(results).set_index(["metric", "axis"])
    ishigami, added = found.loc["path_length"], found.loc["effort_x"]
    np.testing.assert_allclose(ishigami["S1"], [0.3139, 0.4424, 0.0], atol=0.03)
    np.testing.assert_allclose(ishigami["ST"], [0.5576, 0.4424, 0.2437], atol=0.03)
    np.testing.assert_allclose(added["S1"], np.array([1, 4, 4]) / 9, atol=0.03)
    np.testing.assert_allclose(added["ST"], np.array([1, 4, 4]) / 9, atol=0.03)
    assert (found[["S1_conf", "ST_conf"]] < 0.15).all(axis=None)
    table.loc[7, "path_length"] = np.nan
    whole = sobol_indices(results).set_index(["metric", "axis"])
    assert list(whole["left_out"]) == [1, 1, 1, 0, 0, 0]
    np.testing.assert_allclose(whole["S1"], found["S1"], atol=0.01)


def test_a_front_has_the_runs_that_no_other_beats() -> None:
    values = np.random.default_rng(0).integers(0, 30, (2000, 3)).astype(float)
    values = values[values.sum(axis=1) > 60]  # far from the corner where all are best
    values[3:20, 1] = np.nan
    table = pd.DataFrame(values, columns=["a", "b", "c"])
    for (one, other), rows in all_fronts(table, ["a", "b", "c"]):
        x, y = table[one].to_numpy(), table[other].to_numpy()
        beaten = [
            bool(((x <= a) & (y <= b) & ((x < a) | (y < b))).any()) or not np.isfinite(a + b)
            for a, b in zip(x, y, strict=True)
        ]
        best = {(a, b) for a, b, lost in zip(x, y, beaten, strict=True) if not lost}
        assert [(x[row], y[row]) for row in rows] == sorted(best)
        assert len(rows) > 3
        shuffled = np.random.default_rng(1).permutation(len(x))
        assert [(x[shuffled][row], y[shuffled][row]) for row in pareto_rows(x[shuffled], y[shuffled])] == sorted(best)


def test_a_sweep_whose_files_have_changed_is_not_gone_on_with(tmp_path: Path) -> None:
    law = tmp_path / "own.py"
    law.write_text(_WILD)
    text = """\
name: own
base: paper/example1
set: {duration: 0.05, leader.virtual: true, backend: ideal}
axes: {law: {choices: {printed: published, own: {file: own.py}}}}
metrics: [late_position_error]
"""
    case = sweep_of(tmp_path, text)
    done = run_sweep(case, tmp_path / "out", executor=serial)
    assert done.runs["key"].nunique() == 2
    (tmp_path / "out" / "parts" / "0.parquet").unlink()
    law.write_text(_WILD.replace("kick: float = 1.0", "kick: float = 1.5"))
    with pytest.raises(SweepError, match=r"own.py has changed"):
        run_sweep(case, tmp_path / "out", executor=serial)
    again = run_sweep(case, tmp_path / "another", executor=serial)
    assert not {*again.runs["key"]} & {*done.runs["key"]}


def test_the_page_of_a_sweep_repeats_any_run_and_escapes_what_users_wrote(tmp_path: Path) -> None:
    text = f"""\
name: page
description: {json.dumps(HOSTILE)}
base: paper/example1
set: {{duration: 0.1, leader.virtual: true, backend: ideal}}
axes:
  law: {{choices: {{{json.dumps(HOSTILE)}: published, k: {{name: kanayama}}}}}}
  law.delay_periods: [0, 1]
  leader.input.u_x: {{uniform: [0.0, 0.1]}}
sample: {{count: 12, seed: 2}}
repeats: 2
metrics: [late_position_error, effort_x, settling_time]
pareto: [[effort_x, late_position_error]]
"""
    file = tmp_path / "case.yaml"
    file.write_text(text)
    done = sweep(file, out=tmp_path / "out", processes=1, report=True, progress=False)
    assert "<script>alert" not in done._repr_html_()
    page = Elements((tmp_path / "out" / "report.html").read_text())
    assert [tag for tag, _ in page.found].count("script") == 3
    data = json.loads(page.texts["script"][0])
    plan, rows = plan_of(done.sweep), data["rows"]
    assert rows["run"] == list(range(24))
    for row in (0, 5, 23):  # what the page's script writes
        held = {
            axis["key"]: axis["texts"][place] if axis["texts"] else place
            for axis, place in ((axis, rows["axes"][i][row]) for i, axis in enumerate(data["axes"]))
        }
        held["seed"] = rows["seed"][row]
        assert [f"{key}={held[key]}" for key in data["again"]["order"]] == plan.changes(row)
    assert [metric["name"] for metric in data["metrics"]] == ["late_position_error", "effort_x"]
    assert data["pairs"] == [[1, 0]]
    begin = "nhtrack run paper/example1 --set duration=0.1 --set leader.virtual=true --set backend=ideal"
    assert data["again"]["prefix"] == begin
    files = {path.name for path in (tmp_path / "out" / "extremes").iterdir()}
    assert {"smallest_effort_x.yaml", "largest_late_position_error.yaml"} <= files
    run, named = next((int(run), named) for run, named in data["files"].items() if "largest_effort_x" in named)
    assert load(tmp_path / "out" / named) == LOADER.load_tree(plan.tree, overrides=plan.changes(run))


@pytest.mark.parametrize("numbers", [10**6, 1])  # that maps may have: a cell for each value, or for some of them
def test_a_cell_of_a_page_is_called_after_the_runs_in_it(
    numbers: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("nhtrack.studies.sweep.drawn._CELL_NUMBERS", numbers)
    text = """\
name: cells
base: tour/hello
axes: {law.kp: {from: 1, to: 2, count: 20}, law.kd: [3, 1, 2], law.ke: {from: 1, to: 9, count: 11}}
repeats: 2
metrics: [path_length, effort_x]
"""
    results = not_run(tmp_path, text)
    table = results.runs
    table["path_length"], table["effort_x"] = np.random.default_rng(0).uniform(1, 2, (2, len(table)))
    maps = drawn(results).data["maps"]
    assert [each["axes"] for each in maps] == [[0, 1], [0, 2], [1, 2]]
    for each in maps:
        places = np.divmod(each["runs"], len(each["columns"]))
        for i, place, names in zip(each["axes"], places, (each["rows"], each["columns"]), strict=True):
            values, bounds = table[list(results.sweep.axes)[i]], [name.partition(" to ") for name in names]
            for value, (low, _, high) in zip(values, (bounds[k] for k in place), strict=True):
                assert float(low) - 1e-3 <= value <= float(high or low) + 1e-3
        medians = table["path_length"].groupby(list(places)).median()
        np.testing.assert_allclose(np.ravel(each["values"][0]), medians.to_numpy(), rtol=1e-3)


def test_what_is_left_out_of_a_page_is_drawn_at_random_but_for_extremes_and_fronts() -> None:
    values = np.random.default_rng(1).normal(size=(60_000, 2))
    values[[5, 17], [0, 1]] = 9.0, np.nan
    table = pd.DataFrame(values, columns=["a", "b"])
    fronts = [rows for _, rows in all_fronts(table, ["a", "b"])]
    rows = shown_rows(table, ["a", "b"], fronts, 3)
    assert len(rows) == MOST_RUNS_SHOWN
    assert {5, int(table["b"].idxmax()), *fronts[0].tolist()} <= {*rows.tolist()}
    assert shown_rows(table[:100], ["a", "b"], [np.arange(3)], 3).tolist() == list(range(100))


@pytest.mark.parametrize(
    ("factors", "low", "high"), [(False, 0.05, 0.45), (False, -3.0, 8e4), (True, 3.2, 20.0), (True, 1e-4, 3.0)]
)
def test_ticks_of_many_cells_are_round_numbers_where_they_belong(factors: bool, low: float, high: float) -> None:
    of = np.geomspace if factors else np.linspace
    places, texts = ticks_of(pd.Index(of(low, high, 100)), factors=factors)
    ticks = np.array([float(text.replace("\u2212", "-")) for text in texts])
    assert 2 <= len(ticks) <= 20
    assert all(float(f"{tick:.2g}") == tick for tick in ticks), texts
    centre = np.log if factors else np.asarray
    wanted = 0.5 + 99 * (centre(ticks) - centre(low)) / (centre(high) - centre(low))
    np.testing.assert_allclose(places, wanted, atol=1e-9)
    assert ticks_of(pd.Index([3.0, 1.0]))[1] == ["3", "1"]
