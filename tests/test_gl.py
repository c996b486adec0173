"""The choice of an off-screen OpenGL, in fresh interpreters where the environment is the subject."""

from __future__ import annotations

import ctypes
import json
import os
import subprocess
import sys

import pytest

from nhtrack import gl
from nhtrack.errors import RenderError

NO_EGL = {"__EGL_VENDOR_LIBRARY_DIRS": "/nonexistent", "__EGL_VENDOR_LIBRARY_FILENAMES": "/nonexistent.json"}


@pytest.fixture(autouse=True)
def _forget_choice(monkeypatch):
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    monkeypatch.delenv("PYOPENGL_PLATFORM", raising=False)
    gl.find_backend.cache_clear()
    yield
    gl.find_backend.cache_clear()


def answers(monkeypatch, working: set[str]) -> list[str]:
    """Replaces the drawing by a table of what draws; returns the list of what was tried."""
    tried: list[str] = []

    def fake(backend: str) -> gl.Probe:
        tried.append(backend)
        return (
            gl.Probe(backend, "table")
            if backend in working
            else gl.Probe(backend, failure="not in the table")
        )

    monkeypatch.setattr(gl, "probe", fake)
    return tried


def in_fresh_python(script: str, **environment: str) -> subprocess.CompletedProcess[str]:
    clean = {key: value for key, value in os.environ.items() if key not in ("MUJOCO_GL", "PYOPENGL_PLATFORM")}
    return subprocess.run(
        [sys.executable, "-c", script], env=clean | environment, capture_output=True, text=True, timeout=120
    )


def osmesa_is_installed() -> bool:
    for name in ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"):
        try:
            ctypes.CDLL(name)
        except OSError:
            continue
        return True
    return False


def test_egl_comes_first(monkeypatch):
    tried = answers(monkeypatch, {"egl", "osmesa"})
    assert gl.choose_backend() == "egl"
    assert tried == ["egl"]
    assert os.environ["MUJOCO_GL"] == os.environ["PYOPENGL_PLATFORM"] == "egl"


def test_osmesa_is_the_fall_back(monkeypatch):
    tried = answers(monkeypatch, {"osmesa"})
    assert gl.choose_backend() == "osmesa"
    assert tried == ["egl", "osmesa"]
    assert os.environ["MUJOCO_GL"] == os.environ["PYOPENGL_PLATFORM"] == "osmesa"


def test_users_backend_is_tried_alone(monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "OSMesa")
    tried = answers(monkeypatch, {"egl", "osmesa"})
    assert gl.choose_backend() == "osmesa"
    assert tried == ["osmesa"]


def test_users_broken_backend_is_an_error_and_not_replaced(monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "osmesa")
    answers(monkeypatch, {"egl"})
    with pytest.raises(RenderError, match="MUJOCO_GL=osmesa cannot draw: install libosmesa6, or unset"):
        gl.choose_backend()


def test_users_glfw_leaves_pyopengl_alone(monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "glfw")
    answers(monkeypatch, {"glfw"})
    assert gl.choose_backend() == "glfw"
    assert "PYOPENGL_PLATFORM" not in os.environ


@pytest.mark.parametrize("value", ["", "on", "1"])
def test_mere_yes_leaves_the_choice(monkeypatch, value):
    monkeypatch.setenv("MUJOCO_GL", value)
    answers(monkeypatch, {"egl"})
    assert gl.choose_backend() == "egl"


@pytest.mark.parametrize("value", ["disable", "off", "0"])
def test_switched_off(monkeypatch, value):
    monkeypatch.setenv("MUJOCO_GL", value)
    tried = answers(monkeypatch, {"egl"})
    with pytest.raises(RenderError, match="switches rendering off; unset it"):
        gl.choose_backend()
    assert tried == []


def test_unknown_backend(monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "vulkan")
    answers(monkeypatch, {"egl"})
    with pytest.raises(RenderError, match="MUJOCO_GL=vulkan names no OpenGL backend; available: egl"):
        gl.choose_backend()


def device_answers(monkeypatch, drawing: set[str | None]) -> None:
    """Has EGL draw where the variable of its device is one of these, None for where it is not set."""

    def fake(backend: str) -> gl.Probe:
        device = os.environ.get("MUJOCO_EGL_DEVICE_ID")
        drawn = backend == "egl" and device in drawing
        return gl.Probe(backend, renderer="fake") if drawn else gl.Probe(backend, failure=f"no {backend} on {device}")

    monkeypatch.setattr(gl, "probe", fake)


