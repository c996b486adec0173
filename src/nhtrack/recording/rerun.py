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
from nhtrack.laws import laws
from nhtrack.recording.recording import Recording
from nhtrack.recording.scenario import LawText


def load_recorded(
    recording: Recording, source: str | Path, overrides: Sequence[str] = ()
) -> tuple[Scenario, tuple[str, ...]]:
    """Returns the scenario that a recording was made from, and what there is to say of it.

    A law of one's own is taken from its file if that has the text it had; else from the text that the recording holds.

    Args:
        recording: whose scenario.
        source: how to call it in messages.
        overrides: as in `nhtrack.config.load.load`.

    Raises:
        ScenarioError: everything wrong with it.
    """
    tree, law = recording.scenario.model_dump(mode="json"), recording.law
    own = any(text.split("=")[0].strip() in ("law", "law.file") for text in overrides)
    if law is None or own or _is_there(tree["law"], law.sha256):
        return load_tree(tree, source=source, overrides=overrides), ()
    file = _restored(law, source)
    tree["law"] = {**tree["law"], "file": str(file)}
    how = "has changed since this recording" if Path(law.file).is_file() else "is gone"
    name = tree["law"]["name"]
    note = f"{law.file} {how}: law {name!r} is taken from the recording; --set law.file=... takes another"
    return load_tree(tree, source=source, overrides=overrides), (note,)


def _is_there(section: Mapping[str, Any], sha256: str) -> bool:
    """Returns whether the law that a tree names still has the text it had."""
    if "file" not in section:
        return section["name"] in laws() and laws()[section["name"]].hash == sha256
    file = Path(section["file"])
    return file.is_file() and hashlib.sha256(file.read_bytes()).hexdigest() == sha256


def _restored(law: LawText, source: str | Path) -> Path:
    """Returns a file with the text of a law, beside the compiled code."""
    folder = cache_folder()
    if folder is None:
        said = f"{law.file} is not what it was, and there is no folder to write its recorded text to; {_SET}"
        raise ScenarioError(source, [Fault(0, 0, "law", said)])
    path: Path = folder.parent / "recorded-laws" / law.sha256[:16] / Path(law.file).name
    if not path.is_file() or path.read_bytes() != law.source.encode():
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_path(path) as temporary:
            temporary.write_bytes(law.source.encode())
    return path


_SET = "set NUMBA_CACHE_DIR to a folder of your own"
