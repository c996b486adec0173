"""The engines there are: the modules of this room that make an executor."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from nhtrack.errors import did_you_mean
from nhtrack.execution.contract import EngineError, Executor

_ROOM = __name__.rpartition(".")[0]


@cache
def engine_names() -> tuple[str, ...]:
    """Returns the names of the engines: of the modules that define `executor(workers, address)`."""
    names = sorted(module.name for module in iter_modules(import_module(_ROOM).__path__))
    return tuple(name for name in names if hasattr(import_module(f"{_ROOM}.{name}"), "executor"))


def executor_of(engine: str, workers: int | None = None, address: str | None = None) -> Executor:
    """Returns the executor of an engine.

    Args:
        engine: its name; see `engine_names`.
        workers: how many tasks at once; what the engine has by default.
        address: of the machines that do them, where the engine works elsewhere.

    Raises:
        EngineError: there is no such engine, or it cannot be had so.
    """
    if engine not in engine_names():
        raise EngineError(f"no executor {engine!r}; {did_you_mean(engine, engine_names())}")
    made: Executor = import_module(f"{_ROOM}.{engine}").executor(workers, address)
    return made
