"""What moves numbers from one installation to another."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from functools import cache

from nhtrack.mjcf import has_dm_control

_VERSIONED = ("nhtrack", "mujoco", "numpy", "scipy", "array-api-compat")


@cache
def versions() -> Mapping[str, str]:
    """Returns the versions of Python, of the package and of the libraries that move its numbers."""
    import importlib.metadata

    names = (*_VERSIONED, *(["dm-control"] if has_dm_control() else []))
    return {"python": platform.python_version()} | {name: importlib.metadata.version(name) for name in names}
