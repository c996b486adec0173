"""A law of one's own in every command, in a folder outside the checkout."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from nhtrack import assets
from nhtrack.cli import app
from nhtrack.experiment.load import load
from nhtrack.recording import Recording

CAMPAIGN = """\
name: mine
duration: 6
laws: {mine: {file: my_law.py, k_x: 2}, rival: {name: kanayama}}
families: [line]
starts: {count: 4, radius: 1}
arrival: {last: 1}
tuning: {laws: [mine], budget: 8, starts: 2}
"""
QUIET = ["--no-video", "--no-figures", "--no-report"]


@pytest.fixture(autouse=True)
def _folder(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder with a scenario and its law, at one place for all tests: a law is compiled for its place and text."""
    folder = tmp_path_factory.getbasetemp() / "own_laws"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    monkeypatch.chdir(folder)
    scenario = assets.find_example("write_a_law/my_scenario.yaml").read_text(encoding="utf-8")
    Path("my_scenario.yaml").write_text(scenario + "backend: ideal\n", encoding="utf-8")
    Path("my_law.py").write_text(assets.find_example("write_a_law/my_law.py").read_text(encoding="utf-8"))


def nhtrack(*arguments: str, code: int = 0) -> Result:
    done = CliRunner().invoke(app, list(arguments))
    assert done.exit_code == code, done.output
    return done


def test_init_writes_a_law_and_replaces_none() -> None:
    os.remove("my_law.py")
    said = nhtrack("init", "--law").output
    assert said.startswith("wrote my_law.py; try it with:")
    assert "my_law law" in nhtrack("validate", "my_scenario.yaml").output
    Path("my_law.py").write_text("mine", encoding="utf-8")
    assert "my_law.py exists" in nhtrack("init", "--law", "my_law.py", code=1).output
    assert Path("my_law.py").read_text(encoding="utf-8") == "mine"
    nhtrack("init", "--law", "my_law.py", "--force")
    assert "class Gains" in Path("my_law.py").read_text(encoding="utf-8")
    assert "a law is a Python file" in nhtrack("init", "--law", "law.yaml", code=2).output


@pytest.mark.parametrize(
    ("before", "after", "expected"),
    [
        ("def command", "def comand", "my_law.py:1: no function `command`"),
        ("(v - last_v) / period", "v / (period - period)", "my_law.py:52: `command` raised ZeroDivisionError"),
        ("k_x: Annotated[float", "k_z: Annotated[float", "law.k_x: unknown key; did you mean 'k_z'?"),
    ],
)  # fmt: skip
def test_a_faulty_law_is_refused_before_a_run(before: str, after: str, expected: str) -> None:
    law = Path("my_law.py").read_text(encoding="utf-8")
    Path("my_law.py").write_text(law.replace(before, after), encoding="utf-8")
    for command in ("validate", "run"):
        said = nhtrack(command, "my_scenario.yaml", code=2).output
        assert expected in said
        assert "my_scenario.yaml:9:" in said
    assert not Path("runs").exists()


@pytest.mark.slow
def test_run_and_run_again_without_the_file() -> None:
    nhtrack("run", "my_scenario.yaml", *QUIET, "--set", "law.k_x=3", "--out", "first")
    os.rename("my_law.py", "away.py")
    said = nhtrack("run", "first/recording.nc", "--trust", *QUIET, "--out", "second").output
    assert "my_law.py is gone: law 'my_law' is taken from the recording" in said
    first, second = (Recording.load(f"{name}/recording.nc") for name in ("first", "second"))
    assert (first["pose"] == second["pose"]).all()
    assert first.scenario.law.k_x == 3
    law = json.loads(first.dataset.attrs["law"])
    assert (law["name"], law["gains"]["k_x"], law["source"]) == ("my_law", 3, Path("away.py").read_text())


@pytest.mark.slow
def test_feasibility_and_gains_that_tune_writes_back() -> None:
    assert "Fits at" in nhtrack("feasibility", "my_scenario.yaml").output
    nhtrack("tune", "my_scenario.yaml", "--budget", "8", "--write", "--set", "law.k_x=0.1", "--set", "duration=6")
    text = Path("my_scenario.yaml").read_text(encoding="utf-8")
    assert "law: {file: my_law.py, k_x: " in text
    assert load("my_scenario.yaml").law.k_x > 0.1


@pytest.mark.slow
def test_compare_and_a_campaign_in_workers() -> None:
    short = ["--backend", "ideal", "--set", "duration=1"]
    assert "my_law" in nhtrack("compare", "tour/hello", "my_law.py", *short, *QUIET, "--out", "both").output
    assert "law" in Recording.load("both/my_law/recording.nc").dataset.attrs
    Path("mine.yaml").write_text(CAMPAIGN, encoding="utf-8")
    quiet = ["--no-figures", "--no-report", "--processes", "1"]
    said = nhtrack("campaign", "mine.yaml", *quiet).output
    for law in ("mine", "rival"):
        assert f"{law}: 4 starts against each reference" in said
    account = json.loads(Path("runs/campaign-mine/tuning/mine-line.json").read_text())
    assert load("runs/campaign-mine/worst/mine.yaml").law.k_x == account["gains"]["k_x"]
    with open("my_law.py", "a", encoding="utf-8") as law:
        law.write("# changed\n")
    assert "my_law.py has changed" in nhtrack("campaign", "mine.yaml", *quiet, code=2).output


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:law .* runs as Python")  # as `main` does
def test_a_law_as_python_says_so_once_and_keeps_its_recording_when_it_breaks_down() -> None:
    text, first = Path("my_law.py").read_text(encoding="utf-8"), "    v, omega = velocities"
    breaks = f"    import json\n    assert follower.x < 0.5 or gains.k_x != 1, 'too far'\n{first}"
    Path("my_law.py").write_text(text.replace(first, breaks), encoding="utf-8")
    tuned = nhtrack("tune", "my_scenario.yaml", "--budget", "8", code=3).output
    asked = nhtrack("feasibility", "my_scenario.yaml", code=3).output
    said = nhtrack("run", "my_scenario.yaml", *QUIET, "--out", "out", code=3).output
    for each in (tuned, asked, said):
        assert each.count("law 'my_law' runs as Python, each call some 250 times slower") == 1
        assert "AssertionError: too far" in each
        assert "my_law.py:51): robot 'follower' at t = " in each
    assert Recording.load("out/recording.nc").outcome.startswith("diverged")
