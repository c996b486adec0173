"""Sweeps: every row is the run that its changes make, however the sweep is divided; what stops one is told."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import nhtrack
from nhtrack.cli import app
from nhtrack.config.sweep import METRICS, ON_WHEELS, Sweep
from nhtrack.execution import Processes, serial
from nhtrack.experiment.load import load_sweep
from nhtrack.studies.run.result import Outcome
from nhtrack.studies.sweep.account import SweepError
from nhtrack.studies.sweep.parts import FAILED, LOST_RUN, part_rows
from nhtrack.studies.sweep.plan import drawn_shares
from nhtrack.studies.sweep.run import plan_of, run_sweep, sweep

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
axes: {law.kick: [1.0, 1.0e+300, 3.0], law.limit: [1, 0.5]}
metrics: [late_position_error, settled]
"""
    table = part_rows(plan_of(sweep_of(tmp_path, text)), np.arange(6))
    by_kick = table.groupby("law.kick")
    assert set(by_kick.get_group(1.0)["outcome"]) == {"completed"}
    assert set(by_kick.get_group(1e300)["outcome"]) == {LOST_RUN}
    assert by_kick.get_group(1e300)["late_position_error"].isna().all()
    assert (by_kick.get_group(1e300)["settled"] == 0).all()
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
    done = run_sweep(sweep_of(tmp_path, text), tmp_path / "out", executor=Processes(1, begin=print))
    assert list(done.runs["outcome"]) == ["completed", FAILED, "completed"]
    assert done.runs["reason"][1] == "ended the process that ran it, 3 times"
    assert {path.name for path in (tmp_path / "out" / "parts").iterdir()} == {f"{k}.parquet" for k in range(3)}


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
    assert {path.name for path in Path("out/figures").iterdir()} == {f"map_{name}.png" for name in names}
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
    assert [path.name for path in done.files] == ["runs.parquet", "axes_path_length.png", "axes_cost.png"]


def test_repetitions_without_anything_random_are_told(tmp_path: Path) -> None:
    text = "name: twice\nbase: tour/hello\naxes: {law.k: [4]}\nrepeats: 2\n"
    told = CliRunner().invoke(app, ["validate", str(tmp_path / "case.yaml")]) if sweep_of(tmp_path, text) else None
    assert told is not None
    assert told.exit_code == 0
    assert "repeats: nothing is random without `noise`" in told.stderr
