"""What the attributes of a recording are to be: those of a file that are missing, or are something else."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from nhtrack.errors import RecordingError
from nhtrack.simulation.spec import SceneSpec

UNREADABLE = (ValueError, TypeError, LookupError, AttributeError, OverflowError, RecursionError)


def _scale(value: Any) -> None:
    if not (math.isfinite(value) and value > 0):
        raise ValueError


def section(text: Any) -> Mapping[str, Any]:
    """Returns the mapping that a JSON text is; any of `UNREADABLE` is raised where it is none."""
    tree = json.loads(text)
    if not isinstance(tree, dict):
        raise ValueError
    return tree


def _printable(text: Any) -> None:
    if not str(text).isprintable():
        raise ValueError


def read_scene(text: Any) -> SceneSpec:
    """Returns the scene of a recording from its JSON text, each value of the type it should have.

    Raises:
        RecordingError: it has an effect that this version does not know.
    """
    spec = SceneSpec.from_json(text)
    return TypeAdapter(SceneSpec).validate_python(vars(spec))


def _lists(text: Any) -> None:
    if not all(isinstance(names, list) and all(isinstance(n, str) for n in names) for names in section(text).values()):
        raise ValueError


def _law(text: Any) -> None:
    from nhtrack.recording.scenario import LawText  # few recordings have one, and it imports all laws

    law = LawText(**section(text))
    if not all(isinstance(part, str) for part in law[:-1]):
        raise ValueError
    if Path(law.file).name in ("", "..") or "\0" in law.file:
        raise ValueError


REQUIRED: Mapping[str, Callable[[Any], Any]] = {
    "scenario": section,
    "format_version": int,
    "name": _printable,
    "backend": _printable,
    "outcome": str,
    "parents": _lists,
    "length_scale": _scale,
    "time_scale": _scale,
    "versions": section,
}
_OPTIONAL: Mapping[str, Callable[[Any], Any]] = {
    "scene": read_scene,
    "law": _law,
    "groups": _lists,
    "seed": int,
    "rows": int,
    "diverged_time": float,
    **dict.fromkeys(("friction", "torque_limit", "no_load_speed", "wheel_radius", "half_separation"), float),
    "trusted_friction": float,
}


def attribute_faults(attributes: Mapping[str, Any]) -> Iterator[str]:
    """Yields attributes that are missing, or are not what they are read as."""
    yield from (f"no {name!r}" for name in REQUIRED if name not in attributes)
    for name, read in {**REQUIRED, **_OPTIONAL}.items():
        try:
            if name in attributes:
                read(attributes[name])
        except RecordingError as error:
            yield str(error)
        except UNREADABLE:
            yield f"{name!r} cannot be read"
