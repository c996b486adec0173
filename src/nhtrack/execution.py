"""Tasks done side by side, by an executor: in this process, or in processes of their own.

An executor is called with tasks and with what is to be done with each, and yields the place of a task and its result as
they are done. Another engine, such as a cluster, is another executor.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context, resource_tracker
from multiprocessing.connection import Connection
from typing import Any, Protocol, TypeAlias, TypeVar

from nhtrack.errors import NhtrackError
from nhtrack.stopping import ASKING

Task = TypeVar("Task")
Result = TypeVar("Result")
# The place of each task and its result.
Done: TypeAlias = Generator[tuple[int, Result], None, None]


class WorkerError(NhtrackError):
    """A process that ended before its work was done."""


class Executor(Protocol):
    """Does tasks."""

    def __call__(self, tasks: Sequence[Task], work: Callable[[Task], Result]) -> Done[Result]:
        """Yields the place of each task and its result, in the order in which they are done.

        What a task raises is raised here, and the others are given up; so they are where the iterator is closed.
        """
        ...


def serial(tasks: Sequence[Task], work: Callable[[Task], Result]) -> Done[Result]:
    """Does one task after the other, here."""
    for place, task in enumerate(tasks):
        yield place, work(task)


@dataclass(frozen=True)
class Processes:
    """Does tasks in processes, which end when this one does, whatever ends it; none is begun for a single worker.

    Attributes:
        workers: how many at once; one for each core by default.
        ahead: how many tasks may be done beyond the first that is not; all by default.
        begin: called once in every process, before its tasks.
        arguments: what it is called with.
    """

    workers: int | None = None
    ahead: int | None = None
    begin: Callable[..., None] | None = None
    arguments: tuple[Any, ...] = ()

    def __call__(self, tasks: Sequence[Task], work: Callable[[Task], Result]) -> Done[Result]:
        """Does tasks; see `Executor`.

        Raises:
            WorkerError: a process ended.
        """
        workers = min(self.workers or cores(), len(tasks))
        if workers <= 1 and self.begin is None:
            yield from serial(tasks, work)
            return
        context = get_context("spawn")
        watched, held = context.Pipe(duplex=False)
        start = (watched, self.begin, self.arguments)
        pool = ProcessPoolExecutor(max(1, workers), context, _begin_worker, start)
        try:
            yield from self._results(pool, tasks, work)
            pool.shutdown()
        except BrokenProcessPool as error:
            raise WorkerError(
                "a process that worked for this one ended; a script needs `if __name__ == '__main__':` around what it "
                "does"
            ) from error
        finally:
            held.close()  # workers that are still at something end at once
            for worker in list((pool._processes or {}).values()):
                worker.kill()  # nor does anybody wait for those that are still starting
            pool.shutdown(cancel_futures=True)
            watched.close()

    def _results(
        self, pool: ProcessPoolExecutor, tasks: Sequence[Task], work: Callable[[Task], Result]
    ) -> Done[Result]:
        waiting: dict[Future[Result], int] = {}
        begun, ahead = 0, len(tasks) if self.ahead is None else self.ahead
        while begun < len(tasks) or waiting:
            while begun < len(tasks) and begun - min(waiting.values(), default=begun) <= ahead:
                with _undisturbed():
                    waiting[pool.submit(work, tasks[begun])] = begun
                begun += 1
            for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                yield waiting.pop(future), future.result()


def cores() -> int:
    """Returns how many processes work side by side where nothing else is said."""
    return os.cpu_count() or 1


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Lets processes that are started within hear nothing that asks them to end, not even while they start.

    A terminal asks all processes in it; the one that others work for says when they are to stop.
    """
    resource_tracker.ensure_running()  # to start it later would let this thread hear again
    heard = signal.pthread_sigmask(signal.SIG_BLOCK, ASKING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, heard)


def _begin_worker(watched: Connection, begin: Callable[..., None] | None, arguments: tuple[Any, ...]) -> None:
    """Lets a process end when the one it works for has closed its end of a pipe, or is gone."""
    threading.Thread(target=_end_with, args=(watched,), daemon=True).start()
    if begin is not None:
        begin(*arguments)


def _end_with(watched: Connection) -> None:
    watched.poll(None)
    os._exit(1)
