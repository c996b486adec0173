"""Reports opened in a browser."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from typer.testing import CliRunner

from nhtrack.cli import app
from nhtrack.recording import Recording
from nhtrack.studies.fidelity.bench import Finding
from nhtrack.studies.fidelity.report import write_fidelity_page
from opened import Opened, Opener
from reports import CASE, WILD, whole_recording, write_report

if TYPE_CHECKING:
    from playwright.sync_api import Browser


@pytest.fixture(scope="session")
def tab(browser: Browser) -> Opened:
    return Opened(browser.new_page())


@pytest.fixture
def open_report(tab: Opened) -> Iterator[Opener]:
    """Opens reports, one after the other in one tab; none may complain, ask for another file or open a dialog."""
    yield tab.show
    problems = tab.problems.copy()
    tab.problems.clear()
    assert problems == []


@pytest.fixture(scope="session")
def recording() -> Recording:
    return whole_recording(3, samples=401)


@pytest.fixture(scope="session")
def run_report(recording: Recording, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_report(recording, tmp_path_factory.mktemp("report") / "report.html")


# Reports as commands write them, of small real studies.


def results_of(folder: Path, *arguments: object) -> Path:
    """Runs a command into a folder and returns the report it says it wrote."""
    out = folder / "results"
    result = CliRunner().invoke(app, [*(str(argument) for argument in arguments), "--out", str(out)])
    assert result.exit_code == 0, result.output
    assert f"wrote {out / 'report.html'}" in result.stdout.splitlines()
    return out / "report.html"


@pytest.fixture(scope="session")
def comparison_report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("compare")
    (folder / "case.yaml").write_text(CASE, encoding="utf-8")
    return results_of(folder, "compare", folder / "case.yaml", "kanayama", WILD, "--no-video", "--no-figures")


@pytest.fixture(scope="session")
def campaign_report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    laws = "laws={kanayama: {name: kanayama}, samson: {name: samson}}"
    changes = (laws, "families=[rest, sinus]", "starts.count=8", "duration=20", "arrival.last=2", "tuning=null")
    options = [word for change in changes for word in ("--set", change)]
    quiet = ("--no-figures", "--processes", 1)
    return results_of(tmp_path_factory.mktemp("campaign"), "campaign", "campaign/small", *options, *quiet)


@pytest.fixture(scope="session")
def paper_report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    options = ("--examples", 3, "--backend", "ideal")
    return results_of(tmp_path_factory.mktemp("paper"), "paper", *options)


@pytest.fixture(scope="session")
def fidelity_report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns the page of three figures for each of two robots, as the suite hands them over."""
    told = {"unit": "m/s", "budget": 1.0, "cause": "rounding", "group": "Rest"}
    rows = [
        Finding(robot=robot, check=f"check {k}", value=value, **told).row
        for robot, values in (("nh_mini", (0.2, 0.5, 0.1)), ("burger", (0.4, 0.3, 0.9)))
        for k, value in enumerate(values)
    ]
    folder = tmp_path_factory.mktemp("fidelity")
    return write_fidelity_page(rows, "nhtrack fidelity", {"nhtrack": "0"}, folder / "report.html")


@pytest.fixture(scope="session")
def sweep_report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sweep")
    (folder / "sweep.yaml").write_text(SWEEP, encoding="utf-8")
    return results_of(folder, "sweep", folder / "sweep.yaml", "--no-figures", "--processes", 1)


SWEEP = """\
name: shares
base: tour/lemniscate
set: {duration: 1, leader.virtual: true, backend: ideal}
axes:
  law: {choices: {a law: {name: universal}, "<b>another</b>": {name: kanayama}}}
  delay: [0, 1, 2]
  followers[0].start.pose[1]: {normal: [-0.7, 0.05]}
sample: {method: saltelli, count: 16}
metrics: [final_position_error, final_heading_error, effort_x]
pareto: [[effort_x, final_position_error]]
"""
