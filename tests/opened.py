"""A report in a browser, and what went wrong with it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import Dialog, Page, Route

PATIENCE, STEP = 30_000, 50  # [ms] for something to happen on a busy machine, and between two looks


@dataclass
class Opened:
    """A page with a report in it; `problems` is what it said, asked for or did that it must not."""

    page: Page
    problems: list[str] = field(default_factory=list)

    def time(self) -> float:
        return float(self.page.locator("#clock").inner_text().split("/")[0])

    def glyph(self, robot: str, kind: str = "pose") -> str | None:
        return self.page.locator(f'.robot[data-robot="{robot}"][data-kind="{kind}"]').get_attribute("transform")

    def slide(self, value: int) -> None:
        self.page.locator("#time").fill(str(value))

    def until(self, expression: str) -> None:
        """Waits until an expression is true; the page's policy forbids Playwright's own way, which evaluates text."""
        for _ in range(PATIENCE // STEP):
            if self.page.evaluate(expression):
                return
            self.page.wait_for_timeout(STEP)
        raise AssertionError(f"never true: {expression}")


Opener = Callable[..., Opened]


def watch(opened: Opened, address: str) -> None:
    """Notes what a page must not do, and keeps it from loading anything but itself."""
    page, problems = opened.page, opened.problems

    def guard(route: Route) -> None:
        if route.request.url.partition("#")[0] == address:
            route.continue_()
        else:
            problems.append(f"asked for {route.request.url[:200]}")
            route.abort()

    def dismiss(dialog: Dialog) -> None:
        problems.append(f"dialog: {dialog.message}")
        dialog.dismiss()

    page.route("**/*", guard)
    page.on("dialog", dismiss)
    page.on("pageerror", lambda error: problems.append(f"error: {error}"))
    page.on("console", lambda said: problems.append(said.text) if said.type in ("error", "warning") else None)
