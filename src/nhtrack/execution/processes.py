"""Tasks done in processes of this machine."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, replace
from multiprocessing import get_context, resource_tracker
from multiprocessing.connection import Connection
from typing import Any

from nhtrack.execution.contract import TRIES, Done, EngineError, Executor, Result, Task, WorkerError, cores
from nhtrack.stopping import ASKING

_BEGUN = 2  # tasks a worker: the one it does, and the one it does next


@dataclass(frozen=True)
class Processes(Executor):
    """Does tasks in processes, which end when this one does, whatever ends it; none is begun for a single worker.

    Attributes:
        most: how many at once; one for each core by default.
        ahead: how many tasks may be done beyond the first that is not; all by default.
        begin: called once in every process, before its tasks.
        arguments: what it is called with.
    """

    most: int | None = None
    ahead: int | None = None
    begin: Callable[..., None] | None = None
    arguments: tuple[Any, ...] = ()

    @property
    def workers(self) -> int:
        """How many tasks are done at once."""
        return self.most or cores()

    def __call__(self, tasks: Sequence[Task], work: Callable[[Task], Result]) -> Done[Result]:
        """Does tasks; see `Executor`.

        Raises:
            WorkerError: a process ended.
        """
        workers = min(self.workers, len(tasks))
        if workers <= 1 and self.begin is None:
            for place, task in enumerate(tasks):
                yield place, work(task)
            return
        context = get_context("spawn")
        watched, held = context.Pipe(duplex=False)
        start = (watched, work, self.begin, self.arguments)
        pool = ProcessPoolExecutor(max(1, workers), context, _begin_worker, start)
        begun: dict[Future[Result], int] = {}
        try:
            yield from self._results(pool, tasks, begun, _BEGUN * workers)
            pool.shutdown()
        except BrokenProcessPool as error:
            raise WorkerError(
                "a process that worked for this one ended; a script needs `if __name__ == '__main__':` around what it "
                "does",
                begun.values(),
            ) from error
        finally:
            held.close()  # workers that are still at something end at once
            for worker in list((pool._processes or {}).values()):
                worker.kill()  # nor does anybody wait for those that are still starting
            pool.shutdown(cancel_futures=True)
            watched.close()

    def _results(
        self, pool: ProcessPoolExecutor, tasks: Sequence[Task], waiting: dict[Future[Result], int], most: int
    ) -> Done[Result]:
        begun, ahead = 0, len(tasks) if self.ahead is None else self.ahead
        while begun < len(tasks) or waiting:
            while (
                begun < len(tasks) and len(waiting) < most and begun - min(waiting.values(), default=begun) <= ahead
            ):
                with _undisturbed():
                    waiting[pool.submit(_do, tasks[begun])] = begun
                begun += 1
            for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                result = future.result()  # of one whose process ended there is none, and it waits still
                yield waiting.pop(future), result

    def survived(self, tasks: Sequence[Task], work: Callable[[Task], Result]) -> Done[bool]:
        """Does tasks one after the other in processes of their own; see `Executor`."""
        alone = replace(self, most=1, begin=self.begin or _nothing)
        for place, task in enumerate(tasks):
            yield place, any(_lives(alone, task, work) for _ in range(TRIES))


def executor(workers: int | None, address: str | None) -> Executor:
    """Returns the executor of these options.

    Raises:
        EngineError: its processes are of this machine.
    """
    if address is not None:
        raise EngineError("executor processes works on this machine, which has no address")
    return Processes(workers)


def _lives(alone: Processes, task: Task, work: Callable[[Task], Result]) -> bool:
    """Does a task in a process of its own; returns whether the process has lived through it."""
    try:
        list(alone([task], work))
    except WorkerError:
        return False
    return True


def _nothing() -> None:
    """Does nothing: what is begun so has a process of its own."""


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


_work: Callable[[Any], Any] | None = None  # what this worker does with its tasks


def _begin_worker(
    watched: Connection, work: Callable[[Any], Any], begin: Callable[..., None] | None, arguments: tuple[Any, ...]
) -> None:
    """Lets a process end when the one it works for has closed its end of a pipe, or is gone."""
    global _work
    threading.Thread(target=_end_with, args=(watched,), daemon=True).start()
    _work = work
    if begin is not None:
        begin(*arguments)


def _do(task: Any) -> Any:
    assert _work is not None  # a worker has begun before
    return _work(task)


def _end_with(watched: Connection) -> None:
    watched.poll(None)
    os._exit(1)
