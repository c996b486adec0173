"""Importing the package has no effects, and it knows its version."""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import numpy as np
import pytest

import nhtrack

ROOT = Path(__file__).parents[1]

# Imported in a process of its own: this one may have imported anything by now.
PROBE = """
import os, sys
before = dict(os.environ)
import nhtrack
imported = {name.split(".")[0] for name in sys.modules}
heavy = imported & {"mujoco", "dm_control", "OpenGL", "glfw", "matplotlib", "imageio"}
assert not heavy, f"imported {sorted(heavy)}"
assert dict(os.environ) == before, "changed the environment"
"""


def test_import_is_silent_and_touches_no_graphics() -> None:
    done = subprocess.run([sys.executable, "-c", PROBE], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_version_is_that_of_the_project_file() -> None:
    project = tomllib.loads(ROOT.joinpath("pyproject.toml").read_text())
    assert nhtrack.__version__ == project["project"]["version"]


def test_package_is_typed() -> None:
    assert Path(nhtrack.__file__).with_name("py.typed").is_file()


@pytest.fixture(scope="module")
def unpacked_wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel's contents in a folder of their own, as an installation lays them out."""
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory", str(folder)]
    subprocess.run(command, cwd=ROOT, capture_output=True, check=True)
    (wheel,) = folder.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "site")
    return folder / "site"


def files_in(folder: Path) -> set[Path]:
    paths = {path.relative_to(folder) for path in folder.rglob("*") if path.is_file()}
    assert paths
    return {path for path in paths if "__pycache__" not in path.parts}


@pytest.mark.slow
def test_wheel_carries_every_file(unpacked_wheel: Path) -> None:
    package = unpacked_wheel / "nhtrack"
    for folder in ("models", "scenarios", "examples"):
        assert files_in(package / "_bundled" / folder) == files_in(ROOT / folder)
    assert files_in(package / "report" / "assets") == files_in(ROOT / "src/nhtrack/report/assets")


@pytest.mark.slow
def test_installed_package_finds_its_robots_outside_the_checkout(unpacked_wheel: Path, tmp_path: Path) -> None:
    # -S leaves the site packages out, and with them the checkout that is installed in place
    script = "from nhtrack import assets; print(assets.find_robot('nh_mini'))"
    libraries = Path(np.__file__).parents[1]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(unpacked_wheel), str(libraries)])}
    command = [sys.executable, "-S", "-c", script]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
    assert Path(done.stdout.strip()) == unpacked_wheel / "nhtrack/_bundled/models/nh_mini/robot.xml"
