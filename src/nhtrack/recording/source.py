"""The scenario that is meant by a name, a file, a text, a recording or a scenario, with changes."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TypeAlias, Unpack

from nhtrack.config.changes import ScenarioChanges, overrides_of
from nhtrack.config.scenario import Scenario
from nhtrack.errors import Fault, ScenarioError
from nhtrack.experiment.load import LOADER, load_either
from nhtrack.recording.recording import Recording
from nhtrack.recording.rerun import load_recorded

# A bundled name, a scenario file, a recording.nc, a YAML text of several lines, or what these are loaded as.
Source: TypeAlias = Scenario | Recording | str | Path


def load_source(
    source: Source, overrides: Sequence[str] = (), *, trust: bool = False
) -> tuple[Scenario, tuple[str, ...]]:
    """Returns the scenario that is meant, and what there is to say of it.

    Args:
        source: what is meant; a recording means the scenario it was made from.
        overrides: changes such as `law.kp=3`, applied before anything is judged.
        trust: whether to run a law of one's own that a recording brings along; it is code, of whoever wrote it.

    Raises:
        ScenarioError: everything wrong with it.
        RecordingError: it is a recording that cannot be read.
    """
    if isinstance(source, Scenario):
        tree = source.model_dump(mode="json")
        return (LOADER.load_tree(tree, source=source.name, overrides=overrides) if overrides else source), ()
    if isinstance(source, Recording):
        return load_recorded(source, source.name, overrides, trust=trust)
    if str(source).endswith(".nc"):
        return load_recorded(Recording.load(source), source, overrides, trust=trust)
    if isinstance(source, str) and "\n" in source:
        return LOADER.load_text(source, overrides=overrides), ()
    return LOADER.load(source, overrides), ()


def load(
    source: Source, overrides: Sequence[str] = (), *, trust: bool = False, **changes: Unpack[ScenarioChanges]
) -> Scenario:
    """Returns a scenario with everything in it judged; what there is to say of a recording's is warned of.

    Args:
        source: a bundled name, a scenario file, a YAML text of several lines, a recording, or a scenario.
        overrides: changes as on the command line, such as `law.kp=3`.
        trust: whether to run a law of one's own that a recording brings along; it is code, of whoever wrote it.
        **changes: `law`, `robot`, `duration`, `backend` and `set`, see `nhtrack.config.changes.ScenarioChanges`.

    Raises:
        ScenarioError: everything wrong with it.
        RecordingError: it is a recording that cannot be read.
    """
    scenario, notes = load_source(source, [*overrides_of(**changes), *overrides], trust=trust)
    for note in notes:
        warnings.warn(note, stacklevel=2)
    return scenario


def validate(source: str | Path) -> tuple[Fault, ...]:
    """Returns everything wrong with a scenario or campaign, by its file or its bundled name; nothing where it can run.

    Nothing is run. A fault has line, column, key and message.
    """
    try:
        load_either(source)
    except ScenarioError as error:
        return error.faults
    return ()
