"""Commands that study a scenario before it runs: what they print and write, and their exit codes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from commands import invoke
from nhtrack.experiment.load import load
from nhtrack.recording import Recording

CASE = """\
# A case of its own.
name: case
duration: 6
control_rate: 50
similarity: {length: 0.1, time: 2}   # twice as slow
leader:
  start: {pose: [0, 0, 0]}
  input: {u_x: 0.1, u_theta: "0.2*cos(t)"}
followers:
  - {name: follower, parents: [leader], start: {pose: [-1, 0, 0]}}

# Gains by hand.
law: {name: published, kp: 4, kd: 6, ke: 1, k: 5}   # above the bounds
"""


@pytest.fixture(autouse=True)
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "case.yaml"
    path.write_text(CASE)
    return path


# -- feasibility ------------------------------------------------------------------------------------


def test_feasibility_prints_a_table_and_a_verdict(file: Path) -> None:
    result = invoke("feasibility", file)
    assert result.exit_code == 0, result.output
    for words in ("leader", "follower", "friction utilisation", "wheel torque", "wheel load", "time scale", "right"):
        assert words in result.stdout
    assert "Fits at similarity.time 2, with friction used to 0.7 at most; the smallest time scale" in result.stdout
    assert list(file.parent.iterdir()) == [file]


def test_feasibility_says_json_and_nothing_else(file: Path) -> None:
    result = invoke("feasibility", file, "--json", "--set", "physics.friction=0", "--set", "duration=1")
    rows = json.loads(result.stdout)
    assert {"robot", "quantity", "value", "unit", "limit", "share", "time"} <= set(rows[0])
    assert next(row for row in rows if row["quantity"] == "friction_utilisation")["share"] is None


def test_what_cannot_be_made_feasible_exits_2(file: Path) -> None:
    hopeless = ("--set", "physics.friction=0", "--set", "similarity.time=auto")
    for command in (("feasibility", file), ("run", file, "--no-video", "--no-figures"), ("tune", file)):
        result = invoke(*command, *hopeless)
        assert result.exit_code == 2
        assert result.stdout == ""
        told = "infeasible: leader's left wheel at 0 s asks for friction and there is none, however slow the motion\n"
        assert result.stderr == told
    assert list(file.parent.iterdir()) == [file]


@pytest.mark.slow
def test_a_run_finds_its_time_and_can_be_run_again(file: Path) -> None:
    assert "a time yet to be found" not in invoke("validate", file).stdout
    file.write_text(CASE.replace("time: 2}", "time: auto}"))
    assert "a time yet to be found on the robot's clock" in invoke("validate", file).stdout
    quiet = ("--backend", "ideal", "--no-video", "--no-figures", "--no-report")
    assert invoke("run", file, *quiet, "--out", "one").exit_code == 0
    assert invoke("run", "one/recording.nc", *quiet, "--out", "two").exit_code == 0
    one, two = Recording.load("one/recording.nc"), Recording.load("two/recording.nc")
    assert one.dataset.identical(two.dataset)
    assert one.scenario.similarity.time == one.time_scale


# -- tune -------------------------------------------------------------------------------------------


def test_tune_prints_gains_and_the_search_and_writes_nothing(file: Path) -> None:
    result = invoke("tune", file, "--budget", 8, "--seed", 5)
    assert result.exit_code == 0, result.output
    for words in ("kp", "kd", "ke", "before", "found", "late heading error", "cost"):
        assert words in result.stdout
    assert "objective late, 8 candidates in 1 generation, seed 5, friction margin 0.7" in result.stdout
    assert "to keep these gains: the same command with --write" in result.stdout
    assert "law: {name: published, kp: " in result.stdout
    assert file.read_text() == CASE
    assert list(file.parent.iterdir()) == [file]


def test_tune_writes_gains_and_says_how_they_were_found(file: Path) -> None:
    options = ("--budget", 8, "--objective", "late=1,settling=0.5", "--set", "duration=4")
    assert invoke("tune", file, *options, "--write").exit_code == 0
    lines = file.read_text().splitlines()
    added = [line for line in lines if line.startswith("# nhtrack tune: ")]
    assert "objective late=1,settling=0.5, 8 candidates" in added[0]
    assert added[0].endswith(", with duration=4;")
    assert added[1].startswith("# nhtrack tune: late error ")
    assert [line for line in lines if line not in added][:-1] == CASE.splitlines()[:-1]
    assert lines[-1].endswith("}   # above the bounds")
    assert load(file).duration == 6
    copy = invoke("tune", file, *options, "--out", "copy.yaml")
    assert copy.stdout.endswith("wrote copy.yaml\n")
    assert load("copy.yaml").law == load(file).law


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("case.yaml", "--objective", "lat"), 2, "did you mean 'late'?"),
        (("case.yaml", "--budget", "3"), 2, "8"),
        (("tour/hello", "--write"), 2, "--out writes a copy"),
        (("recording.nc", "--write"), 2, "tune its scenario file"),
        (("case.yaml", "--out", "case.yaml"), 1, "case.yaml exists"),
        (("case.yaml", "--set", "law=samson", "--write"), 1, "has the law 'published', which has no gains of 'samson'"),
        (("nowhere.yaml",), 2, "no such file"),
        (("case.yaml", "--set", "law.kp=x"), 2, "law.kp"),
    ],
)
def test_tune_refuses_before_it_works(arguments: tuple[str, ...], code: int, message: str, file: Path) -> None:
    result = invoke("tune", *arguments)
    assert result.exit_code == code
    assert message in " ".join(result.stderr.replace("│", " ").split())
    assert "Traceback" not in result.output
    assert file.read_text() == CASE
