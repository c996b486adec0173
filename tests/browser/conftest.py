"""Reports opened in a headless Chromium, the system's own. Where there is none, these tests are skipped."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from nhtrack.recording import Recording
from reports import whole_recording, write_report

playwright = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed: pip install playwright")

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
PATIENCE = 120_000  # [ms] for a page on a machine that is busy with other things


@dataclass
class Opened:
    """A report in a browser, and what went wrong with it."""

    page: playwright.Page
    problems: list[str] = field(default_factory=list)

    def time(self) -> float:
        return float(self.page.locator("#clock").inner_text().split("/")[0])

    def glyph(self, robot: str, kind: str = "pose") -> str | None:
        return self.page.locator(f'.robot[data-robot="{robot}"][data-kind="{kind}"]').get_attribute("transform")

    def slide(self, value: int) -> None:
        self.page.locator("#time").fill(str(value))


Opener = Callable[..., Opened]


@pytest.fixture(scope="session")
def browser() -> Iterator[playwright.Browser]:
    program = next(filter(None, map(shutil.which, NAMES)), None)
    if program is None:
        pytest.skip(f"no browser: none of {', '.join(NAMES)} is installed")
    with playwright.sync_playwright() as driver:
        # Root has no sandbox; the pages are our own and load nothing.
        opened = driver.chromium.launch(executable_path=program, args=["--no-sandbox"])
        yield opened
        opened.close()


@pytest.fixture
def open_report(browser: playwright.Browser) -> Iterator[Opener]:
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


def watch(opened: Opened, address: str) -> None:
    """Notes what a page must not do, and keeps it from loading anything but itself."""
    page, problems = opened.page, opened.problems

    def guard(route: playwright.Route) -> None:
        if route.request.url.partition("#")[0] == address:
            route.continue_()
        else:
            problems.append(f"asked for {route.request.url[:200]}")
            route.abort()

    def dismiss(dialog: playwright.Dialog) -> None:
        problems.append(f"dialog: {dialog.message}")
        dialog.dismiss()

    page.route("**/*", guard)
    page.on("dialog", dismiss)
    page.on("pageerror", lambda error: problems.append(f"error: {error}"))
    page.on("console", lambda said: problems.append(said.text) if said.type in ("error", "warning") else None)


@pytest.fixture(scope="session")
def recording() -> Recording:
    return whole_recording(3, samples=401)


@pytest.fixture(scope="session")
def report(recording: Recording, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_report(recording, tmp_path_factory.mktemp("report") / "report.html")
