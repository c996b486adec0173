"""Every bad file of the corpus: exit code 2, one line per fault with its place and key, no traceback, nothing written.

`corpus/<name>.expected` holds one line per fault: `line:column key | part of the message`; 0:0 means the whole file.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from nhtrack.cli import app

CORPUS = Path(__file__).parent / "corpus"
NAMES = sorted(path.stem for path in CORPUS.glob("*.yaml"))


def expected_faults(name: str) -> list[tuple[str, str]]:
    """Returns what each line of the answer begins with and what it says."""
    faults = []
    for line in (CORPUS / f"{name}.expected").read_text().splitlines():
        place, message = line.split("| ", 1)
        position, _, key = place.strip().partition(" ")
        where = f"{name}.yaml" if position == "0:0" else f"{name}.yaml:{position}"
        faults.append((f"{where}: {key}: " if key else f"{where}: ", message))
    return faults


def assert_told(name: str, stderr: str) -> None:
    lines = stderr.splitlines()
    expected = expected_faults(name)
    for begin, message in expected:
        assert any(line.startswith(begin) and message in line for line in lines), f"{begin}{message}\nin:\n{stderr}"
    assert len(lines) == len(expected), stderr


def test_every_file_of_the_corpus_is_tried() -> None:
    assert len(NAMES) >= 40
    assert {path.stem for path in CORPUS.glob("*.expected")} == set(NAMES)


@pytest.fixture(scope="module")
def corpus(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns a copy of the corpus."""
    return Path(shutil.copytree(CORPUS, tmp_path_factory.mktemp("faulty") / "corpus"))


CASES = [("validate", name) for name in NAMES] + [("run", "everything_at_once")]
CASES += [(name.partition("_")[0], name) for name in NAMES if name.startswith(("campaign", "sweep"))]


@pytest.mark.parametrize(("command", "name"), CASES)
def test_faults_are_told_line_by_line(command: str, name: str, corpus: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(corpus)
    result = CliRunner().invoke(app, [command, f"{name}.yaml"])
    assert result.exit_code == 2
    assert result.stdout == ""
    assert_told(name, result.stderr)
    assert {path.name for path in corpus.iterdir()} == {path.name for path in CORPUS.iterdir()}


@pytest.mark.slow
def test_the_installed_command_says_the_same(tmp_path: Path) -> None:
    (tmp_path / "not_utf8.yaml").symlink_to(CORPUS / "not_utf8.yaml")
    command = [sys.executable, "-m", "nhtrack", "run", "not_utf8.yaml"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stdout == ""
    assert_told("not_utf8", done.stderr)
    assert [path.name for path in tmp_path.iterdir()] == ["not_utf8.yaml"]


def test_several_files_are_judged_together(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["validate", str(CORPUS / "nan.yaml"), "tour/hello", str(tmp_path / "none.yaml")])
    assert result.exit_code == 2
    assert result.stdout == "tour/hello: ok (1 follower, 24 s on the robot's clock, published law)\n"
    assert len(result.stderr.splitlines()) == 3
    assert "none.yaml: no such file" in result.stderr
