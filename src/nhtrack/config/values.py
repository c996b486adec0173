"""Types of single values of a file, each with what it has to keep to."""

from __future__ import annotations

import re
from typing import Annotated, Literal, TypeAlias

from pydantic import AfterValidator, Field

from nhtrack.errors import clipped
from nhtrack.section import fault

ROBOT_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]*\Z")


def _printable(name: str) -> str:
    if not name.strip() or not name.isprintable() or len(name) > 100:
        raise fault(f"expected a short printable name, got {clipped(name)!r}")
    if any(mark in name for mark in "/\\") or name.startswith("."):
        raise fault(f"{name!r} names a results folder: leave out slashes and a leading dot")
    return name


def _robot_name(name: str) -> str:
    if not ROBOT_NAME.match(name):
        raise fault(f"expected a letter followed by letters, digits, '-' or '_', got {name!r}")
    return name


Pose: TypeAlias = Annotated[tuple[float, float, float], Field(strict=False)]
PlanarTwist: TypeAlias = Annotated[tuple[float, float], Field(strict=False)]
RunName: TypeAlias = Annotated[str, AfterValidator(_printable)]
Name: TypeAlias = Annotated[str, AfterValidator(_robot_name)]
Backend: TypeAlias = Literal["mujoco", "ideal"]
