"""The scenario of a recording, with the law it was run with, wherever that law's file is by now."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from nhtrack.compiled import cache_folder
from nhtrack.config.scenario import Scenario
from nhtrack.errors import Fault, ScenarioError
from nhtrack.experiment.load import load_tree
from nhtrack.files.atomic import atomic_path
from nhtrack.files.text import exists
from nhtrack.laws import laws
from nhtrack.recording.recording import Recording
from nhtrack.recording.scenario import LawText, RecordedLaw


def load_recorded(
    recording: Recording, source: str | Path, overrides: Sequence[str] = (), *, trust: bool = False
) -> tuple[Scenario, tuple[str, ...]]:
    """Returns the scenario that a recording was made from, and what there is to say of it.

    A law of one's own is code, of whoever wrote the recording: it runs where it is trusted, from its file if that has
    the text it had, else from the text that the recording holds. A law that an override names takes its place.

    Args:
        recording: whose scenario.
        source: how to call it in messages.
        overrides: as in `nhtrack.config.load.load`.
        trust: whether to run a law that the recording brings along.

    Raises:
        ScenarioError: everything wrong with it; or it brings a law along that is not trusted.
    """
    scenario, notes = recording.scenario, tuple[str, ...]()
    tree = scenario.model_dump(mode="json")
    own = any(text.split("=")[0].strip() in ("law", "law.file") for text in overrides)
    if isinstance(scenario.law, RecordedLaw) and not own:
        tree["law"], notes = _runnable(tree["law"], recording.law, source, trust)
    return load_tree(tree, source=source, overrides=overrides), notes


def _runnable(
    section: Mapping[str, Any], law: LawText | None, source: str | Path, trust: bool
) -> tuple[Mapping[str, Any], tuple[str, ...]]:
    """Returns the section of a law that is not the package's own, as it is to be run, and what there is to say of it.

    Raises:
        ScenarioError: it is not trusted.
    """
    name, file = section["name"], section.get("file", None if law is None else law.file)
    text = None if law is None else law.source.encode()
    if "file" not in section and _is_there(section, text):
        return section, ()
    if not trust:
        said = (
            f"law {name!r} ({file}) is code that this recording brings along, and runs only if you trust it: read it, "
            "then --trust (in Python `trust=True`); or name a law yourself, --set law.file=..."
        )
        raise ScenarioError(source, [Fault(0, 0, "law", said)])
    if law is None or text is None or _is_there(section, text):
        return section, ()
    how = "has changed since this recording" if exists(Path(law.file)) else "is gone"
    note = f"{law.file} {how}: law {name!r} is taken from the recording; --set law.file=... takes another"
    return {**section, "file": str(_restored(Path(law.file).name, text, source))}, (note,)


def _is_there(section: Mapping[str, Any], text: bytes | None) -> bool:
    """Returns whether the law that a section names still has the text it had."""
    if "file" not in section:
        kind = laws().get(section["name"])
        return kind is not None and kind.source.encode() == text
    file = Path(section["file"])
    if text is None or not exists(file) or not file.is_file() or file.stat().st_size != len(text):
        return False
    return file.read_bytes() == text


def _restored(name: str, text: bytes, source: str | Path) -> Path:
    """Returns a file with the text of a law, beside the compiled code."""
    folder = cache_folder()
    if folder is None:
        said = f"{name} is not what it was, and there is no folder to write its recorded text to; {_SET}"
        raise ScenarioError(source, [Fault(0, 0, "law", said)])
    path: Path = folder.parent / "recorded-laws" / hashlib.sha256(text).hexdigest()[:16] / name
    if not path.is_file() or path.read_bytes() != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_path(path) as temporary:
            temporary.write_bytes(text)
    return path


_SET = "set NUMBA_CACHE_DIR to a folder of your own"
