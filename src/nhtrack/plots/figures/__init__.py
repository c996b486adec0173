"""The figures of a run, one file each: its function has the name of its file and of the figure.

It is called with the recording and, where it has an argument `events`, with the run's; it returns None where it has
nothing to say of a run.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from types import MappingProxyType
from typing import TypeAlias

from matplotlib.figure import Figure

Draw: TypeAlias = Callable[..., Figure | None]


@cache
def run_figures() -> Mapping[str, Draw]:
    """Returns what draws each figure of a run, by its name."""
    names = [module.name for module in iter_modules(__path__)]
    return MappingProxyType({name: getattr(import_module(f"{__name__}.{name}"), name) for name in names})
