"""`nhtrack compare`: what it prints and writes, what it refuses, and its exit codes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from commands import invoke
from nhtrack.experiment.load import load
from nhtrack.recording import Recording
from nhtrack.studies.compare import run as study
from reports import CASE, WILD

QUIET = ("--no-video", "--no-figures", "--no-report")


@pytest.fixture(autouse=True)
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "case.yaml"
    path.write_text(CASE)
    return path


def rows(folder: str) -> list[dict]:
    return json.loads(Path(folder, "comparison.json").read_text())["laws"]


@pytest.mark.slow
def test_a_row_for_every_law_and_a_file_for_everything(file: Path) -> None:
    result = invoke("compare", file, "kanayama", WILD, "--no-video", "--pdf")
    assert result.exit_code == 0, result.output
    lines = result.stdout.splitlines()
    for label in ("published", "kanayama-1", "kanayama-2"):
        assert sum(line.startswith(f" {label} ") for line in lines) == 2
    ended = {line.split()[0]: line.rstrip().endswith("completed") for line in lines[2:5]}
    assert ended == {"published": True, "kanayama-1": True, "kanayama-2": False}
    assert "diverged at 0." in lines[4]
    assert max(map(len, lines[:9])) <= 80
    written = [line.removeprefix("wrote ") for line in lines if line.startswith("wrote ")]
    found = {path.as_posix() for path in Path("runs").rglob("*") if path.is_file()}
    assert set(written) == found
    assert {f"runs/compare-case-1/{name}" for name in ("figures/overlay.pdf", "report.html")} < found
    row = rows("runs/compare-case-1")[1]
    assert [row["label"] for row in rows("runs/compare-case-1")] == ["published", "kanayama-1", "kanayama-2"]
    cells = [line.split() for line in lines if line.startswith(" kanayama-1 ")]
    assert float(cells[0][1]) == pytest.approx(1e3 * row["late_position_error"], rel=5e-3)
    assert cells[0][2] == "mm"
    assert float(cells[0][3]) == pytest.approx(1e3 * row["late_heading_error"], rel=5e-3)
    assert cells[0][4] == "mrad"
    (effort_x, per_metre), (effort_theta, per_radian) = cells[1][-4:-2], cells[1][-2:]
    assert (per_metre, per_radian) == ("mm/s²", "mrad/s²")
    assert float(effort_x) == pytest.approx(1e3 * row["effort_x"], rel=5e-3)
    assert float(effort_theta) == pytest.approx(1e3 * row["effort_theta"], rel=5e-3)


@pytest.mark.slow
def test_changes_are_the_scenarios_and_laws_keep_their_own(file: Path) -> None:
    changes = ("--set", "law.k=6", "--set", "duration=1", "--backend", "ideal")
    assert invoke("compare", file, "samson", "published", *changes, *QUIET, "--out", "one").exit_code == 0
    laws = [row["law"] for row in rows("one")]
    assert [law["name"] for law in laws] == ["samson", "published"]
    assert (laws[1]["k"], laws[1]["kp"]) == (6.0, 1.0)
    assert [row["end"] for row in rows("one")] == pytest.approx([1.0, 1.0])
    again = invoke("compare", "one/published/recording.nc", "one/samson/recording.nc", *QUIET, "--out", "two")
    assert again.exit_code == 0, again.output
    assert [row["law"] for row in rows("two")] == laws[::-1]


@pytest.mark.slow
def test_gains_that_were_tuned_are_told_and_those_that_tune_finds(file: Path) -> None:
    result = invoke("compare", file, "samson", "--tune", 8, "--objective", "late=1,settling=1", *QUIET)
    assert result.exit_code == 0, result.output
    gains = rows("runs/compare-case-1")[1]["tuning"]["gains"]
    told = next(line for line in result.stdout.splitlines() if line.startswith("tuned: samson: "))
    for name, gain in gains.items():
        assert f"{name} {gain:g}" in told
    tuned = invoke("tune", file, "--budget", 8, "--objective", "late=1,settling=1", "--out", "tuned.yaml")
    assert tuned.exit_code == 0
    assert rows("runs/compare-case-1")[0]["law"] == load("tuned.yaml").law.model_dump(mode="json")


@pytest.mark.slow
def test_a_common_time_scale_is_told_and_warnings_that_do_not_fit_are_counted(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = study.simulate

    def simulate(scenario: object, stage: object) -> object:
        outcome = whole(scenario, stage)  # type: ignore[arg-type]
        outcome.summary["warnings"] = [f"[w{k}]" for k in range(10)] if scenario.law.name == "samson" else ["one"] * 5
        return outcome

    monkeypatch.setattr(study, "simulate", simulate)
    options = ("--set", "similarity.time=auto", "--set", "duration=1", *QUIET)
    told = invoke("compare", file, "samson", *options, "--out", "results").stdout
    scale = Recording.load("results/samson/recording.nc").time_scale
    assert f"note: similarity.time is {scale:g}, the smallest that fits every law: " in told
    assert told.count("warning: ") == 12
    assert "warning: samson: [w0]" in told  # brackets are not markup
    assert "and 3 more warnings in comparison.json" in told


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("case.yaml",), 2, "Missing argument 'LAW'"),
        (("nowhere.yaml", "samson"), 2, "nowhere.yaml: no such file"),
        (("case.yaml", "samso"), 2, "did you mean 'samson'?"),
        (("case.yaml", "stabiliser"), 2, "write '{name: stabiliser, kp: ..., kd: ..., k: ...}'"),
        (("case.yaml", "samson", "--set", "law.kp=x"), 2, "law.kp: expected a number"),
        (("case.yaml", "samson", "--backend", "gazebo"), 2, "gazebo"),
        (("case.yaml", "samson", "--tune", "4"), 2, "8"),
        (("case.yaml", "samson", "--tune", "16", "--objective", "lat"), 2, "did you mean 'late'?"),
        (("case.yaml", "samson", "--objective", "late"), 2, "add --tune N"),
        (("case.yaml", "none.nc"), 2, "none.nc: no such recording"),
        (("case.yaml", "samson", "--out", "."), 1, "exists already; choose another --out, or --force"),
        (("case.yaml", "samson", "--set", "physics.friction=0", "--set", "similarity.time=auto"), 2, "infeasible: "),
    ],
)
def test_it_refuses_before_it_works(arguments: tuple[str, ...], code: int, message: str, file: Path) -> None:
    result = invoke("compare", *arguments)
    assert result.exit_code == code
    assert message in " ".join(result.stderr.replace("│", " ").split())
    assert "Traceback" not in result.output
    assert list(file.parent.iterdir()) == [file]


@pytest.mark.slow
def test_every_law_diverging_exits_3_and_keeps_what_there_is(file: Path) -> None:
    wild = ("--set", "law.kp=1e4", "--set", "law.kd=3e3", "--set", "law.k=20")
    result = invoke("compare", file, WILD, *wild, "--no-video", "--out", "results")
    assert result.exit_code == 3
    assert "diverged: every law did" in result.stderr
    assert [row["outcome"].split(":")[0] for row in rows("results")] == ["diverged"] * 2
    assert Path("results/kanayama/recording.nc").is_file()


@pytest.mark.slow
def test_an_interruption_exits_130_and_keeps_what_there_is(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = study.simulate

    def simulate(scenario: object, stage: object) -> object:
        if scenario.law.name == "samson":  # type: ignore[attr-defined]
            raise KeyboardInterrupt
        return whole(scenario, stage)  # type: ignore[arg-type]

    monkeypatch.setattr(study, "simulate", simulate)
    result = invoke("compare", file, "samson", "kanayama", "--out", "results")
    assert result.exit_code == 130
    assert "interrupted; what was recorded until then is kept" in result.stderr
    assert "samson: not run, the comparison was interrupted" in result.stdout
    assert [row["label"] for row in rows("results")] == ["published"]
    assert not Path("results/video.mp4").exists()
