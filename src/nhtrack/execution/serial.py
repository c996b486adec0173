"""Tasks done here, one after the other."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from nhtrack.execution.contract import Done, EngineError, Executor, Result, Task
from nhtrack.execution.processes import Processes


class Serial(Executor):
    """Does one task after the other, in this process."""

    workers = 1

    def __call__(self, tasks: Sequence[Task], work: Callable[[Task], Result]) -> Done[Result]:
        """Does tasks; see `Executor`."""
        for place, task in enumerate(tasks):
            yield place, work(task)

    def survived(self, tasks: Sequence[Task], work: Callable[[Task], Result]) -> Done[bool]:
        """Does tasks in processes of their own; see `Executor`."""
        return Processes(1).survived(tasks, work)


serial = Serial()


def executor(workers: int | None, address: str | None) -> Executor:
    """Returns the executor of these options.

    Raises:
        EngineError: it works neither elsewhere nor side by side.
    """
    if address is not None or (workers or 1) > 1:
        raise EngineError("executor serial does one task after the other, here: no address, and one process")
    return serial
