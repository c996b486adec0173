"""Scenario files to scenarios: every fault at once, each with its line, column and key."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any, Generic, TypeVar

from pydantic import ValidationError

from nhtrack import assets
from nhtrack.config.campaign import Campaign, campaign_findings
from nhtrack.config.changes import apply_overrides, parse_override
from nhtrack.config.checks import Checks, findings, no_checks
from nhtrack.config.formulas import formulas_in, with_values
from nhtrack.config.messages import shape_faults
from nhtrack.config.named_files import with_named_files
from nhtrack.config.scenario import Scenario
from nhtrack.config.sweep import Sweep
from nhtrack.config.sweep_findings import backend_findings, sweep_findings
from nhtrack.config.sweep_trials import located, trials
from nhtrack.config.tree import Document, Path, ancestors, dotted, lookup, parse_yaml
from nhtrack.errors import Fault, ScenarioError, did_you_mean
from nhtrack.files.text import TextError, exists, read_text
from nhtrack.section import Finding, Section

Kind = TypeVar("Kind", bound=Section)

_MOST_BYTES = 4 * 10**6  # of a file; columns longer than that have files of their own


@dataclass(frozen=True)
class _Form(Generic[Kind]):
    """A kind of file: its sections, and what its keys mean together."""

    model: type[Kind]
    findings: Callable[[Any, FilePath, Checks], Iterator[Finding]]
    bundled: Callable[[], tuple[str, ...]]
    find: Callable[[str], FilePath]


_SCENARIO = _Form(Scenario, findings, assets.bundled_scenarios, assets.find_scenario)
_CAMPAIGN_FAULT = Fault(0, 0, "", "this is a campaign; run it with `nhtrack campaign`")
_CAMPAIGN = _Form(Campaign, campaign_findings, assets.bundled_campaigns, assets.find_campaign)
_SWEEP_FAULT = Fault(0, 0, "", "this is a sweep; run it with `nhtrack sweep`")
_AUTO = Fault(0, 0, "similarity.time", "`auto` would be another time in every run; give a number")
_SWEEP = _Form(Sweep, sweep_findings, assets.bundled_sweeps, assets.find_sweep)


def is_campaign(tree: Any) -> bool:
    """Returns whether a file's tree is meant as a campaign: it has several laws, where a scenario has one."""
    return isinstance(tree, dict) and "laws" in tree and "law" not in tree


def is_sweep(tree: Any) -> bool:
    """Returns whether a file's tree is meant as a sweep: it has axes."""
    return isinstance(tree, dict) and "axes" in tree and "law" not in tree


