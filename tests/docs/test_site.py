"""The site is built of all pages, loads nothing from elsewhere, and fits a screen of any width."""

from __future__ import annotations

import re
import subprocess
import sys
import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, built as strictly as `make site` does."""
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder


def test_every_page_is_there(site: Path) -> None:
    pages = [page.relative_to(ROOT / "docs") for page in ROOT.glob("docs/**/*.md")]
    outside = [page.relative_to(ROOT) for name in ("C*.md", "models/*/README.md") for page in ROOT.glob(name)]
    for page in (*pages, *outside):
        assert (site / page.with_name(page.name.replace("README", "index")).with_suffix(".html")).is_file(), page


def test_nothing_is_loaded_from_elsewhere(site: Path) -> None:
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        loaded = re.findall(r'<(?:script|img|iframe|link)\b[^>]* (?:src|href)="([^"]+)', text)
        assert loaded
        assert not [url for url in loaded if url.startswith(("http:", "https:", "//"))], page.name
    for style in site.rglob("*.css"):
        text = style.read_text(encoding="utf-8")
        assert not re.findall(r"(?:@import|url\()\s*[\"']?(?:https?:)?//", text), style.name


@pytest.mark.browser
def test_pages_fit_a_telephone_and_search_finds(site: Path, browser: Browser, served: str) -> None:
    page = browser.new_page(viewport={"width": 400, "height": 800})
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    for name in sorted(each.relative_to(site).as_posix() for each in site.rglob("*.html")):
        page.goto(f"{served}/{name}")
        assert page.evaluate("document.documentElement.scrollWidth") <= 400, name
    page.set_viewport_size({"width": 1400, "height": 900})
    page.goto(f"{served}/index.html")
    page.fill(".md-search__input", "payload")
    page.wait_for_selector(".md-search-result__item")
    assert "Scenario files" in page.inner_text(".md-search-result__list")
    page.close()
    assert {url.startswith((served, "data:", "blob:")) for url in asked} == {True}


@pytest.fixture
def served(site: Path) -> Iterator[str]:
    """The address of the site on this machine."""
    quiet = type("Quiet", (SimpleHTTPRequestHandler,), {"log_message": lambda *_: None})
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(quiet, directory=str(site))) as server:
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()
        thread.join()
