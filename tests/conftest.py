"""A browser, and hypothesis profiles: `ci` draws the same examples everywhere, `explore` looks for new ones.

`pytest --hypothesis-profile=explore` overrides the default.
"""

from __future__ import annotations

import os

# Before numpy is imported: threads for matrices of 4 x 4 only wait for each other, most of all beside other tests.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import shutil
from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest
from hypothesis import HealthCheck, settings

if TYPE_CHECKING:
    from playwright.sync_api import Browser

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")

settings.register_profile("ci", derandomize=True, deadline=None, max_examples=100, database=None)
settings.register_profile(
    "explore", deadline=None, max_examples=2000, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("ci")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Lets files with slow tests begin first: the last one would else run alone, beside idle processes."""
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """A headless Chromium, the system's own. Where there is none, tests that need it are skipped."""
    playwright = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
    program = next(filter(None, map(shutil.which, BROWSERS)), None)
    if program is None:
        pytest.skip(f"no browser: none of {', '.join(BROWSERS)} is installed")
    with playwright.sync_playwright() as driver:
        # Root has no sandbox; the pages are our own and load nothing. The driver asks where every error came from:
        # unless V8 notes all places at once, it reads the whole of Plotly again for each.
        options = ["--no-sandbox", "--js-flags=--no-enable-lazy-source-positions"]
        opened = driver.chromium.launch(executable_path=program, args=options)
        yield opened
        opened.close()