@dataclass(frozen=True)
class Loader:
    """Reads files; `nhtrack.experiment.load` has one that looks into the files of robots, too.

    Attributes:
        checks: of a file's robot, with its tree and the folder of relative paths.
    """

    checks: Checks = no_checks

    def load_campaign(self, source: str | FilePath, overrides: Sequence[str] = ()) -> Campaign:
        """Returns the campaign of a YAML file, or of a bundled campaign by name (`campaign/ideal`); as `load`.

        Raises:
            ScenarioError: everything wrong with it.
        """
        path = _path_of(source, _CAMPAIGN)
        return self._read_document(_parsed(path), path, path.parent, overrides, _CAMPAIGN)

    def load_sweep(self, source: str | FilePath, overrides: Sequence[str] = ()) -> Sweep:
        """Returns the sweep of a YAML file, or of a bundled sweep by name (`sweep/small`); as `load`.

        Values of its axes are tried in its scenario, each by itself, the others at their first.

        Raises:
            ScenarioError: everything wrong with it.
        """
        path = _path_of(source, _SWEEP)
        document = _parsed(path)
        sweep = located(self._read_document(document, path, path.parent, overrides, _SWEEP), path.parent)
        faults = list(dict.fromkeys(self._trial_faults(sweep, document)))
        if faults:
            raise ScenarioError(path, faults)
        return sweep

    def _trial_faults(self, sweep: Sweep, document: Document) -> Iterator[Fault]:
        """Yields what is wrong with a sweep's scenario, or with values of its axes in it."""
        try:
            base = self.load(sweep.base, sweep.base_changes)
        except ScenarioError as error:
            lines = str(error).splitlines()
            yield from (_base_fault(fault, line, document) for fault, line in zip(error.faults, lines, strict=True))
            return
        if base.similarity.time == "auto":
            yield _placed(("base",), f"{_AUTO.key}: {_AUTO.message}, such as in `set`", document, {})
        for place, message in backend_findings(sweep, base.backend):
            yield _placed(place, message, document, {})
        tree = base.model_dump(mode="json")
        for place, alone, together in trials(sweep):
            faults = self._faults(tree, alone)
            if faults and self._faults(tree, together):
                yield from (_placed(place, _said(fault), document, {}) for fault in faults)

    def _faults(self, tree: Mapping[str, Any], overrides: Sequence[str]) -> tuple[Fault, ...]:
        """Returns everything wrong with a tree that is changed."""
        try:
            loaded = self.load_tree(tree, overrides=overrides)
        except ScenarioError as error:
            return error.faults
        return (_AUTO,) if loaded.similarity.time == "auto" else ()

    def load_either(self, source: str | FilePath, overrides: Sequence[str] = ()) -> Scenario | Campaign | Sweep:
        """Returns what a file says, or a bundled file of that name: a scenario, a campaign or a sweep.

        Args:
            source: path of the file, or a bundled name.
            overrides: changes such as `law.kp=3`, applied before anything is judged.

        Raises:
            ScenarioError: everything wrong with it.
        """
        if str(source) in assets.bundled_campaigns():
            return self.load_campaign(source, overrides)
        if str(source) in assets.bundled_sweeps():
            return self.load_sweep(source, overrides)
        path = FilePath(source)
        if not exists(path) or path.is_dir():
            return self.load(source, overrides)
        document = _parsed(path)
        if is_sweep(document.tree):
            return self.load_sweep(path, overrides)
        form: _Form[Any] = _CAMPAIGN if is_campaign(document.tree) else _SCENARIO
        found: Scenario | Campaign = self._read_document(document, path, path.parent, overrides, form)
        return found

    def load(self, source: str | FilePath, overrides: Sequence[str] = ()) -> Scenario:
        """Returns the scenario of a YAML file, or of a bundled scenario by name (`paper/example1`).

        Files it names (robot, CSV) are found relative to it; a CSV is read into the scenario, so that the
        scenario alone reproduces the run.

        Args:
            source: path of the file, or the name of a bundled scenario.
            overrides: changes such as `law.kp=3`, applied before anything is judged.

        Raises:
            ScenarioError: everything wrong with it.
        """
        path = _path_of(source, _SCENARIO)
        return self._read_document(_parsed(path), path, path.parent, overrides, _SCENARIO)

    def load_text(
        self,
        text: str,
        source: str | FilePath = "<text>",
        directory: FilePath | None = None,
        overrides: Sequence[str] = (),
    ) -> Scenario:
        """Returns the scenario of a YAML text.

        Args:
            text: the text.
            source: how to call it in messages.
            directory: what relative paths in it start from; the working directory by default.
            overrides: as in `load`.

        Raises:
            ScenarioError: everything wrong with it.
        """
        return self._read_document(parse_yaml(text), source, directory or FilePath.cwd(), overrides, _SCENARIO)

    def load_tree(
        self,
        tree: Mapping[str, Any],
        source: str | FilePath = "<scenario>",
        directory: FilePath | None = None,
        overrides: Sequence[str] = (),
    ) -> Scenario:
        """Returns the scenario of a tree, such as the one a recording carries; arguments as in `load_text`.

        Raises:
            ScenarioError: everything wrong with it.
        """
        document = Document(dict(tree))  # changes are made in a copy
        return self._read_document(document, source, directory or FilePath.cwd(), overrides, _SCENARIO)

    def _read_document(
        self,
        document: Document,
        source: str | FilePath,
        directory: FilePath,
        overrides: Sequence[str],
        form: _Form[Kind],
    ) -> Kind:
        """Returns what a parsed file says; runs every check that still can."""
        if document.tree is None:
            raise ScenarioError(source, document.faults or [Fault(0, 0, "", "the file is empty")])
        if form is _SCENARIO and is_campaign(document.tree):
            raise ScenarioError(source, [_CAMPAIGN_FAULT])
        if form is _SCENARIO and is_sweep(document.tree):
            raise ScenarioError(source, [_SWEEP_FAULT])
        tree = apply_overrides(document.tree, overrides)
        tree, problems = with_named_files(tree, directory)
        loaded, error = _validated(form.model, tree)
        if error is not None and (numbers := formulas_in(tree, error)):
            tree, problems = with_named_files(with_values(tree, numbers), directory)
            loaded, error = _validated(form.model, tree)
        if error is not None:
            problems += shape_faults(tree, error)
        known = {path for path, _ in problems}
        found = form.findings(tree, directory, self.checks)
        problems += [(path, message) for path, message in found if path not in known]
        changed = {parse_override(text)[0]: text for text in overrides} if problems else {}
        faults = document.faults + [
            _placed(path, message, document, changed) for path, message in problems if path not in document.unreadable
        ]
        if faults or loaded is None:
            raise ScenarioError(source, list(dict.fromkeys(faults)))
        return loaded


