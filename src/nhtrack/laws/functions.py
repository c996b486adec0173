"""The functions of a law, with all that they call, as Python or as compiled code.

Both are copies: the law's own file is left as its author wrote it.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from types import FunctionType, ModuleType
from typing import Any

from nhtrack.compiled import compiled

Function = Callable[..., Any]


def as_python(function: Function) -> Function:
    """Returns a function that calls, all the way down, the Python of compiled functions: its errors have lines."""
    return _Python().copy(function)


class _Python:
    """Copies functions with what they call; each once."""

    def __init__(self) -> None:
        self._made: dict[int, Function] = {}
        self._spaces: dict[int, dict[str, Any]] = {}

    def copy(self, function: Any) -> Function:
        plain = python_of(function)
        if plain is None:
            found: Function = function
            return found
        if id(plain) not in self._made:
            space, fresh = self._space(plain.__globals__)
            self._made[id(plain)] = _copy(plain, space)
            if fresh:
                space.update({name: self.value(value) for name, value in plain.__globals__.items()})
        return self._made[id(plain)]

    def _space(self, names: dict[str, Any]) -> tuple[dict[str, Any], bool]:
        fresh = id(names) not in self._spaces
        return self._spaces.setdefault(id(names), dict(names)), fresh

    def value(self, value: Any) -> Any:
        """Returns what stands for a global: a copy of a compiled function or of one that may call such."""
        if isinstance(value, ModuleType) and value.__name__.startswith("nhtrack."):
            return _Inside(value, self)
        plain = python_of(value)
        if plain is None or (plain is value and plain.__module__.partition(".")[0] in _LIBRARIES):
            return value
        return self.copy(value)


class _Inside:
    """A module whose compiled functions are called as Python."""

    def __init__(self, module: ModuleType, copies: _Python) -> None:
        self._module, self._copies = module, copies

    def __getattr__(self, name: str) -> Any:
        return self._copies.value(getattr(self._module, name))


def as_compiled(home: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the names of a law's file with all functions that it defines to be compiled, decorated or not.

    None of them is cached by itself: numba would not notice that something they call has changed.
    """
    space = dict(home)
    for name, value in home.items():
        plain = python_of(value)
        if plain is not None and plain.__globals__ is home:
            space[name] = compiled(_copy(plain, space))
    return space


def python_of(value: Any) -> FunctionType | None:
    """Returns the Python of a function, compiled or not; None for anything else."""
    plain = getattr(value, "py_func", value)
    return plain if isinstance(plain, FunctionType) else None


def _copy(function: FunctionType, space: dict[str, Any]) -> Function:
    copied = FunctionType(function.__code__, space, function.__name__, function.__defaults__, function.__closure__)
    copied.__kwdefaults__ = function.__kwdefaults__
    return copied


def texts_reached(home: Mapping[str, Any]) -> list[str]:
    """Returns the text of every other module that a law's file takes something from, and the numbers it takes.

    Code that was compiled is out of date as soon as one of them changes. Libraries are not among them, and the package
    keeps account of its own.
    """
    found: dict[str, str] = {}
    numbers: list[str] = []
    waiting = [home]
    while waiting:
        for name, value in sorted(waiting.pop().items()):
            if isinstance(value, (int, float, str, tuple)) and not name.startswith("__"):
                numbers.append(f"{name} = {value!r}")
                continue
            label = value.__name__ if isinstance(value, ModuleType) else getattr(value, "__module__", None)
            module = sys.modules.get(label) if isinstance(label, str) else None
            file = getattr(module, "__file__", None)
            if module is None or not file or module.__dict__ is home or module.__name__ in found:
                continue
            if module.__name__.partition(".")[0] not in _LIBRARIES and file.endswith(".py"):
                with open(file, encoding="utf-8") as opened:
                    found[module.__name__] = opened.read()
                waiting.append(module.__dict__)
    return [*(text for _, text in sorted(found.items())), *numbers]


_LIBRARIES = frozenset({"nhtrack", "numpy", "numba", "scipy", "llvmlite", *sys.stdlib_module_names})
