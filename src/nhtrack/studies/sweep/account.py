"""What a sweep's folder says that its rows were made of, so that rows of something else never come among them."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from nhtrack.analysis.machines import files_in, fingerprint
from nhtrack.config.sweep import Sweep
from nhtrack.errors import RefusedError
from nhtrack.files.folder import is_used, save_json
from nhtrack.recording.versions import versions
from nhtrack.studies.sweep.plan import Plan

ACCOUNT = "sweep.json"
_MOST = 5  # differences that are told


class SweepError(RefusedError):
    """A sweep that cannot be gone on with."""


def files_of(sweep: Sweep, tree: Mapping[str, Any]) -> dict[str, str]:
    """Returns hashes of the files that runs of a sweep read, by their full paths: own laws and robots, tables.

    Args:
        sweep: with full paths.
        tree: its scenario.
    """
    named = sweep.model_dump(mode="json", include={"set", "axes"})
    return {file: fingerprint(file) for file in sorted({*files_in(tree), *files_in(named)})}


def claim(plan: Plan, folder: Path, size: Callable[[], int]) -> int:
    """Returns how many runs a part has, after the account is written or found to be the same.

    Args:
        plan: of the sweep.
        folder: of its results.
        size: how many they would be in a sweep that begins.

    Raises:
        SweepError: the folder holds something else, or rows of other files or versions; with what is not the same.
    """
    used, account = is_used(folder), folder / ACCOUNT
    asked = {"asked": plan.sweep.model_dump(mode="json"), "base": plan.tree, "files": dict(plan.files)}
    asked = json.loads(json.dumps(asked | {"versions": dict(versions())}))
    if account.is_file():
        held = json.loads(account.read_text())
        if found := list(_differences(held, asked)):
            more = [f"and {len(found) - _MOST} more"] if len(found) > _MOST else []
            told = "\n".join(f"  {line}" for line in [*found[:_MOST], *more])
            raise SweepError(f"{folder} holds another sweep; choose another --out. What is not the same:\n{told}")
        return int(held["part"])
    if used:
        raise SweepError(f"{folder} exists already and holds no sweep; choose another --out")
    save_json(account, asked | {"part": (part := size())})
    return part


def require_unchanged(plan: Plan) -> None:
    """Raises where a file that runs read is no longer what it was when they began.

    Raises:
        SweepError: with the files.
    """
    changed = [file for file, known in plan.files.items() if fingerprint(file) != known]
    if changed:
        told = ", ".join(changed)
        raise SweepError(f"{told}: changed while the sweep ran; rows may be of either, so begin anew in another --out")


def _differences(held: Mapping[str, Any], asked: Mapping[str, Any]) -> Iterator[str]:
    """Yields what is not the same, by name."""
    for where, called in (("asked", ""), ("base", "scenario: ")):
        yield from (f"{called}{key}" for key in _leaves_that_differ(held.get(where), asked[where]))
    for name, version in asked["versions"].items():
        if (before := held.get("versions", {}).get(name)) != version:
            yield f"{name} was {before}, here is {version}"
    for file in sorted({*held.get("files", {}), *asked["files"]}):
        if held.get("files", {}).get(file) != asked["files"].get(file):
            yield f"{file} has changed"


def _leaves_that_differ(one: Any, other: Any, at: str = "") -> Iterator[str]:
    """Yields the dotted keys at which two plain trees differ."""
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        for key in {**one, **other}:
            yield from _leaves_that_differ(one.get(key), other.get(key), f"{at}.{key}" if at else key)
    elif one != other:
        yield at
