"""Formulas of numbers, such as `6*pi`, where a file wants a number."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from nhtrack.config.messages import is_number, tree_path
from nhtrack.config.tree import Path, lookup
from nhtrack.references import ReferenceInputError, number_of


def formulas_in(tree: Any, error: ValidationError) -> dict[Path, float]:
    """Returns the numbers of a tree that are written as formulas, by their paths.

    Args:
        tree: the raw tree.
        error: what is wrong with it while they are texts.
    """
    found: dict[Path, float] = {}
    for problem in error.errors(include_url=False):
        wanted, given, loc = problem["type"], problem["input"], tuple(problem["loc"])
        number = wanted in ("float_type", "int_type") or loc[-1:] == ("<auto>",)
        if not number or not isinstance(given, str) or is_number(given):
            continue
        try:
            value = number_of(given)
        except ReferenceInputError:
            continue
        if wanted != "int_type" or value.is_integer():
            found[tree_path(tree, loc)] = int(value) if wanted == "int_type" else value
    return found


def with_values(tree: Any, values: Mapping[Path, float]) -> Any:
    """Returns a copy of a tree with other values at some paths."""
    changed = copy.deepcopy(tree)
    for path, value in values.items():
        lookup(changed, path[:-1])[path[-1]] = value
    return changed
