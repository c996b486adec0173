"""The effects there are: those of the modules of this room."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from types import MappingProxyType

from nhtrack.effects.contract import Effect
from nhtrack.section import Section

_ROOM = __name__.rpartition(".")[0]


@cache
def effect_kinds() -> Mapping[str, type[Effect]]:
    """Returns the effects by their keys in `physics`."""
    names = [module.name for module in iter_modules(import_module(_ROOM).__path__)]
    kinds = [
        kind
        for name in names
        for kind in vars(import_module(f"{_ROOM}.{name}")).values()
        if isinstance(kind, type) and issubclass(kind, Effect) and kind.__module__ == f"{_ROOM}.{name}"
    ]
    return MappingProxyType({kind.key: kind for kind in kinds if kind is not Effect})


def effects_of(physics: Section, length: float) -> tuple[Effect, ...]:
    """Returns the effects that a section `physics` asks for, in robot units.

    Args:
        physics: has the key of every effect.
        length: robot metres per scenario length unit.
    """
    found = (kind.of(getattr(physics, key), length) for key, kind in effect_kinds().items())
    return tuple(effect for effect in found if effect is not None)
