"""In which lines a law's file does not keep the contract, and how."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator
from types import ModuleType
from typing import Any, get_type_hints

from nhtrack.laws.contract import Gain
from nhtrack.laws.slots import is_number, is_numbers

Fault = tuple[int, str]

# A gain is a key beside these in the section `law` of a file, and an attribute of its class.
RESERVED = frozenset({
    "construct", "copy", "delay_periods", "dict", "file", "from_orm", "gains", "json", "kind", "limits", "name",
    "parse_file", "parse_obj", "parse_raw", "robot_gain", "schema", "schema_json", "update_forward_refs", "validate",
})  # fmt: skip

SIGNATURES = {
    "command": "command(gains, period, limits, follower, leader, memory) -> (u_x, u_theta, memory)",
    "init": "init(gains, period, follower, leader) -> Memory",
    "warnings": "warnings(gains, limits) -> tuple[str, ...]",
    "beyond": "beyond(gains, period, leader) -> tuple[str, ...]",
}
_ARGUMENTS = {"command": 6, "init": 4, "warnings": 2, "beyond": 3}
_BASE = r"(?:L|T|m|s|rad)(?:\^\d+)?"
_PRODUCT = rf"{_BASE}(?:\*{_BASE})*"
_UNIT = re.compile(rf"(?:1|{_PRODUCT})(?:/(?:{_BASE}|\({_PRODUCT}\)))?")


def contract_faults(module: ModuleType, source: str) -> list[Fault]:
    """Returns the lines in which a module does not keep the contract, and what is wrong there."""
    lines = _lines(source)
    return [*_function_faults(module, lines), *_class_faults(module, lines)]


def _lines(source: str) -> dict[str, int]:
    """Returns the lines of functions and classes by their names, and of the fields of classes as `Class.field`."""
    found = {}
    for node in ast.parse(source.lstrip("\ufeff")).body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            found[node.name] = node.lineno
        if isinstance(node, ast.ClassDef):
            for inner in node.body:
                if isinstance(inner, ast.AnnAssign) and isinstance(inner.target, ast.Name):
                    found[f"{node.name}.{inner.target.id}"] = inner.lineno
    return found


def _function_faults(module: ModuleType, lines: dict[str, int]) -> Iterator[Fault]:
    remembers = hasattr(module, "Memory")
    for name, count in _ARGUMENTS.items():
        function = getattr(module, name, None)
        if function is None:
            if name == "command" or (name == "init" and remembers):
                yield lines.get("Memory", 1) if name == "init" else 1, f"no function `{name}`: {SIGNATURES[name]}"
        elif not callable(function):
            yield lines.get(name, 1), f"`{name}` is no function; expected {SIGNATURES[name]}"
        elif not _takes(function, count):
            yield lines.get(name, 1), f"`{name}` takes other arguments; expected {SIGNATURES[name]}"
        elif name == "init" and not remembers:
            yield lines.get(name, 1), "`init` without `Memory`: the NamedTuple that it returns, or leave `init` out"


def _takes(function: Any, count: int) -> bool:
    """Returns whether a function can be called with so many arguments and has no others."""
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        return False
    return len(parameters) == count and all(each.kind in _POSITIONAL for each in parameters)


_POSITIONAL = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)


def _class_faults(module: ModuleType, lines: dict[str, int]) -> Iterator[Fault]:
    for name in ("Gains", "Memory"):
        kind, line = getattr(module, name, None), lines.get(name, 1)
        if kind is None:
            if name == "Gains":
                yield line, "no class `Gains`: a NamedTuple of the law's gains, each a float; `pass` where it has none"
        elif not (isinstance(kind, type) and issubclass(kind, tuple) and hasattr(kind, "_fields")):
            yield line, f"`{name}` is not a NamedTuple"
        else:
            try:
                hints = get_type_hints(kind, include_extras=True)
            except Exception as error:
                yield line, f"`{name}`: the type of a field cannot be read: {error}"
                continue
            for field in kind._fields:
                for message in _field_faults(kind, field, hints[field]):
                    yield lines.get(f"{name}.{field}", line), f"`{name}.{field}`: {message}"


def _field_faults(kind: Any, field: str, hint: Any) -> Iterator[str]:
    number = getattr(hint, "__origin__", hint) if hasattr(hint, "__metadata__") else hint
    many = kind.__name__ == "Memory"
    if not (is_number(number) or (many and is_numbers(number))):
        tuples = ", or a tuple of so many of them such as tuple[float, float]" if many else ""
        yield f"expected float, int or bool{tuples}, got {_shown(number)}"
        return
    if kind.__name__ == "Gains":
        if field in RESERVED or field.startswith("model_"):
            yield "no gain can have this name; it means something else in scenarios"
        default = kind._field_defaults.get(field)
        if default is not None and not isinstance(default, (int, float)):
            yield f"its default is no number: {default!r}"
            return
        for gain in getattr(hint, "__metadata__", ()):
            if isinstance(gain, Gain):
                yield from _gain_faults(field, number, gain, default)


def _shown(hint: Any) -> str:
    return hint.__name__ if isinstance(hint, type) and not hasattr(hint, "__args__") else str(hint)


def _gain_faults(field: str, number: Any, gain: Gain, default: float | None) -> Iterator[str]:
    if not _UNIT.fullmatch(gain.unit):
        yield f"no unit {gain.unit!r}; lengths L and times T such as '1', '1/T^2', 'L/T', '1/(L*T)', or robot units"
    if gain.search is not None and not 0 < gain.search[0] < gain.search[1]:
        yield f"search: expected 0 < low < high, got {gain.search}"
    if gain.choices and number is not int:
        yield "a gain with `choices` is an int: the number of the one chosen"
    if gain.section and not field.startswith(f"{gain.section}_"):
        yield f"a gain in the section {gain.section!r} is called {gain.section}_..."
    if default is not None:
        for bound, kept, words in (
            (gain.above, gain.above is None or default > gain.above, "above"),
            (gain.least, gain.least is None or default >= gain.least, "at least"),
            (gain.below, gain.below is None or default < gain.below, "below"),
        ):
            if not kept:
                yield f"its default {default:g} is not {words} {bound:g}"
        if gain.choices and default not in range(len(gain.choices)):
            yield f"its default {default:g} is none of its {len(gain.choices)} choices"
