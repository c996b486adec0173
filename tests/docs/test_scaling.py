"""docs/scaling.md and the files of docker/: what they name is there, and Ray takes what they tell it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from ruamel.yaml import YAML

ROOT = Path(__file__).parents[2]


def test_an_image_has_all_that_a_wheel_is_made_of() -> None:
    copied = re.findall(r"^COPY (.*) \S+$", (ROOT / "docker/Dockerfile").read_text(), re.MULTILINE)
    names = {name for line in copied for name in line.split()}
    assert all((ROOT / name).exists() for name in names)
    project = (ROOT / "pyproject.toml").read_text()
    bundled = re.findall(r'^"(\w+)" = "nhtrack/_bundled', project, re.MULTILINE)
    assert {"pyproject.toml", "constraints.txt", "README.md", "LICENSE", "src", *bundled} <= names


def test_containers_are_of_that_image_and_share_a_folder() -> None:
    file = ROOT / "docker/compose.yaml"
    services = YAML(typ="safe").load(file)["services"]
    assert set(services) == {"head", "worker"}
    for each in services.values():
        assert (file.parent / each["build"]["context"] / each["build"]["dockerfile"]).is_file()
        assert each["environment"]["RAY_AUTH_TOKEN_PATH"].startswith(each["volumes"][0].split(":")[1])


def test_ray_has_the_options_that_are_told() -> None:
    scripts = pytest.importorskip("ray.scripts.scripts")
    known = {option for each in scripts.start.params for option in each.opts}
    for name in ("docs/scaling.md", "docker/compose.yaml"):
        text = (ROOT / name).read_text().replace("\\\n", " ")
        told = [line for line in re.findall(r"ray start (--.*)", text) if "`" not in line]
        assert len(told) >= 2
        assert {word.partition("=")[0] for line in told for word in line.split() if word.startswith("--")} <= known
