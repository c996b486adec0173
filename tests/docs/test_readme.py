"""What the README shows works as it stands there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import nhtrack
from nhtrack.experiment.load import load_text
from nhtrack.laws.address import entry_of

README = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")


def block(language: str) -> str:
    """Returns the one block of a language in the README."""
    (found,) = re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)
    return str(found)


def test_the_scenario_is_one() -> None:
    assert load_text(block("yaml"), source="README.md").name == "meet"


@pytest.mark.slow
def test_the_law_is_one_and_tracks(tmp_path: Path) -> None:
    (tmp_path / "my_law.py").write_text(block("py"), encoding="utf-8")
    scenario = block("yaml").replace("{name: published, kp: 1, kd: 2.5, ke: 0.5, k: 5}", "{file: my_law.py, k_x: 2}")
    loaded = load_text(scenario, directory=tmp_path, overrides=["backend=ideal"])
    assert entry_of(loaded.law.kind).interpreted is None
    error = nhtrack.run(loaded)["error"].sel(robot="follower")
    start, end = (float(abs(error[i, :2]).max()) for i in (0, -1))
    assert end < 0.05 * start
