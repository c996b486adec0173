"""The library that reads and edits MJCF."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any


def read_mjcf(file: Path) -> Any:
    """Returns the dm_control element of an MJCF file.

    dm_control is imported without the search for a display that its renderer would begin.
    """
    chosen = os.environ.get("MUJOCO_GL")
    os.environ["MUJOCO_GL"] = "disable"
    try:
        from dm_control import mjcf
    finally:
        if chosen is None:
            del os.environ["MUJOCO_GL"]
        else:
            os.environ["MUJOCO_GL"] = chosen
    return mjcf.from_path(str(file))
