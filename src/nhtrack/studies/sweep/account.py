"""What a sweep's folder says that its rows were made of."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from nhtrack.analysis.account import account_of, changed, held_account, made_of
from nhtrack.config.sweep import Sweep
from nhtrack.errors import RefusedError
from nhtrack.files.folder import save_json
from nhtrack.studies.sweep.plan import Plan

ACCOUNT = "sweep.json"


class SweepError(RefusedError):
    """A sweep that cannot be gone on with."""


def files_of(sweep: Sweep, tree: Mapping[str, Any]) -> dict[str, str]:
    """Returns hashes of what runs of a sweep read: own laws and robots and tables by their full paths, installed laws.

    Args:
        sweep: with full paths.
        tree: its scenario.
    """
    return made_of(tree, sweep.model_dump(mode="json", include={"set", "axes"}))


def claim(plan: Plan, folder: Path, size: Callable[[], int]) -> int:
    """Returns how many runs a part has, after the account is written or found to be the same.

    Args:
        plan: of the sweep.
        folder: of its results.
        size: how many they would be in a sweep that begins.

    Raises:
        SweepError: the folder holds something else, or rows of other files or versions; with what is not the same.
    """
    asked = account_of(plan.files, asked=plan.sweep.model_dump(mode="json"), scenario=plan.tree)
    held, why = held_account(folder / ACCOUNT, "sweep", asked)
    if why:
        raise SweepError(why)
    if held:
        return int(held["part"])
    save_json(folder / ACCOUNT, asked | {"part": (part := size())})
    return part


def require_unchanged(plan: Plan) -> None:
    """Raises where a file that runs read is no longer what it was when they began.

    Raises:
        SweepError: with the files.
    """
    if said := changed(plan.files):
        raise SweepError(said)
