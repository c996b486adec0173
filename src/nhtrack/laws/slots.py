"""The numbers of a law's gains and memory in a row: one for each field, and one for each item of a tuple in a field."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import lru_cache
from typing import Any, NamedTuple, get_args, get_origin, get_type_hints

NUMBERS = (float, int, bool)


class Slot(NamedTuple):
    """The place of one number.

    Attributes:
        field: the field that it is in.
        item: which item of the field's tuple it is, or -1 where the field is the number itself.
        kind: float, int or bool.
    """

    field: str
    item: int
    kind: type


@lru_cache(maxsize=256)
def slots_of(kind: Any) -> tuple[Slot, ...]:
    """Returns the places of all numbers of a NamedTuple whose fields are numbers or fixed-size tuples of them."""
    hints = get_type_hints(kind)
    return tuple(slot for name in kind._fields for slot in _slots(name, hints[name]))


def _slots(name: str, hint: Any) -> Iterator[Slot]:
    if hint in NUMBERS:
        yield Slot(name, -1, hint)
    else:
        for i, inner in enumerate(get_args(hint)):
            yield Slot(name, i, inner)


def is_number(hint: Any) -> bool:
    """Returns whether a field's type is that of a number."""
    return hint in NUMBERS


def is_numbers(hint: Any) -> bool:
    """Returns whether a field's type is a tuple of so many numbers, such as `tuple[float, float]`."""
    items = get_args(hint)
    return get_origin(hint) is tuple and bool(items) and all(item in NUMBERS for item in items)


def packed(kind: Any, values: Iterable[Any]) -> Any:
    """Returns the NamedTuple of a row of numbers, each as the type of its place."""
    fields: list[Any] = []
    for slot, value in zip(slots_of(kind), values, strict=True):
        number = slot.kind(value)
        if slot.item > 0:
            fields[-1] += (number,)
        else:
            fields.append(number if slot.item < 0 else (number,))
    return kind(*fields)


def flattened(kept: Iterable[Any]) -> tuple[float, ...]:
    """Returns the numbers of a NamedTuple in a row."""
    row: list[float] = []
    for value in kept:
        if isinstance(value, tuple):
            row += map(float, value)
        else:
            row.append(float(value))
    return tuple(row)
