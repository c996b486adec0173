"""What this machine can and cannot do: each check says what was found and, where it failed, what to do."""

from __future__ import annotations

import importlib.metadata
import platform
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from nhtrack import assets, gl
from nhtrack.errors import NhtrackError, RenderError
from nhtrack.mjcf import has_dm_control

__all__ = ["Check", "report"]

# The packages that move numbers or draw pictures: the ones a report of trouble should name.
PACKAGES = ("mujoco", "numpy", "scipy", "xarray", "h5netcdf", "matplotlib", "imageio-ffmpeg")
OLDEST_PYTHON = (3, 11)


@dataclass(frozen=True)
class Check:
    """One thing a run needs.

    Attributes:
        name: what was looked at.
        ok: whether it will do.
        detail: what was found.
        remedy: what to do about it; empty where nothing need be done.
    """

    name: str
    ok: bool
    detail: str
    remedy: str = ""


def report() -> list[Check]:
    """Returns the state of everything a run needs; a check that breaks is a failed check, never an exception."""
    checks = [_python()]
    checks += [_package(name) for name in PACKAGES]
    checks += [_guarded(name, look) for name, look in _LOOKS.items()]
    return checks


def _guarded(name: str, look: Callable[[], str]) -> Check:
    """Returns a check whose `look` says what it found, or fails with what is wrong and its remedy in one message."""
    try:
        return Check(name, True, look())
    except NhtrackError as error:
        detail, _, remedy = str(error).partition(": ")
        return Check(name, False, detail, remedy or "see the message")
    except (ImportError, OSError) as error:
        return Check(name, False, f"{type(error).__name__}: {error}", "install the package again")


def _python() -> Check:
    found = f"{platform.python_version()} on {platform.platform(terse=True)}"
    oldest = ".".join(map(str, OLDEST_PYTHON))
    ok = sys.version_info[:2] >= OLDEST_PYTHON
    return Check("Python", ok, found, "" if ok else f"install Python {oldest} or newer")


def _package(name: str) -> Check:
    try:
        return Check(name, True, importlib.metadata.version(name))
    except importlib.metadata.PackageNotFoundError:
        return Check(name, False, "not installed", f"pip install {name}")


def _opengl() -> str:
    found = gl.find_backend()
    return f"{found.backend}, {found.renderer}"


def _ffmpeg() -> str:
    from nhtrack.video.encode import find_encoder  # imported here: it is what may be missing

    encoder = find_encoder()
    return f"{encoder.version} with libx264 ({encoder.path})"


def _batch() -> str:
    import mujoco
    from mujoco import batch

    return f"{batch.Batch.__name__} of MuJoCo {mujoco.__version__}"


def _robots() -> str:
    names = assets.robots()
    if not names:
        raise RenderError("no robots in models/: install the package again")
    return f"{', '.join(names)} in {assets.models_directory()}"


def _disk() -> str:
    """Writes a file where results go by default, and takes it away again."""
    here = Path.cwd()
    try:
        with tempfile.TemporaryFile(dir=here):
            return f"{here} is writeable"
    except OSError as error:
        raise NhtrackError(f"{here} is not writeable ({error.strerror}): give --out a folder that is") from error


def _mjcf() -> str:
    """MJCF is read without dm_control, too."""
    return importlib.metadata.version("dm_control") if has_dm_control() else "none, and none is needed"


_LOOKS: dict[str, Callable[[], str]] = {
    "OpenGL": _opengl,
    "ffmpeg": _ffmpeg,
    "dm_control": _mjcf,
    "mujoco.batch": _batch,
    "robots": _robots,
    "disk": _disk,
}
