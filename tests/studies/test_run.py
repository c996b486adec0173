"""What a run leaves in its folder, and what it says of a twin that goes astray."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from nhtrack import gl, plots
from nhtrack.analysis import metrics
from nhtrack.analysis.event import Event
from nhtrack.experiment.build import build, robot_of
from nhtrack.experiment.load import load
from nhtrack.files.folder import OutputError
from nhtrack.plots.figures import errors, gap, slip
from nhtrack.recording import Recording
from nhtrack.simulation import robot_models
from nhtrack.studies.run import run as study
from nhtrack.studies.run.run import run_scenario, simulate

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


@pytest.mark.slow
@pytest.mark.parametrize(("backend", "last"), [("ideal", "ideal twin"), ("mujoco", "MuJoCo")])
def test_an_interrupted_run_keeps_recording_and_summary(backend: str, last: str, tmp_path: Path) -> None:
    def stage(name: str) -> Callable[[int, int], None]:
        def report(done: int, _: int) -> None:
            if name == last and done > 8:
                raise KeyboardInterrupt

        return report

    outcome = run_scenario(load("tour/hello", [f"backend={backend}"]), tmp_path, stage=stage)
    assert outcome.recording.outcome == "interrupted"
    assert 8 < len(outcome.recording.time) < 2401
    assert sorted(path.name for path in tmp_path.iterdir()) == ["recording.nc", "summary.json"]


def test_a_folder_never_holds_the_files_of_two_runs(tmp_path: Path) -> None:
    """Old figures and film go; what is not ours stays."""
    (tmp_path / "figures").mkdir()
    for name in ("video.mp4", "report.html", "figures/slip.png", "figures/slip.pdf", "notes.txt"):
        (tmp_path / name).write_text("old")
    run_scenario(load("tour/hello", IDEAL), tmp_path, overwrite=True, figures=False, video=False, report=False)
    left = {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*") if path.is_file()}
    assert left == {"recording.nc", "summary.json", "notes.txt"}


@pytest.mark.slow
def test_a_run_reads_its_robot_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever asks for it: the time scale, the law's limits, the twin, the scene."""
    read: list[str] = []
    load_robot = robot_models.load_robot
    monkeypatch.setattr(robot_models, "load_robot", lambda robot, hints: read.append(robot) or load_robot(robot, hints))
    outcome = simulate(load("tour/universal", ["duration=2", "similarity.time=auto"]))
    assert outcome.failure is None
    assert read == ["nh_mini"]


def test_a_robot_that_was_read_for_another_scenario_is_refused() -> None:
    plain, laden = (load("tour/hello", overrides) for overrides in ([], ["physics.payload={mass: 0.1, height: 0.05}"]))
    with pytest.raises(ValueError, match=r"robot: effects is .* when the robot was read"):
        build(laden, robot_of(plain))


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
        os.environ.pop(gl.WITHHELD, None)  # monkeypatch would put it back
        gl.find_backend.cache_clear()


@pytest.mark.slow
def test_figures_that_cannot_be_drawn_are_left_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def wild(*_: object, **__: object) -> None:
        raise ValueError("Axis limits cannot be NaN or Inf")

    monkeypatch.setattr("nhtrack.plots.save_figures", wild)
    outcome = run_scenario(load("tour/hello", IDEAL), tmp_path / "results", video=False)
    assert outcome.skipped == ("no figures: Axis limits cannot be NaN or Inf",)


@pytest.mark.slow
def test_events_are_looked_for_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Table, warnings, figures and report are told of the same ones."""
    looked: list[str] = []

    def find(recording: Recording) -> tuple[Event, ...]:
        looked.append(recording.name)
        return (Event("stuck", "follower", None, 0.125, 0.25, "rim speed", 0.5, "m/s"),)

    for module in (study, metrics, plots, errors, gap, slip):
        monkeypatch.setattr(module, "find_events", find)
    outcome = run_scenario(load("tour/hello", ["duration=0.5"]), tmp_path / "run", video=False)
    assert looked == ["hello"]
    assert [event["kind"] for event in outcome.summary["events"]] == ["stuck"]
    assert any("was stuck" in warning for warning in outcome.summary["warnings"])
    assert '"spells":[[0.125,0.25]]' in (tmp_path / "run" / "report.html").read_text(encoding="utf-8")
