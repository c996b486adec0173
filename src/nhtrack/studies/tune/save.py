"""Gains that were found, into a scenario file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from nhtrack.assets import bundled_scenarios, find_scenario
from nhtrack.config.edit import save_law_gains
from nhtrack.config.law_sections import LawSection
from nhtrack.experiment.load import LOADER
from nhtrack.files.folder import OutputError, require_free
from nhtrack.studies.tune.result import Tuning


def refuse_existing(source: object, target: Path, overwrite: bool) -> None:
    """Raises, before any work is done, where gains could not be written after it.

    Raises:
        OutputError: the target exists, or the source is no scenario file.
    """
    _file_of(source)
    require_free(target, overwrite)


def refuse_other_law(source: object, law: LawSection) -> None:
    """Raises, before any work is done, where a file has another law than the one that is tuned.

    Raises:
        OutputError: it has.
        ScenarioError: the file as it is cannot be read.
    """
    own = LOADER.load(_file_of(source)).law
    if own.kind is not law.kind:
        raise OutputError(f"{source} has the law {own.name!r}, which has no gains of {law.name!r}")


def save_gains(found: Tuning, source: object, target: Path, overrides: Sequence[str]) -> None:
    """Writes a scenario file with the gains found, and above its law how they were found.

    Args:
        found: by the search.
        source: file or bundled name of the scenario.
        target: the file to write, which may be the same.
        overrides: changes that the scenario was searched with, such as `duration=4`.
    """
    account = found.account + (f", with {' '.join(overrides)}" if overrides else "")
    save_law_gains(_file_of(source), target, found.gains, "nhtrack tune:", [f"{account};", found.leaves], LOADER)


def _file_of(source: object) -> Path:
    """Returns the file of a scenario that is asked for by its path or its bundled name."""
    if isinstance(source, (str, Path)):
        if str(source) in bundled_scenarios() and not Path(source).is_file():
            return find_scenario(str(source))
        if Path(source).suffix == ".nc":
            raise OutputError("a recording is not a file of gains; tune its scenario file")
        if "\n" not in str(source):
            return Path(source)
    raise OutputError("gains are written into a copy of a file; tune a scenario file, or a bundled one by its name")
