"""The forms of the leader's input there are: those of the modules of this room."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache, reduce
from importlib import import_module
from operator import or_
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BaseModel, Discriminator, Tag

from nhtrack.references.contract import InputSection
from nhtrack.references.signals import SignalInput

_ROOM = __name__.rpartition(".")[0]


@cache
def input_kinds() -> tuple[type[InputSection], ...]:
    """Returns the forms; two signals, which any other section is taken for, are the first."""
    names = [f"{_ROOM}.{module.name}" for module in iter_modules(import_module(_ROOM).__path__)]
    kinds = [
        kind
        for name in names
        if name != __name__
        for kind in vars(import_module(name)).values()
        if isinstance(kind, type) and issubclass(kind, InputSection) and kind.__module__ == name
    ]
    # A class without a key is what several forms have in common.
    return (SignalInput, *(kind for kind in kinds if "key" in vars(kind) and kind is not SignalInput))


def input_kind(given: Any) -> type[InputSection]:
    """Returns the form that a raw section, or one that is read, is meant for."""
    keys = given if isinstance(given, Mapping) else vars(given) if isinstance(given, BaseModel) else ()
    return next((kind for kind in input_kinds()[1:] if kind.key in keys), SignalInput)


def _tag(kind: type[InputSection]) -> str:
    return f"<input: {kind.key}>"


if TYPE_CHECKING:
    Input = InputSection
else:
    _FORMS = [Annotated[kind, Tag(_tag(kind))] for kind in input_kinds()]
    Input = Annotated[reduce(or_, _FORMS), Discriminator(lambda value: _tag(input_kind(value)))]


def input_words() -> str:
    """Returns the forms in words."""
    *others, last = [kind.words for kind in input_kinds()]
    return f"{', '.join(others)}, or {last}"
