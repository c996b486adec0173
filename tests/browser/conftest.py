"""Reports opened in a headless Chromium, the system's own. Where there is none, these tests are skipped."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from typer.testing import CliRunner

from nhtrack.recording import Recording
from nhtrack.terminal import app
from opened import Opened, Opener, watch
from reports import CASE, WILD, whole_recording, write_report

if TYPE_CHECKING:
    from playwright.sync_api import Browser

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
PATIENCE = 120_000  # [ms] for a page on a machine that is busy with other things


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    playwright = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
    program = next(filter(None, map(shutil.which, NAMES)), None)
    if program is None:
        pytest.skip(f"no browser: none of {', '.join(NAMES)} is installed")
    with playwright.sync_playwright() as driver:
        # Root has no sandbox; the pages are our own and load nothing.
        opened = driver.chromium.launch(executable_path=program, args=["--no-sandbox"])
        yield opened
        opened.close()


@pytest.fixture
def open_report(browser: Browser) -> Iterator[Opener]:
    """Opens reports; afterwards none may have complained, asked for another file or opened a dialog."""
    all_opened: list[Opened] = []

    def open_it(path: Path, *, size: tuple[int, int] = (1280, 720), dark: bool = False) -> Opened:
        scheme = "dark" if dark else "light"
        page = browser.new_page(viewport={"width": size[0], "height": size[1]}, color_scheme=scheme)
        page.set_default_timeout(PATIENCE)
        opened = Opened(page)
        all_opened.append(opened)
        watch(opened, path.as_uri())
        page.goto(path.as_uri())
        page.wait_for_selector("html[data-ready]", state="attached")
        return opened

    yield open_it
    for opened in all_opened:
        opened.page.close()
        assert opened.problems == []


@pytest.fixture(scope="session")
def recording() -> Recording:
    return whole_recording(3, samples=401)


@pytest.fixture(scope="session")
def report(recording: Recording, tmp_path_factory: pytest.TempPathFactory) -> Path:
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
    changes = ("starts.count=8", "families=[rest, sinus]", "duration=40", "tuning=null")
    options = [word for change in changes for word in ("--set", change)]
    return results_of(tmp_path_factory.mktemp("campaign"), "campaign", "campaign/small", *options, "--no-figures")


@pytest.fixture(scope="session")
def paper_report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    options = ("--examples", 3, "--backend", "ideal")
    return results_of(tmp_path_factory.mktemp("paper"), "paper", *options)


@pytest.fixture(scope="session")
def fidelity_report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    options = ("--robot", "nh_mini", "--robot", "burger", "--check", "reduced_model", "--check", "load_shares")
    return results_of(tmp_path_factory.mktemp("fidelity"), "fidelity", *options)
