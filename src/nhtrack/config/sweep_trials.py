"""Values of a sweep that are tried before anything is run, each in the scenario by itself."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path as FilePath
from typing import Any

from nhtrack import assets
from nhtrack.config.changes import value_text
from nhtrack.config.sweep import Choices, LogUniform, Normal, Spread, Sweep, Uniform
from nhtrack.config.tree import Path, parse_path
from nhtrack.robots.contract import is_robot_file

_MOST = 24  # values of an axis that are tried; of more, some evenly among them


def located(sweep: Sweep, directory: FilePath) -> Sweep:
    """Returns a sweep with full paths of the files it names, which are relative to a folder."""
    base = sweep.base if sweep.base in assets.bundled_scenarios() else os.path.abspath(directory / sweep.base)
    changes = {key: _found(key, value, directory) for key, value in sweep.set.items()}
    axes = {key: _axis_found(key, axis, directory) for key, axis in sweep.axes.items()}
    return sweep.model_copy(update={"base": base, "set": changes, "axes": axes})


def _axis_found(key: str, axis: Any, directory: FilePath) -> Any:
    if isinstance(axis, tuple):
        return tuple(_found(key, value, directory) for value in axis)
    if isinstance(axis, Choices):
        choices = {label: _found(key, value, directory) for label, value in axis.choices.items()}
        return axis.model_copy(update={"choices": choices})
    return axis


def _found(key: str, value: Any, directory: FilePath) -> Any:
    """Returns a value with the full path of the law's, the robot's or the input's file that it names, if any."""
    if key in ("law", "robot") and isinstance(value, Mapping) and isinstance(value.get("file"), str):
        return {**value, "file": _found(f"{key}.file", value["file"], directory)}
    if key == "leader" and isinstance(value, Mapping) and "input" in value:
        return {**value, "input": _table_found(value["input"], directory)}
    if key.startswith("leader.input"):
        return _table_found(value, directory)
    law = key == "law.file" or (key == "law" and str(value).endswith(".py"))
    robot = key in ("robot", "robot.file") and isinstance(value, str) and is_robot_file(value)
    return os.path.abspath(directory / value) if isinstance(value, str) and (law or robot) else value


def _table_found(value: Any, directory: FilePath) -> Any:
    """Returns a value of an input with the full path of the file that it names, if there is one."""
    if isinstance(value, Mapping):
        return {name: _table_found(each, directory) for name, each in value.items()}
    named = isinstance(value, str) and "\0" not in value and os.path.isfile(directory / value)
    return os.path.abspath(directory / value) if named else value


def trials(sweep: Sweep) -> Iterator[tuple[Path, list[str], list[str]]]:
    """Yields places in a sweep's file, the change of its scenario that is asked for there, and it among others.

    A value is right that is so by itself, or with the first values of all other axes, such as a gain of a law on one.
    """
    places = {key: list(_places(sweep, key)) for key in sweep.axes}
    first = {key: values[0][1] for key, values in places.items()}
    for key, values in places.items():
        for place, value in values:
            yield place, change_texts({key: value}), change_texts({**first, key: value})


def change_texts(values: Mapping[str, Any]) -> list[str]:
    """Returns changes as on the command line: sections before what is in them."""
    return [f"{key}={value_text(values[key])}" for key in ordered(values)]


def ordered(keys: Iterable[str]) -> list[str]:
    """Returns keys in the order in which they are changed: sections before what is in them."""
    return sorted(keys, key=lambda key: len(parse_path(key)))


def _places(sweep: Sweep, key: str) -> Iterator[tuple[Path, Any]]:
    axis, here = sweep.axes[key], ("axes", key)
    if isinstance(axis, Choices):
        yield from ((((*here, "choices", label)), value) for label, value in axis.choices.items())
    elif isinstance(axis, Spread):
        yield from ((here, value) for value in _ends(axis))
    else:
        values = sweep.values(key)
        for i in range(0, len(values), -(-len(values) // _MOST)):
            yield (*here, i), values[i]
        yield (*here, len(values) - 1), values[-1]


def _ends(axis: Spread) -> tuple[float, ...]:
    """Returns numbers of a distribution: its ends, or its mean."""
    if isinstance(axis, Uniform):
        return axis.uniform
    if isinstance(axis, LogUniform):
        return axis.log_uniform
    assert isinstance(axis, Normal)
    return (axis.normal[0],)
