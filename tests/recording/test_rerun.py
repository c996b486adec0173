"""A law that a recording brings along is code of whoever wrote it, and runs for nobody who does not say so."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import nhtrack
from commands import invoke
from nhtrack.errors import ScenarioError
from random_recording import ATTRIBUTES, SOME, sample


@pytest.fixture
def recorded(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Returns a recording whose law's file is gone, or what the test's parameter says."""
    how = getattr(request, "param", "gone")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("nhtrack.recording.rerun.cache_folder", lambda: tmp_path / "cache" / "compiled")
    runs = f"open({str(tmp_path / 'ran')!r}, 'w').close()\n"  # no law: who trusts it is told so, once it has run
    file = tmp_path / "law.py"
    if how != "gone":
        file.write_text(runs + "# changed\n" * (how == "changed"))
    text = {"name": "law", "file": str(file), "sha256": "../../../../tmp/", "source": runs, "gains": {}}
    more: dict[str, Any] = {} if how == "only named" else {"law": text}
    tree = ATTRIBUTES["scenario"] | {"law": {"file": str(file), "name": "law"}}
    return sample(names=SOME, scenario=tree, **more).save(tmp_path / "recording.nc")


def check(command: str, recorded: Path) -> None:
    """Gives a command with a recording, first without trust, then with it."""
    asked = command.format(recorded).split()
    done = invoke(*asked)
    assert done.exit_code == 2
    assert f"{recorded}: law: law 'law' ({recorded.with_name('law.py')}) is code" in done.output
    assert "--trust" in done.output
    assert "--set law.file=" in done.output
    assert not Path("ran").exists()
    assert "law.py:1: no function `command`" in invoke(*asked, "--trust").output
    assert Path("ran").exists()


@pytest.mark.parametrize(
    "command",
    ["run {} --set law.k=2", "feasibility {}", "tune {}", "compare {} kanayama", "compare tour/hello {}"],
)
def test_a_law_of_a_recording_runs_in_no_command_without_trust(recorded: Path, command: str) -> None:
    check(command, recorded)


@pytest.mark.parametrize("recorded", ["changed", "as it was", "only named"], indirect=True)
def test_nor_does_its_file(recorded: Path) -> None:
    check("run {}", recorded)


def test_nor_in_python(recorded: Path) -> None:
    ways = nhtrack.load, nhtrack.run, nhtrack.feasibility, nhtrack.tune
    for do in (*ways, lambda it: nhtrack.compare(it, "agile"), lambda it: nhtrack.compare("tour/hello", str(it))):
        with pytest.raises(ScenarioError, match=r"trust=True"):
            do(recorded)
    with pytest.raises(ScenarioError, match=r"trust=True"):
        nhtrack.run(nhtrack.Recording.load(recorded))
    assert not Path("ran").exists()
    assert nhtrack.load(recorded, law="kanayama").law.name == "kanayama"
    for do in ways:
        with pytest.raises(ScenarioError, match=r"no function `command`"):
            do(recorded, trust=True)
    with pytest.raises(ScenarioError, match=r"no function `command`"):
        nhtrack.compare("tour/hello", str(recorded), trust=True)
