"""What an executor is."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Iterable, Sequence
from typing import TypeAlias, TypeVar

from nhtrack.errors import NhtrackError, RefusedError

Task = TypeVar("Task")
Result = TypeVar("Result")
# The place of each task and its result.
Done: TypeAlias = Generator[tuple[int, Result], None, None]

TRIES = 3  # workers that a task may end before it is given up


class EngineError(RefusedError):
    """An executor that cannot be had as it was asked for; nothing was run."""


class WorkerError(NhtrackError):
    """A worker that ended before its work was done.

    Attributes:
        suspects: the places of the tasks that it may have ended with.
    """

    def __init__(self, message: str, suspects: Iterable[int] = ()) -> None:
        self.suspects = tuple(sorted(suspects))
        super().__init__(message)


class Executor(ABC):
    """Does tasks.

    A task may be done twice, where its worker is lost, and in any order: what it writes has to be the same each time,
    and to appear whole. `work` goes to each worker once, tasks one by one: what all of them need belongs to it.
    """

    @property
    @abstractmethod
    def workers(self) -> int:
        """How many tasks are done at once."""

    @abstractmethod
    def __call__(self, tasks: Sequence[Task], work: Callable[[Task], Result]) -> Done[Result]:
        """Yields the place of each task and its result, in the order in which they are done.

        What a task raises is raised here, and the others are given up; so they are where the iterator is closed.

        Raises:
            WorkerError: workers ended, whichever task it was of; those that are not suspects may not have been done.
        """

    @abstractmethod
    def survived(self, tasks: Sequence[Task], work: Callable[[Task], Result]) -> Done[bool]:
        """Yields the place of each task and whether it was done before it ended `TRIES` workers.

        Each has a worker of its own, so that none is blamed for another.
        """

    @property
    def elsewhere(self) -> bool:
        """Whether tasks may be done on machines that are not this one, or by another installation."""
        return False

    def everywhere(self, work: Callable[[], Result]) -> list[tuple[str, Result]]:
        """Returns what each machine that is asked answers, with its name; none is where no task is done elsewhere."""
        return []


def cores() -> int:
    """Returns how many processes work side by side where nothing else is said."""
    return os.cpu_count() or 1
