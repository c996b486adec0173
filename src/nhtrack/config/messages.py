"""What pydantic found wrong, said the way a person would."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import ValidationError

from nhtrack.config.tree import Path, lookup
from nhtrack.errors import did_you_mean
from nhtrack.laws import faulty_laws
from nhtrack.references import ReferenceInputError, input_words, number_of

_COMPONENTS = {
    "pose": ("x", "y", "theta"),
    "twist": ("v", "omega"),
    "offset": ("x", "y"),
    "size": ("width", "height"),
}
_BOUNDS = {
    "greater_than": ("greater than", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than": ("less than", "lt"),
    "less_than_equal": ("at most", "le"),
}
_EXPECTED = {
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "string_type": "text",
    "bool_type": "true or false",
    "tuple_type": "a list",
    "dict_type": "a section of `key: value` lines",
    "model_type": "a section of `key: value` lines",
    "model_attributes_type": "a section of `key: value` lines",
}


_FORMULA = re.compile(r"^t$|\d *[-+*/^(]|[-+*/^)] *\w")  # what is meant as one


def shape_faults(tree: Any, error: ValidationError) -> Iterator[tuple[Path, str]]:
    """Yields the path and the message of every fault pydantic found in a tree."""
    problems = error.errors(include_url=False)
    places = [tuple(problem["loc"]) for problem in problems]
    for problem, loc in zip(problems, places, strict=True):
        # A list whose items are at fault counts as short only because they are.
        if problem["type"] == "too_short" and any(other[: len(loc)] == loc and other != loc for other in places):
            continue
        path = tree_path(tree, loc)
        if problem["type"] == "union_tag_invalid":
            path = (*path, "name")
        elif problem["type"] == "missing":  # of a list of fixed length; the sections speak for their own keys
            path = path[:-1]
        yield path, _message(tree, loc, problem)


def tree_path(tree: Any, loc: tuple[str | int, ...]) -> Path:
    """Returns the path in the file of a pydantic location, which also names the forms chosen in unions."""
    path: list[str | int] = []
    for i, step in enumerate(loc):
        here = lookup(tree, path)
        known = isinstance(step, int) or (isinstance(here, Mapping) and step in here)
        if known or (i == len(loc) - 1 and not str(step).startswith(("<", "["))):
            path.append(step)
    return tuple(path)


def _message(tree: Any, loc: tuple[str | int, ...], problem: Any) -> str:
    kind, given, context = str(problem["type"]), problem["input"], problem.get("ctx") or {}
    name = str(next((step for step in reversed(loc) if isinstance(step, str) and not step.startswith("<")), ""))
    if kind == "fault":
        return str(context["message"])
    if kind == "too_long":
        return _wrong_length(name, len(given))
    if kind == "missing":
        return _wrong_length(name, len(lookup(tree, tree_path(tree, loc[:-1]), ())))
    if kind in ("too_short", "string_too_short"):
        return "expected at least one" + (" character" if kind == "string_too_short" else "") + ", got none"
    if kind in _BOUNDS:
        words, bound = _BOUNDS[kind]
        return f"expected a value {words} {context[bound]:g}, got {shown(given)}"
    if kind == "finite_number":
        return f"expected a finite number, got {shown(given)}"
    if loc and loc[-1] == "<auto>":
        return f"expected a number or `auto`, got {shown(given)}" + _unquoted(given)
    if kind == "literal_error":
        return f"no such choice as {shown(given)}; {did_you_mean(str(given), _choices(context))}"
    if kind == "union_tag_invalid":
        if context["tag"] in faulty_laws():
            return str(faulty_laws()[context["tag"]])
        return f"no law called {context['tag']!r}; {did_you_mean(context['tag'], _choices(context))}"
    if kind == "union_tag_not_found":
        return f"expected a section with a `name`, got {shown(given)}"
    return _wrong_type(kind, loc, given, str(problem["msg"]))


def _wrong_type(kind: str, loc: tuple[str | int, ...], given: Any, otherwise: str) -> str:
    expected = _EXPECTED.get(kind)
    form = loc[-1] if loc else ""
    if form == "<signal>":
        expected = "a number, a formula in t, or a list of segments"
    elif str(form).startswith("<input: "):
        expected = input_words()
    elif form == "<number>":
        expected = "a number or a formula in t"
    elif form == "<time>":
        expected = "a number or `auto`"
    if expected is None:
        return f"{otherwise[0].lower()}{otherwise[1:]}, got {shown(given)}"
    hint = _unquoted(given) if kind in ("float_type", "int_type", "bool_type") else ""
    if given is None:
        return f"expected {expected}, got nothing; give a value or leave the key out"
    return f"expected {expected}, got {shown(given)}{hint}"


def _wrong_length(name: str, given: int) -> str:
    components = _COMPONENTS[name]
    return f"expected {len(components)} values ({', '.join(components)}), got {given}"


def _unquoted(given: Any) -> str:
    """Returns the advice that a number given as text needs, or why a formula is none."""
    if not isinstance(given, str):
        return ""
    if is_number(given):
        return "; write it without quotes"
    if not _FORMULA.search(given):
        return ""
    try:
        number_of(given)
    except ReferenceInputError as error:
        return f"; {error}"
    return ""


def is_number(text: str) -> bool:
    """Returns whether a text is a number that needs no quotes."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def shown(value: Any) -> str:
    """Returns a value of the file with its type in plain words."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f"the text {value!r}" if len(value) < 60 else f"the text {value[:57]!r}..."
    if isinstance(value, Mapping):
        return "a section"
    if isinstance(value, (list, tuple)):
        return "a list"
    if value is None:
        return "nothing"
    return f"{value:.15g}" if isinstance(value, float) else str(value)


def _choices(context: Mapping[str, Any]) -> list[str]:
    text = str(context.get("expected_tags", context.get("expected", "")))
    choices = [part.strip().strip("'") for part in text.replace(" or ", ", ").split(",")]
    return [choice for choice in choices if not choice.startswith("<")]
