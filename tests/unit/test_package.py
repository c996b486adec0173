"""Importing the package has no effects, and it knows its version."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

import nhtrack

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
    project = tomllib.loads(Path(__file__).parents[2].joinpath("pyproject.toml").read_text())
    assert nhtrack.__version__ == project["project"]["version"]


def test_package_is_typed() -> None:
    assert Path(nhtrack.__file__).with_name("py.typed").is_file()
