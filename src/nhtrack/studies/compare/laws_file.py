"""The laws that are compared in a scenario: by name, written out, or taken from another scenario file."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TypeVar

from pydantic import ValidationError

from nhtrack.config.changes import LawChoice, value_text
from nhtrack.config.law_sections import Law, LawSection, law_names, law_section
from nhtrack.config.messages import shape_faults
from nhtrack.config.scenario import Scenario
from nhtrack.config.tree import ancestors, dotted, parse_yaml
from nhtrack.errors import Fault, NhtrackError, ScenarioError, did_you_mean
from nhtrack.section import Section

_QUOTES = "in a shell a mapping stands in quotes"

# Loads a scenario by its file, its bundled name or a recording of it.
Read = Callable[[str], Scenario]

Found = TypeVar("Found")

_KINDS: Mapping[str, type[Section]] = {name: law_section(name) for name in law_names()}


class SeveralFaultyError(ScenarioError):
    """Several sources that are at fault, each with its own faults.

    Attributes:
        errors: one for each source.
    """

    def __init__(self, errors: Sequence[ScenarioError]) -> None:
        self.errors = tuple(errors)
        self.source = ", ".join(error.source for error in errors)
        self.faults = tuple(fault for error in errors for fault in error.faults)
        NhtrackError.__init__(self, "\n".join(map(str, errors)))

    def __reduce__(self) -> tuple[type[SeveralFaultyError], tuple[tuple[ScenarioError, ...]]]:  # type: ignore[override]
        """Returns how to make the error anew, so that it can cross from a worker process."""
        return type(self), (self.errors,)


class _Written(Section):
    """A law by itself."""

    law: Law


def law_texts(laws: LawChoice | Iterable[LawChoice]) -> list[str]:
    """Returns laws, or a single one, as they are asked for on the command line; see `load_laws`."""
    several = [laws] if isinstance(laws, (str, Path, Mapping, LawSection)) else laws
    return [law if isinstance(law, str) else value_text(law) for law in several]


def load_laws(own: Callable[[], Scenario], texts: Sequence[str], read: Read) -> tuple[Scenario, tuple[Law, ...]]:
    """Returns a scenario and the laws to be compared in it, its own first unless it is among them.

    A law is asked for by

    - its name: with the gains of the schema's defaults, or the scenario's own where that is the scenario's law;
    - a YAML flow mapping, `{name: kanayama, k_x: 2}`;
    - a file that ends in `.py`, which is the law itself;
    - whatever has a dot or a slash in it, which `read` takes: another scenario, whose law it is. Its gains are taken as
      they stand, in the units of the scenario that they come into.

    Args:
        own: loads the scenario.
        texts: how the laws are asked for.
        read: loads the scenario of a law.

    Raises:
        ScenarioError: everything wrong with the scenario and with what is asked for.
    """
    errors: list[ScenarioError] = []
    scenario = _attempt(own, errors)
    laws: dict[str, Law] = {}
    for text in texts:
        if scenario is None and text in _KINDS:
            continue  # it may be the scenario's own
        law = _attempt(partial(_law, text, scenario, read), errors)
        if law is not None:
            laws[text] = law
    faults = [Fault(0, 0, "", message) for message in _odd(laws, texts, scenario)]
    if faults:
        errors.append(ScenarioError("command line", faults))
    if errors or scenario is None:
        raise errors[0] if len(errors) == 1 else SeveralFaultyError(errors)
    return scenario, _in_order(scenario.law, list(laws.values()))


def _attempt(make: Callable[[], Found], errors: list[ScenarioError]) -> Found | None:
    try:
        return make()
    except ScenarioError as error:
        errors.append(error)
        return None


def _law(text: str, scenario: Scenario | None, read: Read) -> Law:
    if text.lstrip().startswith("{"):
        return _written(text)
    if text.endswith(".py"):
        return _written(f"{{file: {json.dumps(str(Path(text).resolve()))}}}")
    if "." in text or "/" in text:
        return read(text).law
    if scenario is not None and text == scenario.law.name:
        return scenario.law
    return _named(text)


def _named(name: str) -> Law:
    """Returns a law with the gains of the schema's defaults."""
    if name not in _KINDS:
        ways = "; or write '{name: kanayama, k_x: 2}', or name a scenario file whose law it is"
        raise _at_fault(f"no law called {name!r}; {did_you_mean(name, _KINDS)}{ways}")
    missing = [key for key, each in _KINDS[name].model_fields.items() if each.is_required() and key != "name"]
    if missing:
        gains = "".join(f", {key}: ..." for key in missing)
        ways = f"write '{{name: {name}{gains}}}', or name a scenario file whose law it is"
        raise _at_fault(f"law {name!r} has no gains by default; {ways}")
    return _Written.model_validate({"law": {"name": name}}).law


def _at_fault(message: str) -> ScenarioError:
    return ScenarioError("command line", [Fault(0, 0, "", message)])


def _written(text: str) -> Law:
    """Returns the law of a YAML flow mapping."""
    document = parse_yaml(text)
    tree = {"law": document.tree}
    faults = [replace(fault, message=f"{fault.message}; {_QUOTES}") for fault in document.faults]
    try:
        if document.tree is not None:
            law = _Written.model_validate(tree).law
    except ValidationError as error:
        for path, message in shape_faults(tree, error):
            inside = path[1:]  # of the law
            if inside not in document.unreadable:
                place = next(document.positions[here] for here in ancestors(inside) if here in document.positions)
                faults.append(Fault(*place, dotted(inside), message))
    if faults:
        raise ScenarioError(text, list(dict.fromkeys(faults)))
    return law


def _odd(laws: Mapping[str, Law], texts: Sequence[str], scenario: Scenario | None) -> list[str]:
    """Returns what is wrong with the laws together, in words."""
    odd = [f"law {text!r} is asked for twice" for text in dict.fromkeys(texts) if texts.count(text) > 1]
    kept = list(laws.items())
    for i, (text, law) in enumerate(kept):
        same = next((other for other, earlier in kept[:i] if earlier == law), None)
        if same is not None:
            odd.append(f"law {text!r} is the same as {same!r}; name it once")
    if scenario is not None and len(laws) == len(set(texts)) and all(law == scenario.law for law in laws.values()):
        odd.append(f"nothing to compare: {scenario.law.name!r} is the scenario's own law; name another")
    return odd


def _in_order(own: Law, laws: list[Law]) -> tuple[Law, ...]:
    return tuple(laws) if own in laws else (own, *laws)
