"""How far work is: in a notebook, in a pipe, to a function, or not at all; in a terminal bars come and go."""

from __future__ import annotations

import queue
import sys
from types import SimpleNamespace

import pytest
from rich.console import Console

from nhtrack.terminal import progress
from nhtrack.terminal.progress import shown_progress


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """A clock that tests set."""
    now = SimpleNamespace(seconds=0.0)
    monkeypatch.setattr(progress.time, "monotonic", lambda: now.seconds)
    return now


def work(wanted: object, clock: SimpleNamespace, seconds: float = 200.0) -> None:
    with shown_progress(wanted) as stage:  # type: ignore[arg-type]
        report = stage("runs")
        for done in range(5):
            report(done, 4)
            clock.seconds += seconds / 4


def test_a_pipe_gets_lines_now_and_then_also_of_work_that_reports_nothing(
    monkeypatch: pytest.MonkeyPatch, clock: SimpleNamespace, capsys: pytest.CaptureFixture[str]
) -> None:
    work(True, clock)  # within less than a minute
    assert capsys.readouterr().err == ""
    told = queue.Queue[str]()
    monkeypatch.setattr(progress, "_LINES", 0.001)
    monkeypatch.setattr(sys, "stderr", SimpleNamespace(write=told.put, flush=lambda: None))

    def wait_for(line: str) -> None:
        while told.get(timeout=10) != line:
            pass

    with shown_progress(True) as stage:
        began = clock.seconds
        wait_for("begun: after 0 s\n")
        report = stage("runs")
        clock.seconds = began + 100.0
        wait_for("runs: after 100 s\n")
        report(2, 4)
        wait_for("runs: 50 % after 100 s\n")


@pytest.mark.parametrize("wanted", [None, False])
def test_a_pipe_gets_nothing_unless_it_is_asked_for(
    wanted: bool | None, clock: SimpleNamespace, capsys: pytest.CaptureFixture[str]
) -> None:
    work(wanted, clock)
    assert capsys.readouterr() == ("", "")


def test_a_function_is_told_everything(clock: SimpleNamespace) -> None:
    told: list[tuple[str, int, int]] = []
    work(lambda *given: told.append(given), clock)
    assert told == [("runs", done, 4) for done in range(5)]


def test_a_terminal_shows_bars_and_clears_them(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], clock: SimpleNamespace
) -> None:
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    monkeypatch.setenv("TERM", "xterm")
    work(None, clock)
    shown = capsys.readouterr().err
    assert "runs" in shown
    assert shown.endswith("\x1b[2K\x1b[1A\x1b[2K") or shown.endswith("\x1b[2K")


def test_a_notebook_shows_bars_below_its_cell_and_clears_them(
    monkeypatch: pytest.MonkeyPatch, clock: SimpleNamespace
) -> None:
    shown: list[object] = []

    def display(bars: object, display_id: bool) -> SimpleNamespace:
        assert display_id
        return SimpleNamespace(update=lambda given, raw=False: shown.append(_text(given) if not raw else given))

    monkeypatch.setitem(sys.modules, "IPython.display", SimpleNamespace(display=display))
    monkeypatch.setattr("rich.console._is_jupyter", lambda: True)
    work(None, clock, seconds=4.0)
    assert "100%" in str(shown[-2])
    assert shown[-1] == {"text/plain": ""}
    assert len(shown) == 5  # four redrawings, a second apart, and the end


def _text(bars: object) -> str:
    console = Console(width=80, force_jupyter=False)
    with console.capture() as captured:
        console.print(bars)
    return captured.get()