def _base_fault(fault: Fault, line: str, document: Document) -> Fault:
    """Returns the fault of a sweep whose scenario is at fault: at the change that brought it, or at its name."""
    changed = next((key for key in lookup(document.tree, ("set",), ()) if fault.key.startswith(key)), None)
    place, message = (("base",), line) if changed is None else (("set", changed), _said(fault))
    return _placed(place, message, document, {})


def _said(fault: Fault) -> str:
    """Returns what a fault of a changed scenario says, without how it was changed."""
    message = _CHANGE.sub("", fault.message)
    return f"{fault.key}: {message}" if fault.key else message


_CHANGE = re.compile(r"^--set \S+: | \(from --set .*\)$")


def _validated(model: type[Kind], tree: Any) -> tuple[Kind | None, ValidationError | None]:
    """Returns what a tree says, or what is wrong with it."""
    try:
        return model.model_validate(tree), None
    except ValidationError as error:
        return None, error


def _placed(path: Path, message: str, document: Document, changed: Mapping[Path, str]) -> Fault:
    """Returns the fault of a path, placed at its key or the nearest above it, or on the command line."""
    brought = next((changed[here] for here in ancestors(path) if here in changed), None)
    if brought is None and path not in document.positions:  # a section that is there for a key in it alone
        brought = next((text for key, text in changed.items() if key[: len(path)] == path), None)
    if brought is not None:
        return Fault(0, 0, dotted(path), f"{message} (from --set {brought})")
    place = next((document.positions[here] for here in ancestors(path) if here in document.positions), (0, 0))
    return Fault(*place, dotted(path), message)


def _path_of(source: str | FilePath, form: _Form[Any]) -> FilePath:
    """Returns the file meant by a path or by the name of a bundled file."""
    path, kind = FilePath(source), form.model.__name__.lower()
    if exists(path):
        if path.is_dir():
            raise ScenarioError(source, [Fault(0, 0, "", f"this is a directory; name a {kind} file in it")])
        return path
    name, bundled = str(source), form.bundled()
    if name in bundled:
        return form.find(name)
    if form is _SCENARIO and name in assets.bundled_campaigns():
        raise ScenarioError(source, [_CAMPAIGN_FAULT])
    if form is _SCENARIO and name in assets.bundled_sweeps():
        raise ScenarioError(source, [_SWEEP_FAULT])
    hint = did_you_mean(name.removesuffix(".yaml"), bundled)
    raise ScenarioError(source, [Fault(0, 0, "", f"no such file, and no bundled {kind} of that name; {hint}")])


def _parsed(path: FilePath) -> Document:
    """Returns the tree of a file."""
    try:
        return parse_yaml(read_text(path, _MOST_BYTES))
    except TextError as error:
        raise ScenarioError(path, [Fault(error.line, error.column, "", error.reason)]) from None
