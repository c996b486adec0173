"""The account of the machine: what is found, what is missing, and what is said to do about it."""

from __future__ import annotations

import pytest

from nhtrack import gl
from nhtrack.cli import doctor
from nhtrack.errors import RenderError
from nhtrack.video import encode


@pytest.fixture
def _drawing(monkeypatch):
    monkeypatch.setattr(gl, "find_backend", lambda: gl.Probe("egl", "a driver"))


def by_name(checks: list[doctor.Check]) -> dict[str, doctor.Check]:
    return {check.name: check for check in checks}


@pytest.mark.usefixtures("_drawing")
def test_healthy_machine(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    checks = by_name(doctor.report())
    assert {"Python", "mujoco", "dm_control", "OpenGL", "ffmpeg", "mujoco.batch", "robots", "disk"} <= set(checks)
    assert all(check.ok for check in checks.values()), [check for check in checks.values() if not check.ok]
    assert not any(check.remedy for check in checks.values())
    assert checks["OpenGL"].detail == "egl, a driver"
    assert "nh_mini" in checks["robots"].detail
    assert "libx264" in checks["ffmpeg"].detail
    assert list(tmp_path.iterdir()) == []


def test_no_opengl_is_a_failed_check_with_a_remedy(monkeypatch):
    def nothing_draws() -> gl.Probe:
        raise RenderError("no off-screen OpenGL: install libegl1")

    monkeypatch.setattr(gl, "find_backend", nothing_draws)
    check = by_name(doctor.report())["OpenGL"]
    assert check == doctor.Check("OpenGL", False, "no off-screen OpenGL", "install libegl1")


@pytest.mark.usefixtures("_drawing")
@pytest.mark.parametrize(
    ("program", "detail", "remedy"),
    [(None, "no working ffmpeg", "install the Debian package ffmpeg"), ("mpeg4", "has no libx264", "")],
)
def test_broken_ffmpeg(monkeypatch, tmp_path, program, detail, remedy):
    path = tmp_path / "ffmpeg"
    if program is not None:
        path.write_text(f"#!/bin/sh\necho ' V..... {program}'\n")
        path.chmod(0o755)
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(path))
    encode.find_encoder.cache_clear()
    try:
        check = by_name(doctor.report())["ffmpeg"]
    finally:
        encode.find_encoder.cache_clear()
    assert not check.ok
    assert detail in check.detail
    assert remedy in check.remedy


@pytest.mark.usefixtures("_drawing")
def test_old_python_and_missing_package(monkeypatch):
    monkeypatch.setattr(doctor, "PACKAGES", ("numpy", "no-such-package"))
    monkeypatch.setattr(doctor, "OLDEST_PYTHON", (4, 2))
    checks = by_name(doctor.report())
    assert checks["numpy"].ok
    assert (checks["Python"].ok, checks["Python"].remedy) == (False, "install Python 4.2 or newer")
    assert checks["no-such-package"] == doctor.Check(
        "no-such-package", False, "not installed", "pip install no-such-package"
    )


@pytest.mark.usefixtures("_drawing")
def test_folder_that_cannot_be_written(monkeypatch):
    def refuse(**_: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(doctor.tempfile, "TemporaryFile", refuse)
    check = by_name(doctor.report())["disk"]
    assert not check.ok
    assert "not writeable (Permission denied)" in check.detail
    assert "--out" in check.remedy
