"""Choice of an off-screen OpenGL: what the user's MUJOCO_GL asks for, else EGL, else OSMesa.

A library that loads is no proof that a picture can be drawn, and a bad driver may take the process down
with it. So a backend is chosen by drawing one small picture in a process of its own. Nothing is probed
before a picture is asked for.

MuJoCo binds its default context class when it is first imported, which in this package is usually long
before anyone asks for a picture. Pictures are therefore drawn in a context that `make_context` builds from
the chosen backend's own module, whatever MuJoCo bound; MUJOCO_GL is set as well, for processes started
later and for a MuJoCo imported later.
"""

from __future__ import annotations

import functools
import importlib
import json
import os
import subprocess
import sys
import textwrap
import warnings
from dataclasses import dataclass
from typing import Protocol

from nhtrack.errors import RenderError

__all__ = ["Context", "Probe", "choose_backend", "find_backend", "make_context", "probe"]

CANDIDATES = ("egl", "osmesa")
PACKAGES = {"egl": "libegl1 libgl1-mesa-dri libopengl0", "osmesa": "libosmesa6"}

_OFF = frozenset({"disable", "disabled", "off", "false", "0"})
_ANY = frozenset({"", "enable", "enabled", "on", "true", "1"})
_WINDOWED = {"glx": "glfw", "wgl": "glfw"}  # MuJoCo's other names for contexts made by GLFW
_PROBE_SECONDS = 60.0
_DEVICE = "MUJOCO_EGL_DEVICE_ID"  # which of the machine's devices EGL draws on

# Draws a ball and says what drew it. A driver that loads but draws nothing returns an image without contrast.
_PROBE_SCRIPT = """
import importlib, json, sys
context = importlib.import_module("mujoco." + sys.argv[1]).GLContext(32, 32)
context.make_current()
import mujoco, numpy as np
from OpenGL import GL
model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>")
data = mujoco.MjData(model)
mujoco.mj_forward(model, data)
scene = mujoco.MjvScene(model, 10)
camera, everything = mujoco.MjvCamera(), mujoco.mjtCatBit.mjCAT_ALL
mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, camera, everything, scene)
render = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, render)
image, whole = np.zeros((32, 32, 3), np.uint8), mujoco.MjrRect(0, 0, 32, 32)
mujoco.mjr_render(whole, scene, render)
mujoco.mjr_readPixels(image, None, whole, render)
print(json.dumps({"contrast": float(image.std()), "renderer": GL.glGetString(GL.GL_RENDERER).decode()}))
"""


class Context(Protocol):
    """An off-screen OpenGL context as MuJoCo's backend modules make it."""

    def make_current(self) -> None:
        """Directs this thread's OpenGL calls to the context."""
        ...

    def free(self) -> None:
        """Releases the context."""
        ...


WITHHELD = "NHTRACK_GL"  # where `withhold` keeps what the user put into MUJOCO_GL


@dataclass(frozen=True)
class Probe:
    """What became of one attempt to draw.

    Attributes:
        backend: `egl`, `osmesa` or `glfw`.
        renderer: the driver's name for itself; empty where nothing was drawn.
        failure: why nothing was drawn, in one line; empty where something was.
    """

    backend: str
    renderer: str = ""
    failure: str = ""

    @property
    def ok(self) -> bool:
        """Whether a picture was drawn."""
        return not self.failure


def probe(backend: str) -> Probe:
    """Returns what happens when `backend` draws one small picture in a process of its own."""
    environment = os.environ | {"MUJOCO_GL": backend}
    environment.pop("PYOPENGL_PLATFORM", None)  # each backend's module sets the one it needs
    command = [sys.executable, "-P", "-c", _PROBE_SCRIPT, backend]
    try:
        done = subprocess.run(
            command, env=environment, capture_output=True, text=True, errors="replace", timeout=_PROBE_SECONDS
        )
    except subprocess.TimeoutExpired:
        return Probe(backend, failure=f"no picture after {_PROBE_SECONDS:.0f} s")
    except OSError as error:
        return Probe(backend, failure=f"cannot start {sys.executable or 'python'}: {error}")
    if done.returncode != 0:
        last_words = done.stderr.strip().splitlines() or [f"ended with status {done.returncode}"]
        return Probe(backend, failure=last_words[-1])
    answer = json.loads(done.stdout.strip().splitlines()[-1])
    if answer["contrast"] == 0.0:
        return Probe(backend, failure=f"{answer['renderer']} drew an empty picture")
    return Probe(backend, renderer=answer["renderer"])


