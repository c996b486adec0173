"""A tab of a browser with a report in it, and what went wrong there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import ConsoleMessage, Dialog, Page, Route

FITS = "document.documentElement.scrollWidth === document.documentElement.clientWidth"
PLOTS_FIT = """[...document.querySelectorAll('.plot')].every(
    (plot) => plot.clientWidth > 0 && plot.querySelector('.main-svg').clientWidth === plot.clientWidth)"""
PATIENCE, STEP = 60_000, 20  # [ms] for something to happen on a busy machine, and between two looks


@dataclass
class Opened:
    """A tab that shows one report after the other; `problems` is what they said or did that they must not."""

    page: Page
    problems: list[str] = field(default_factory=list)
    address: str = ""

    def __post_init__(self) -> None:
        self.page.set_default_timeout(PATIENCE)
        self.page.route("**/*", self._guard)
        self.page.on("dialog", self._dismiss)
        self.page.on("pageerror", lambda error: self.problems.append(f"error: {error}"))
        self.page.on("console", self._hear)

    def show(self, path: Path, *, size: tuple[int, int] = (1280, 720), dark: bool = False) -> Opened:
        """Opens a report as if the tab were new."""
        self.page.mouse.move(0, 0)
        self.resize(size)
        self.page.emulate_media(media="screen", color_scheme="dark" if dark else "light")
        self.address = path.as_uri()
        self.page.goto(self.address)
        self.page.wait_for_selector("html[data-ready]", state="attached")
        return self

    def resize(self, size: tuple[int, int]) -> None:
        self.page.set_viewport_size({"width": size[0], "height": size[1]})

    def time(self) -> float:
        return float(self.page.locator("#clock").inner_text().split("/")[0])

    def glyph(self, robot: str, kind: str = "pose") -> str | None:
        return self.page.locator(f'.robot[data-robot="{robot}"][data-kind="{kind}"]').get_attribute("transform")

    def slide(self, value: int) -> None:
        self.page.locator("#time").fill(str(value))

    def print_out(self) -> None:
        """Shows the report as it is on paper."""
        self.page.emulate_media(media="print")
        self.page.wait_for_selector("html.printing", state="attached")
        self.until(PLOTS_FIT)

    def until(self, expression: str) -> None:
        """Waits until an expression is true; the page's policy forbids Playwright's own way, which evaluates text."""
        for _ in range(PATIENCE // STEP):
            if self.page.evaluate(expression):
                return
            self.page.wait_for_timeout(STEP)
        raise AssertionError(f"never true: {expression}")

    def _guard(self, route: Route) -> None:
        """Keeps a page from loading anything but itself."""
        if route.request.url.partition("#")[0] == self.address:
            route.continue_()
        else:
            self.problems.append(f"asked for {route.request.url[:200]}")
            route.abort()

    def _dismiss(self, dialog: Dialog) -> None:
        self.problems.append(f"dialog: {dialog.message}")
        dialog.dismiss()

    def _hear(self, said: ConsoleMessage) -> None:
        if said.type in ("error", "warning"):
            self.problems.append(said.text)


Opener = Callable[..., Opened]
