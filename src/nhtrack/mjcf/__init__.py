"""Reads MJCF, edits it and hangs one into another: with dm_control, or without it where it cannot be installed.

dm_control asks for labmaze, which has no wheels beyond Python 3.12. There `nhtrack.mjcf.plain` takes its place: the few
operations of `dm_control.mjcf` that scenes are composed with, which give the same compiled models.
"""

from __future__ import annotations

import os
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, cast

from nhtrack.mjcf import plain

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["has_dm_control", "parse_mjcf", "read_mjcf"]


def has_dm_control() -> bool:
    """Returns whether dm_control is installed, so that it reads and edits MJCF."""
    return find_spec("dm_control") is not None


def read_mjcf(file: Path) -> plain.Element:
    """Returns the root element of an MJCF file: dm_control's where it is installed, else that of `plain`.

    Of dm_control's element only what `plain.Element` has may be used.

    Args:
        file: an MJCF file.

    Raises:
        RobotError: it is no MJCF, or has what cannot be read.
        OSError: the file, or one that it speaks of, cannot be read.
    """
    if not has_dm_control():
        return plain.from_path(file)
    return cast("plain.Element", _dm_control_mjcf().from_path(str(file)))


def parse_mjcf(text: str) -> plain.Element:
    """Returns the root element of an MJCF text, as `read_mjcf` that of a file; its files have full paths."""
    if not has_dm_control():
        return plain.from_text(text)
    return cast("plain.Element", _dm_control_mjcf().from_xml_string(text))


def _dm_control_mjcf() -> Any:
    # Imported without the search for a display that its renderer would begin.
    chosen = os.environ.get("MUJOCO_GL")
    os.environ["MUJOCO_GL"] = "disable"
    try:
        from dm_control import mjcf
    finally:
        if chosen is None:
            del os.environ["MUJOCO_GL"]
        else:
            os.environ["MUJOCO_GL"] = chosen
    return mjcf
