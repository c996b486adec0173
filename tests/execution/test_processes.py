"""Tasks in processes: results, errors, and that no process outlives the one it works for."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import pytest

from nhtrack.execution import Executor, Processes, WorkerError, serial

_PARENT = """
import sys
sys.path.insert(0, {tests!r})
from test_processes import report_and_sleep
from nhtrack.execution import Processes
if __name__ == "__main__":
    for _ in Processes(2)([{folder!r}, {folder!r}], report_and_sleep):
        pass
"""


def square(x: int) -> int:
    return x * x


def fail_at_two(x: int) -> int:
    if x == 2:
        raise ValueError("two")
    return x


def end(x: int) -> None:
    os._exit(3)


def sleep(seconds: float) -> float:
    time.sleep(seconds)
    return seconds


def report_and_sleep(folder: str) -> None:
    (Path(folder) / str(os.getpid())).touch()
    time.sleep(60)


@pytest.mark.parametrize("executor", [serial, Processes(1), pytest.param(Processes(2), marks=pytest.mark.slow)])
def test_every_task_is_done_once_and_has_its_place(executor: Executor) -> None:
    assert sorted(executor(range(9), square)) == [(x, x * x) for x in range(9)]
    assert list(executor([], square)) == []


@pytest.mark.parametrize("executor", [serial, pytest.param(Processes(2), marks=pytest.mark.slow)])
def test_what_a_task_raises_is_raised_here(executor: Executor) -> None:
    with pytest.raises(ValueError, match="two"):
        list(executor(range(5), fail_at_two))


@pytest.mark.slow
def test_a_process_that_ends_is_told() -> None:
    with pytest.raises(WorkerError, match="ended"):
        list(Processes(2)(range(2), end))
    assert not multiprocessing.active_children()


@pytest.mark.slow
def test_tasks_run_no_further_ahead_than_allowed() -> None:
    places = [place for place, _ in Processes(2, ahead=1)([2.0, 0.0, 0.0, 0.0], sleep)]
    assert places.index(0) < min(places.index(2), places.index(3))  # which wait for the first


@pytest.mark.slow
def test_processes_end_with_the_iterator() -> None:
    begin = time.monotonic()
    with closing(Processes(2)([0.0, 30.0, 0.0, 30.0], sleep)) as results:
        assert {next(results)[0], next(results)[0]} == {0, 2}
    assert time.monotonic() - begin < 20  # else it waited for those that sleep
    assert not multiprocessing.active_children()


@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGKILL])
def test_no_process_outlives_the_one_it_works_for(how: int, tmp_path: Path) -> None:
    script = tmp_path / "parent.py"
    workers = tmp_path / "workers"
    workers.mkdir()
    script.write_text(_PARENT.format(tests=str(Path(__file__).parents[0]), folder=str(workers)))
    parent = subprocess.Popen([sys.executable, str(script)], stderr=subprocess.DEVNULL)
    _wait_for(lambda: len(list(workers.iterdir())) == 2)
    parent.send_signal(how)
    parent.wait()
    _wait_for(lambda: not any(_is_alive(int(worker.name)) for worker in workers.iterdir()))


def _is_alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    stat = Path(f"/proc/{pid}/stat")
    return not stat.exists() or stat.read_text().rpartition(")")[2].split()[0] != "Z"


def _wait_for(condition) -> None:  # type: ignore[no-untyped-def]
    until = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < until
        time.sleep(0.02)
