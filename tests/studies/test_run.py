"""What a run leaves in its folder, and what it says of a twin that goes astray."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from nhtrack import gl
from nhtrack.experiment.load import load
from nhtrack.studies.run import run as study
from nhtrack.studies.run.run import OutputError, run_scenario, simulate

IDEAL = ["backend=ideal", "duration=0.5"]


@pytest.fixture
def never_simulated(monkeypatch: pytest.MonkeyPatch) -> None:
    def simulate(*_: object) -> None:
        raise AssertionError("the folder is judged before anything is run")

    monkeypatch.setattr(study, "simulate", simulate)


@pytest.mark.usefixtures("never_simulated")
def test_a_folder_that_cannot_be_is_refused_before_the_run(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="cannot write results into"):
        run_scenario(load("tour/hello", IDEAL), tmp_path / "file" / "folder")
    with pytest.raises(OutputError, match="cannot write results into"):
        run_scenario(load("tour/hello", IDEAL), tmp_path / "file", overwrite=True)
    with pytest.raises(OutputError, match="exists already"):
        run_scenario(load("tour/hello", IDEAL), tmp_path)


@pytest.mark.usefixtures("never_simulated")
def test_a_run_that_fails_to_start_leaves_no_folder(tmp_path: Path) -> None:
    with pytest.raises(AssertionError):
        run_scenario(load("tour/hello", IDEAL), tmp_path / "results")
    assert not (tmp_path / "results").exists()


def test_a_folder_never_holds_the_files_of_two_runs(tmp_path: Path) -> None:
    """Old figures and film go; what is not ours stays."""
    (tmp_path / "figures").mkdir()
    for name in ("video.mp4", "report.html", "figures/slip.png", "figures/slip.pdf", "notes.txt"):
        (tmp_path / name).write_text("old")
    run_scenario(load("tour/hello", IDEAL), tmp_path, overwrite=True, figures=False, video=False, report=False)
    left = {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*") if path.is_file()}
    assert left == {"recording.nc", "summary.json", "notes.txt"}


@pytest.mark.slow
def test_wheels_are_kept_where_their_ideal_twin_diverges() -> None:
    """Gains beyond what 100 Hz bears: motors hold the wheels back, nothing holds the ideal robot."""
    wild = ["duration=1.5", "law.kp=1e4", "law.kd=3000", "law.k=20"]
    outcome = simulate(load("tour/hello", wild))
    assert outcome.failure is None
    assert outcome.recording.time[-1] == pytest.approx(1.5)
    gone = np.isnan(outcome.recording["ideal_pose"].values).any(axis=(1, 2))
    assert gone.any()
    assert not gone[0]
    assert any("the ideal twin diverged" in told for told in outcome.summary["warnings"])


@pytest.mark.slow
def test_a_run_that_diverged_is_kept_and_not_filmed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(study, "make_film", lambda *_: pytest.fail("it was filmed"))
    tipping = load("tour/hello", ["physics.friction=3", "leader.start.twist=[2.4, 15]", "duration=1"])
    outcome = run_scenario(tipping, tmp_path / "out", figures=False, report=False)
    assert outcome.failure is not None
    assert [file.name for file in outcome.files] == ["recording.nc", "summary.json"]


def test_mujoco_gl_is_kept_from_mujoco_but_not_from_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "no-such-backend")
    monkeypatch.delenv(gl.WITHHELD, raising=False)
    gl.withhold()
    try:
        assert os.environ["MUJOCO_GL"] == "disable"
        gl.find_backend.cache_clear()
        with pytest.raises(gl.RenderError, match="no-such-backend names no OpenGL backend"):
            gl.find_backend()
    finally:
        monkeypatch.delenv(gl.WITHHELD, raising=False)
        gl.find_backend.cache_clear()


@pytest.mark.slow
def test_figures_that_cannot_be_drawn_are_left_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def wild(*_: object, **__: object) -> None:
        raise ValueError("Axis limits cannot be NaN or Inf")

    monkeypatch.setattr("nhtrack.plots.save_figures", wild)
    outcome = run_scenario(load("tour/hello", IDEAL), tmp_path / "results", video=False)
    assert outcome.skipped == ("no figures: Axis limits cannot be NaN or Inf",)
