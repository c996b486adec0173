"""How far work is: bars in terminals and notebooks, a line a minute into anything else."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from rich.progress import Progress

# Called with the work done and the whole of it.
Report: TypeAlias = Callable[[int, int], None]
# Called with the name of a stage of work; returns what to report its progress to.
Stage: TypeAlias = Callable[[str], Report]
# Called with the name of a stage, the work done and the whole of it.
Observer: TypeAlias = Callable[[str, int, int], None]
# Called with a warning.
Tell: TypeAlias = Callable[[str], None]

_LINES = 60.0  # [s] between lines that are not drawn over each other
_REDRAWN = 0.25  # [s] between drawings in a notebook


@contextmanager
def shown_progress(wanted: bool | Observer | None = True) -> Iterator[Stage]:
    """Shows how far the work within is; yields what opens a stage of it by its name.

    Args:
        wanted: True shows bars in a terminal (on stderr) or a notebook, and a line a minute on any other stderr; None
            shows bars alone; False nothing. A function is called with a stage, the work done and the whole of it.
    """
    if callable(wanted):
        yield _told_to(wanted)
        return
    if wanted is False:
        yield _told_to(lambda name, done, total: None)
        return
    from rich.console import Console

    console = Console(stderr=True)
    if console.is_jupyter:
        with _notebook_bars() as stage:
            yield stage
    elif console.is_terminal:
        with _bars(console) as bars:
            yield _drawn_by(bars)
    elif wanted:
        with _lines() as stage:
            yield stage
    else:
        yield _told_to(lambda name, done, total: None)


def _told_to(observer: Observer) -> Stage:
    return lambda name: lambda done, total: observer(name, done, total)


def _bars(console: object = None) -> Progress:
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    columns = TextColumn("{task.description:12}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn()
    return Progress(*columns, console=console, transient=True)  # type: ignore[arg-type]


def _drawn_by(bars: Progress, draw: Callable[[], None] | None = None) -> Stage:
    def stage(name: str) -> Report:
        task = bars.add_task(name, total=None)

        def report(done: int, total: int) -> None:
            bars.update(task, completed=done, total=total)
            if draw is not None:
                draw()

        return report

    return stage


@contextmanager
def _notebook_bars() -> Iterator[Stage]:
    """Shows bars below a cell while it works; rich would do so with widgets, which not every notebook has."""
    bars, shown = _bars(), import_module("IPython.display")
    handle = shown.display(bars, display_id=True)
    last = time.monotonic()

    def draw() -> None:
        nonlocal last
        if time.monotonic() - last >= _REDRAWN:
            handle.update(bars)
            last = time.monotonic()

    try:
        yield _drawn_by(bars, draw)
    finally:
        handle.update({"text/plain": ""}, raw=True)


@contextmanager
def _lines() -> Iterator[Stage]:
    """Writes a line a minute on stderr, for logs, also of work that reports nothing for longer."""
    began, over = time.monotonic(), threading.Event()
    at = ("", 0, 0)

    def stage(name: str) -> Report:
        def report(done: int, total: int) -> None:
            nonlocal at
            at = name, done, total

        report(0, 0)
        return report

    def tell() -> None:
        while not over.wait(_LINES):
            name, done, total = at
            share = f"{100 * done / total:.0f} % " if total else ""
            sys.stderr.write(f"{name or 'begun'}: {share}after {time.monotonic() - began:.0f} s\n")
            sys.stderr.flush()

    teller = threading.Thread(target=tell, daemon=True)
    teller.start()
    try:
        yield stage
    finally:
        over.set()
        teller.join()
