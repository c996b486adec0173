"""Tasks done by Ray, on this machine or on a cluster of many (docs/scaling.md).

Ray tells with which task a worker ended or a machine was lost. That task is done again, by whoever is left.
"""

from __future__ import annotations

import logging
import os
import signal
import socket
import subprocess
import sys
import threading
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from nhtrack.execution.contract import TRIES, Done, EngineError, Executor, Result, Task, WorkerError, cores
from nhtrack.stopping import ASKING

_QUEUED = 100  # tasks beyond those that are done at once: what machines find that come later
_STORE = 10**8  # [bytes] of the object store of a Ray of our own: tasks write files, and nothing large is sent
_PATIENCE = 5.0  # [s] in which an address has to answer
_HEALTHY = 20.0  # [s] in which Ray has to be found there
_OURS = "nhtrack"  # Ray's name for what is connected here, and not by the program that uses this package
_HERE = "local"  # Ray's word for one of our own
_CHECKED = 600.0  # [s] in which every machine has to, where it may have to compile first
# Ray tells its makers nothing, says nothing of accelerators, leaves in its logs what workers and machines say, and lets
# workers of its own have as much of this machine as other processes.
_SETTINGS = {
    "RAY_USAGE_STATS_ENABLED": "0",
    "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "0",
    "RAY_DEDUP_LOGS_SKIP_REGEX": ".",
    "RAY_worker_niceness": "0",
}


@dataclass(frozen=True)
class Ray(Executor):
    """Does tasks by Ray, one on each of its processors.

    What is not connected to Ray yet is connected when the first task is done, and stays so until the process ends or
    tasks are given up, which ends those that are running. Over a connection of the caller's own they are done all the
    same.

    Attributes:
        address: of a cluster that this machine belongs to, `host:port` or `auto`; RAY_ADDRESS by default. Without any,
            a Ray is started that works on this machine and ends with this process.
        most: how many at once; all processors by default.
    """

    address: str | None = None
    most: int | None = None

    @property
    def workers(self) -> int:
        """How many tasks are done at once.

        Raises:
            EngineError: Ray is not installed, does not answer, or has no processors.
        """
        there = int(self._connected().cluster_resources().get("CPU", 0))
        if there < 1:
            raise EngineError("executor ray: no machine of this cluster has a processor for tasks")
        return min(there, self.most or there)

    def __call__(self, tasks: Sequence[Task], work: Callable[[Task], Result]) -> Done[Result]:
        """Does tasks; see `Executor`. A task that ends its workers delays no other.

        Raises:
            WorkerError: a task ended its workers, `TRIES` of them.
        """
        ended = dict[int, str]()
        for place, lived, result in self._results(tasks, work):
            if lived:
                yield place, result
            else:
                ended[place] = str(result)
        if ended:
            said = next(iter(ended.values())).partition("\n")[0]
            raise WorkerError(f"a worker of the cluster ended, {TRIES} times with the same task: {said}", ended)

    def survived(self, tasks: Sequence[Task], work: Callable[[Task], Result]) -> Done[bool]:
        """Does tasks, as always; see `Executor`."""
        for place, lived, _ in self._results(tasks, work):
            yield place, lived

    @property
    def elsewhere(self) -> bool:
        """Whether Ray is one that was there before: its workers may be of any machine and installation."""
        return self._where != _HERE

    def everywhere(self, work: Callable[[], Result]) -> list[tuple[str, Result]]:
        """Returns what each machine of a cluster answers; see `Executor`.

        Raises:
            EngineError: one does not answer.
        """
        ray = self._connected()
        from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy

        asked, shared = {}, ray.put(work)
        for node in ray.nodes():
            if node["Alive"] and node["Resources"].get("CPU"):
                there = NodeAffinitySchedulingStrategy(node["NodeID"], soft=False)
                do = ray.remote(num_cpus=0, max_retries=0, scheduling_strategy=there)(_do)
                asked[f"{node['NodeManagerAddress']} (node {node['NodeID'][:8]})"] = do.remote(_call, shared)
        answers = ((name, _answer(ray, name, answer)) for name, answer in asked.items())
        return [(name, *found) for name, found in answers if found]

    def _results(self, tasks: Sequence[Task], work: Callable[[Task], Any]) -> Iterator[tuple[int, bool, Any]]:
        """Yields the place of each task, whether a worker lived through it, and its result or what was said."""
        if not tasks:
            return
        ray, most = self._connected(), self.most or self.workers + _QUEUED
        do, shared = ray.remote(num_cpus=1, max_retries=0)(_do), ray.put(work)
        left, running, tries = deque(range(len(tasks))), dict[Any, int](), Counter[int]()
        try:
            while left or running:
                while left and len(running) < most:
                    place = left.popleft()
                    running[do.remote(shared, tasks[place])] = place
                for done in ray.wait(list(running))[0]:
                    place = running.pop(done)
                    try:
                        result = ray.get(done)
                    except ray.exceptions.RayTaskError as error:
                        raise _own(error) from None
                    except ray.exceptions.RayError as error:
                        tries[place] += 1
                        if tries[place] == TRIES:
                            yield place, False, error
                        else:
                            left.append(place)
                    else:
                        yield place, True, result
        finally:
            if running and ray.get_runtime_context().namespace == _OURS:
                ray.shutdown()  # Ray's way to cancel a task ends this process at times, where the task is just done

    def _connected(self) -> Any:
        """Returns Ray, connected to.

        Raises:
            EngineError: it is not installed, or does not answer.
        """
        for name, value in _SETTINGS.items():
            os.environ.setdefault(name, value)
        try:
            import ray
        except ImportError as error:
            raise EngineError("executor ray: Ray is not installed; pip install 'nhtrack[ray]'") from error
        if ray.is_initialized():
            return ray
        if self._where != _HERE:
            _require_answer(self._where)
        how = {"namespace": _OURS, "log_to_driver": False, "logging_level": logging.ERROR}
        if self._where == _HERE:
            how |= {"num_cpus": self.most or cores(), "object_store_memory": _STORE, "include_dashboard": False}
        try:
            with _our_signals():
                ray.init(self._where, **how)
        except Exception as error:
            said = str(error).strip().partition("\n")[0]
            raise EngineError(f"executor ray: no Ray at address {self._where!r}: {said}") from error
        return ray

    @property
    def _where(self) -> str:
        return self.address or os.environ.get("RAY_ADDRESS") or _HERE