@pytest.mark.parametrize("device", ["5", "-1", "x", "", "0.5"])
def test_a_device_that_does_not_draw_is_left_out_with_its_reason(monkeypatch, device):
    monkeypatch.setenv("MUJOCO_EGL_DEVICE_ID", device)
    device_answers(monkeypatch, {None})
    with pytest.warns(UserWarning, match=f"^MUJOCO_EGL_DEVICE_ID={device} is left out: no egl on {device}$"):
        assert gl.find_backend().backend == "egl"
    assert "MUJOCO_EGL_DEVICE_ID" not in os.environ


def test_a_device_that_draws_is_kept(monkeypatch):
    monkeypatch.setenv("MUJOCO_EGL_DEVICE_ID", "1")
    device_answers(monkeypatch, {"1"})
    assert gl.find_backend().ok
    assert os.environ["MUJOCO_EGL_DEVICE_ID"] == "1"


def test_where_no_device_draws_both_reasons_are_told(monkeypatch):
    monkeypatch.setenv("MUJOCO_EGL_DEVICE_ID", "5")
    device_answers(monkeypatch, set())
    with pytest.raises(RenderError, match="with MUJOCO_EGL_DEVICE_ID=5: no egl on 5; without: no egl on None"):
        gl.find_backend()
    assert os.environ["MUJOCO_EGL_DEVICE_ID"] == "5"


def test_nothing_draws_names_the_packages_in_one_line(monkeypatch):
    answers(monkeypatch, set())
    with pytest.raises(RenderError) as caught:
        gl.choose_backend()
    message = str(caught.value)
    assert "install libegl1 libgl1-mesa-dri libopengl0 or libosmesa6" in message
    assert "\n" not in message
    assert "MUJOCO_GL" not in os.environ


def test_probe_survives_a_dying_process(monkeypatch):
    monkeypatch.setattr(gl, "_PROBE_SCRIPT", "import os; os.abort()")
    attempt = gl.probe("egl")
    assert not attempt.ok
    assert "status" in attempt.failure


def test_probe_gives_up_on_a_hanging_driver(monkeypatch):
    monkeypatch.setattr(gl, "_PROBE_SCRIPT", "import time; time.sleep(60)")
    monkeypatch.setattr(gl, "_PROBE_SECONDS", 0.2)
    assert gl.probe("egl").failure == "no picture after 0 s"


def test_probe_rejects_an_empty_picture(monkeypatch):
    answer = json.dumps({"contrast": 0.0, "renderer": "blank"})
    monkeypatch.setattr(gl, "_PROBE_SCRIPT", f"print({answer!r})")
    assert gl.probe("egl").failure == "blank drew an empty picture"


def test_importing_touches_no_opengl():
    script = (
        "import sys; before = set(sys.modules); import nhtrack.gl, os;"
        "print([m for m in ('mujoco', 'OpenGL', 'glfw') if m in sys.modules], 'MUJOCO_GL' in os.environ)"
    )
    assert in_fresh_python(script).stdout.strip() == "[] False"


@pytest.mark.slow
def test_machine_without_egl_falls_back_or_says_what_to_install():
    script = "from nhtrack import gl; print(gl.choose_backend())"
    done = in_fresh_python(script, **NO_EGL)
    if osmesa_is_installed():
        assert done.stdout.strip() == "osmesa"
    else:
        assert "RenderError: no off-screen OpenGL: install libegl1" in done.stderr


@pytest.mark.slow
def test_real_context_after_mujoco_was_imported_without_opengl():
    script = """
import mujoco
from nhtrack import gl
context = gl.make_context(16, 16)
from OpenGL import GL
print(GL.glGetString(GL.GL_RENDERER).decode() == gl.find_backend().renderer)
context.free()
"""
    done = in_fresh_python(script)
    assert done.stdout.strip() == "True", done.stderr


@pytest.mark.slow
def test_pyopengl_bound_elsewhere_is_explained():
    script = """
import OpenGL.GL
from nhtrack import gl
try:
    gl.make_context(16, 16)
except gl.RenderError as error:
    print(error)
"""
    done = in_fresh_python(script, PYOPENGL_PLATFORM="glx")
    assert "draws in a fresh process but not in this one" in done.stdout, done.stderr
    assert "before Python starts" in done.stdout