@functools.cache
def find_backend() -> Probe:
    """Returns the first backend that draws, and leaves MUJOCO_GL and PYOPENGL_PLATFORM set to it.

    The user's MUJOCO_GL is tried alone. Without one: EGL, then OSMesa. The answer is kept for the life of
    the process.

    Raises:
        RenderError: nothing draws, rendering is switched off, or MUJOCO_GL names no backend; the message
            says what to do.
    """
    asked = os.environ.get(WITHHELD, os.environ.get("MUJOCO_GL", "")).strip().lower()
    if asked in _OFF:
        raise RenderError(f"MUJOCO_GL={asked} switches rendering off; unset it to draw pictures")
    candidates = CANDIDATES if asked in _ANY else (_WINDOWED.get(asked, asked),)
    if not set(candidates) <= {*CANDIDATES, "glfw"}:
        raise RenderError(f"MUJOCO_GL={asked} names no OpenGL backend; available: egl, osmesa, glfw")
    attempts = []
    for candidate in candidates:
        attempt = probe(candidate)
        if candidate == "egl" and not attempt.ok and _DEVICE in os.environ:
            attempt = _without_device(attempt)
        if attempt.ok:
            _announce(candidate)
            return attempt
        attempts.append(attempt)
    raise RenderError(_complaint(asked not in _ANY, attempts))


def _without_device(failed: Probe) -> Probe:
    """Returns what EGL draws without the user's choice of a device, which is given up where it does, with a warning."""
    number = os.environ.pop(_DEVICE)
    attempt = probe(failed.backend)
    if attempt.ok:
        warnings.warn(f"{_DEVICE}={number} is left out: {failed.failure}", stacklevel=2)
        return attempt
    os.environ[_DEVICE] = number
    return Probe(failed.backend, failure=f"with {_DEVICE}={number}: {failed.failure}; without: {attempt.failure}")


def withhold() -> None:
    """Moves the user's MUJOCO_GL out of MuJoCo's sight until a picture is asked for.

    MuJoCo cannot even be imported where MUJOCO_GL names a backend that is not installed, and where it names none a
    process is started to look for one; a run needs no pictures.
    """
    os.environ[WITHHELD] = os.environ.get("MUJOCO_GL", "")
    os.environ["MUJOCO_GL"] = "disable"


def choose_backend() -> str:
    """Returns the name of the backend that draws (`egl`, `osmesa` or `glfw`); see `find_backend`.

    Raises:
        RenderError: as `find_backend`.
    """
    return find_backend().backend


def make_context(width: int, height: int, backend: str | None = None) -> Context:
    """Returns an off-screen OpenGL context, current in this thread.

    Args:
        width: largest picture width [pixels].
        height: largest picture height [pixels].
        backend: one that is known to draw; by default the one that `choose_backend` finds.

    Raises:
        RenderError: nothing draws, or another library has bound PyOpenGL to a different platform in this
            process.
    """
    backend = backend or choose_backend()
    try:
        module = importlib.import_module(f"mujoco.{backend}")
        context: Context = module.GLContext(width, height)
        context.make_current()
    except Exception as error:  # a driver's failure has no type of its own
        raise RenderError(
            f"{backend} draws in a fresh process but not in this one ({type(error).__name__}: {error}); "
            f"set MUJOCO_GL={backend} and PYOPENGL_PLATFORM={backend} before Python starts"
        ) from error
    return context


def _announce(backend: str) -> None:
    os.environ["MUJOCO_GL"] = backend
    if backend in CANDIDATES:  # PyOpenGL knows no platform of the name glfw
        os.environ["PYOPENGL_PLATFORM"] = backend


def _complaint(one_asked: bool, attempts: list[Probe]) -> str:
    packages = " or ".join(PACKAGES.get(attempt.backend, "a window system") for attempt in attempts)
    reasons = "; ".join(f"{attempt.backend}: {textwrap.shorten(attempt.failure, 300)}" for attempt in attempts)
    if one_asked:
        backend = attempts[0].backend
        remedy = f"install {packages}, or unset MUJOCO_GL to try others"
        return f"MUJOCO_GL={backend} cannot draw: {remedy} ({reasons})"
    return f"no off-screen OpenGL: install {packages} (Debian packages; {reasons})"