def executor(workers: int | None, address: str | None) -> Executor:
    """Returns the executor of these options."""
    return Ray(address, workers)


def _do(work: Callable[[Task], Result], task: Task) -> Result:
    return work(task)


def _call(work: Callable[[], Result]) -> Result:
    return work()


def _answer(ray: Any, name: str, answer: Any) -> tuple[Any, ...]:
    """Returns what a machine answers, nothing where it is gone, which Ray learns after a while.

    Raises:
        EngineError: it does not answer.
    """
    try:
        return (ray.get(answer, timeout=_CHECKED),)
    except (ray.exceptions.TaskUnschedulableError, ray.exceptions.NodeDiedError):
        return ()
    except ray.exceptions.RayTaskError as error:
        raise _own(error) from None
    except ray.exceptions.RayError as error:
        raise EngineError(f"executor ray: {name} does not answer: {str(error).partition(chr(10))[0]}") from error


def _own(error: Any) -> BaseException:
    """Returns what a task raised, without Ray's account of it."""
    cause = getattr(error, "cause", None)
    return cause if isinstance(cause, BaseException) else error


def _require_answer(address: str) -> None:
    """Raises where no Ray answers at an address: Ray itself would wait for minutes, or end this process.

    Raises:
        EngineError: none does, or it is no address.
    """
    host, _, port = address.rpartition(":")
    if address != "auto" and not (host and port.isdigit()):
        raise EngineError(f"executor ray: expected an address such as 10.0.0.1:6379, or auto, got {address!r}")
    try:
        if address != "auto":
            socket.create_connection((host, int(port)), _PATIENCE).close()
        subprocess.run(
            [sys.executable, "-m", "ray.scripts.scripts", "health-check", "--address", address],
            stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=_HEALTHY, check=True,
        )  # fmt: skip
    except OSError as error:
        raise EngineError(f"executor ray: no answer at address {address!r}: {error.strerror or error}") from error
    except subprocess.SubprocessError as error:
        last = str(getattr(error, "stderr", "") or "").strip().rpartition("\n")[2]
        said = last.rpartition("Error: ")[2].partition(". ")[0]
        raise EngineError(f"executor ray: no Ray answers at address {address!r}{said and f': {said}'}") from error


@contextmanager
def _our_signals() -> Iterator[None]:
    """Keeps what this process does when it is asked to end: Ray would leave at once, whatever is being tidied up."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.getsignal(number) for number in ASKING}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
