"""A grid of one or two numbers, and formulas that have their names."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from itertools import pairwise
from keyword import iskeyword
from typing import Annotated, Any, Self, TypeAlias

import numpy as np
from pydantic import AfterValidator, Discriminator, Field, Tag, create_model, model_validator

from nhtrack.references import VOCABULARY, make_signal
from nhtrack.section import Section, fault

MOST_POINTS = 4000  # of a grid; an hour of one law from ten starts each
_DIGITS = 4  # of the numbers of a range, so that a point's name can be read
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}\Z")
_WORD = re.compile(r"(?<![\w.])[A-Za-z_]\w*")  # a name in a formula, but not the exponent of a number


class _Spaced(Section):
    to: float = Field(description="the last")
    count: int = Field(ge=2, le=MOST_POINTS, description="how many [1]")
    log: bool = Field(default=False, description="whether each is so many times the one before, not so much more")

    @model_validator(mode="after")
    def _rises(self) -> Self:
        first = getattr(self, "from")
        if self.log and first <= 0:
            raise fault(f"numbers that are spaced by factors begin above 0, got {first:g}")
        if self.to <= first:
            raise fault(f"expected `to` above `from`, got {first:g} to {self.to:g}")
        if len(set(self.values())) < self.count:
            raise fault(f"{self.count} numbers from {first:g} to {self.to:g} are the same when rounded to four digits")
        return self

    def values(self) -> tuple[float, ...]:
        """Returns the numbers."""
        spaced = np.geomspace if self.log else np.linspace
        return tuple(float(f"{value:.{_DIGITS}g}") for value in spaced(getattr(self, "from"), self.to, self.count))


Range = create_model(
    "Range",
    __base__=_Spaced,
    __doc__="Numbers from one to another, rounded to four digits.",
    **{"from": (float, Field(description="the first"))},
)  # type: ignore[call-overload]


def _increasing(values: tuple[float, ...]) -> tuple[float, ...]:
    for before, value in pairwise(values):
        if value <= before:
            raise fault(f"expected numbers that increase, got {value:g} after {before:g}")
    return values


def _grid_name(name: str) -> str:
    if not _NAME.match(name) or iskeyword(name):
        raise fault(f"expected a name of letters, digits and '_' that begins with a letter, got {name!r}")
    if name in VOCABULARY:
        raise fault(f"{name!r} means something else in a formula; choose another name")
    return name


Values: TypeAlias = Annotated[
    Annotated[tuple[float, ...], Field(strict=False, min_length=1), AfterValidator(_increasing), Tag("<numbers>")]
    | Annotated[Range, Tag("<range>")],  # type: ignore[valid-type]
    Discriminator(lambda value: "<range>" if isinstance(value, (Mapping, _Spaced)) else "<numbers>"),
]


def numbers_of(values: Any) -> tuple[float, ...]:
    """Returns the numbers of one name of a grid."""
    return values.values() if isinstance(values, _Spaced) else values


def _grid_size(grid: dict[str, Any]) -> dict[str, Any]:
    if not 1 <= len(grid) <= 2:
        raise fault(f"a grid has one or two names, got {len(grid)}")
    count = math.prod(len(numbers_of(values)) for values in grid.values())
    if count > MOST_POINTS:
        raise fault(f"{count} points; a grid has at most {MOST_POINTS}")
    return grid


Grid: TypeAlias = Annotated[dict[Annotated[str, AfterValidator(_grid_name)], Values], AfterValidator(_grid_size)]
Template: TypeAlias = Annotated[
    Annotated[float, Tag("<number>")] | Annotated[str, Tag("<formula>")],
    Discriminator(lambda value: "<formula>" if isinstance(value, str) else "<number>"),
]


def words_of(formula: str) -> list[str]:
    """Returns the names in a formula, those of functions among them, in order."""
    return [word for word in _WORD.findall(formula) if not iskeyword(word)]


def filled(template: float | str, at: Mapping[str, float]) -> float | str:
    """Returns a number, or a formula with numbers in place of names."""
    if not isinstance(template, str):
        return template

    def number(word: re.Match[str]) -> str:
        value = at.get(word.group())
        return word.group() if value is None else repr(value) if value >= 0 else f"({value!r})"

    return _WORD.sub(number, template)


def first_value(value: float | str) -> float:
    """Returns a number, or the value of a formula at t = 0.

    Raises:
        ReferenceInputError: it has none that is finite.
    """
    return float(make_signal(value)(np.zeros(1))[0])
