"""Every robot keeps every budget of `nhtrack fidelity`."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from nhtrack import assets
from nhtrack.cli import app
from nhtrack.errors import SimulationDiverged
from nhtrack.simulation.scene import Scene
from nhtrack.studies.fidelity import suite
from nhtrack.studies.fidelity.bench import Bench, Finding

pytestmark = pytest.mark.fidelity


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def broken(findings: list[Finding]) -> list[str]:
    return [f"{each.robot}, {each.check}: {each.value:.3g} {each.unit}" for each in findings if not each.ok]


@pytest.fixture(scope="module")
def findings() -> list[Finding]:
    return suite.run_suite(suite.tasks())


@pytest.mark.slow
@pytest.mark.parametrize("robot", assets.robots())
def test_every_budget_is_kept(findings: list[Finding], robot: str) -> None:
    own = [finding for finding in findings if finding.robot == robot]
    assert len({finding.check for finding in own}) == len(own) >= (25 if Bench(robot).swivels else 30)
    assert not broken(own)


def test_json_has_a_row_for_every_finding() -> None:
    result = CliRunner().invoke(app, ["fidelity", "--robot", "nh_mini", "--check", "reduced_model", "--json"])
    assert result.exit_code == 0
    rows = json.loads(result.stdout)
    assert [row["check"] for row in rows] == ["mass matrix in (v, omega)", "wheel torques of any motion"]
    for row in rows:
        assert {"robot", "check", "value", "unit", "budget", "ok", "cause"} <= row.keys()
        assert row["ok"]
        assert 0 <= row["value"] <= row["budget"]
        assert row["group"] == "Reduced model against MuJoCo's dynamics"
    assert json.loads(Path("runs/fidelity-1/findings.json").read_text()) == rows
    assert "wrote runs/fidelity-1/report.html" in result.stderr


def test_the_table_says_how_many_budgets_are_kept() -> None:
    result = CliRunner().invoke(app, ["fidelity", "--robot", "burger", "--check", "load_shares"])
    assert result.exit_code == 0
    assert "wheel loads against statics" in result.stdout
    assert "1 of 1 budgets kept" in result.stdout
    page = Path("runs/fidelity-1/report.html").read_text(encoding="utf-8")
    assert "nhtrack fidelity --robot burger --check load_shares" in page
    assert result.stdout.endswith("wrote runs/fidelity-1/findings.json\nwrote runs/fidelity-1/report.html\n")


def test_nothing_is_written_where_that_is_asked_for_or_refused() -> None:
    Path("precious").write_text("")
    measured = ["fidelity", "--robot", "burger", "--check", "load_shares"]
    result = CliRunner().invoke(app, [*measured, "--out", "."])
    assert result.exit_code == 1
    assert "--force" in result.stderr
    assert CliRunner().invoke(app, [*measured, "--no-report"]).exit_code == 0
    assert [path.name for path in Path().iterdir()] == ["precious"]


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["--check", "opn_loop"], 2, "no check 'opn_loop'; did you mean 'open_loop'?"),
        (["--robot", "nh_mni"], 2, "no robot 'nh_mni'; did you mean 'nh_mini'?"),
    ],
)
def test_a_misspelt_name_is_told_before_anything_is_measured(arguments: list[str], code: int, message: str) -> None:
    result = CliRunner().invoke(app, ["fidelity", *arguments])
    assert result.exit_code == code
    assert message in " ".join(result.output.replace("│", " ").split())


def test_a_broken_budget_is_told_with_its_cause(monkeypatch: pytest.MonkeyPatch) -> None:
    finding = Finding("nh_mini", "drift at rest", 1.0, "m/s", 1e-9, "somebody pushed it")
    monkeypatch.setattr(suite, "run_suite", lambda *_: [finding])
    result = CliRunner().invoke(app, ["fidelity", "--check", "rest"])
    assert result.exit_code == 1
    assert "nh_mini, drift at rest: somebody pushed it" in result.stdout
    monkeypatch.setattr(suite, "run_suite", lambda *_: [replace(finding, explained=True)])
    result = CliRunner().invoke(app, ["fidelity", "--check", "rest"])
    assert result.exit_code == 0
    assert "explained: see docs/fidelity.md" in result.stdout


def test_a_robot_that_diverges_is_a_finding(monkeypatch: pytest.MonkeyPatch) -> None:
    def diverge(bench: Bench) -> None:
        raise SimulationDiverged("tipped over", "robot", 1.0)

    monkeypatch.setitem(suite.CHECKS, "rest", diverge)
    (finding,) = suite.measure(suite.Task("nh_mini", "rest"))
    assert not finding.ok
    assert "tipped over" in finding.cause
    assert finding.row["value"] is None


def test_a_figure_that_is_not_finite_keeps_no_budget() -> None:
    assert not Finding("r", "c", float("nan"), "1", 1.0, "").ok
    assert not Finding("r", "c", float("inf"), "1", 1.0, "", sense="at least").ok
    assert Finding("r", "c", 2.0, "1", 1.0, "", sense="at least").ok
    assert not Finding("r", "c", 2.0, "1", 1.0, "").ok


def test_a_bench_changes_every_scene() -> None:
    seen: list[Scene] = []

    def note(scene: Scene) -> Scene:
        seen.append(scene)
        return scene

    Bench("nh_mini", note).simulation(friction=0.3)
    assert [scene.spec.friction for scene in seen] == [0.3]
