"""What a results folder says that its rows are made of, so that rows of something else never come among them."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from nhtrack.analysis.sources import fingerprint, sources_in
from nhtrack.files.folder import is_used
from nhtrack.recording.versions import versions

__all__ = ["account_of", "changed", "held_account", "made_of", "read_account"]

_MOST = 5  # differences that are told
_BESIDE = ("files", "versions")  # what an account says beside what was asked for


def made_of(*trees: Any) -> dict[str, str]:
    """Returns hashes of what runs of some trees read: files by their full paths, installed laws by name."""
    return {source: fingerprint(source) for source in sources_in(*trees)}


def changed(files: Mapping[str, str]) -> str:
    """Returns which files are no longer what they were, and what to do; empty where all are."""
    told = ", ".join(file for file, known in files.items() if fingerprint(file) != known)
    return told and f"{told}: changed meanwhile; rows may be of either, so begin anew in another --out"


def account_of(files: Mapping[str, str], **asked: Any) -> dict[str, Any]:
    """Returns an account as its file keeps it: what was asked for, tree by tree, files and versions."""
    found: dict[str, Any] = json.loads(json.dumps({**asked, "files": dict(files), "versions": dict(versions())}))
    return found


def read_account(file: Path) -> dict[str, Any]:
    """Returns what an account says, nothing of one that is damaged."""
    try:
        held = json.loads(file.read_text())
    except ValueError:
        return {}
    return held if isinstance(held, dict) else {}


def held_account(file: Path, kind: str, account: Mapping[str, Any]) -> tuple[dict[str, Any], str]:
    """Returns what the account in a results folder says, and why it cannot be gone on with; nothing of a new folder.

    Args:
        file: of the account.
        kind: what it is of, in a word.
        account: what is asked for now, see `account_of`.
    """
    folder = file.parent
    used = is_used(folder)  # which removes what runs that were killed have left there
    if not file.is_file():
        return {}, f"{folder} exists already and holds no {kind}; choose another --out" if used else ""
    if not (held := read_account(file)):
        return {}, f"{file} is damaged; choose another --out"
    found = list(_differences(held, account))
    told = [f"  {line}" for line in found[:_MOST]] + [f"  and {len(found) - _MOST} more"] * (len(found) > _MOST)
    other = f"{folder} holds another {kind}; choose another --out. What is not the same:"
    return held, "\n".join([other, *told]) if found else ""


def _differences(held: Mapping[str, Any], asked: Mapping[str, Any]) -> Iterator[str]:
    """Yields what is not the same, by name."""
    if not held.keys() >= asked.keys():
        yield "it was begun by an earlier version"
        return
    for where in (key for key in asked if key not in _BESIDE):
        yield from (key if where == "asked" else f"{where}: {key}" for key in _leaves(held[where], asked[where]))
    for name, version in asked["versions"].items():
        if (before := held["versions"].get(name)) != version:
            yield f"{name} was {before}, here is {version}"
    for file in sorted({*held["files"], *asked["files"]}):
        if held["files"].get(file) != asked["files"].get(file):
            yield f"{file} has changed"


def _leaves(one: Any, other: Any, at: str = "") -> Iterator[str]:
    """Yields the dotted keys at which two plain trees differ."""
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        for key in {**one, **other}:
            yield from _leaves(one.get(key), other.get(key), f"{at}.{key}" if at else key)
    elif one != other:
        yield at
