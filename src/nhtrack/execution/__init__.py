"""Tasks done side by side, by an executor: in this process, in processes of their own, or on a cluster.

An executor (`contract`) is called with tasks and with what is to be done with each, and yields the place of a task and
its result as they are done. A module beside this one that defines `executor` is an engine of its name (`engines`).
"""

from nhtrack.execution.contract import TRIES, Done, EngineError, Executor, WorkerError, cores
from nhtrack.execution.engines import engine_names, executor_of
from nhtrack.execution.processes import Processes
from nhtrack.execution.serial import Serial, serial

__all__ = [
    "TRIES",
    "Done",
    "EngineError",
    "Executor",
    "Processes",
    "Serial",
    "WorkerError",
    "cores",
    "engine_names",
    "executor_of",
    "serial",
]
