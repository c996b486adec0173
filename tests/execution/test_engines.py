"""Executors by name: what cannot be had is told before anything is run."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from nhtrack.cli import app
from nhtrack.execution import EngineError, executor_of


@pytest.mark.parametrize(
    ("engine", "workers", "address", "said"),
    [
        ("rya", None, None, "no executor 'rya'; did you mean 'ray'? available: processes, ray, serial"),
        ("processes", None, "10.0.0.1:6379", "this machine, which has no address"),
        ("serial", 2, None, "one task after the other"),
        ("ray", None, "10.0.0.1", "expected an address such as 10.0.0.1:6379"),
        ("ray", None, "127.0.0.1:1", "no answer at address '127.0.0.1:1': Connection refused"),
    ],
)
def test_what_cannot_be_had_is_told(engine: str, workers: int | None, address: str | None, said: str) -> None:
    with pytest.raises(EngineError, match=re.escape(said)):
        print(executor_of(engine, workers, address).workers)


def test_without_ray_a_command_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    monkeypatch.chdir(tmp_path)
    for command in ("sweep sweep/small", "campaign campaign/small", "tune tour/hello", "paper", "fidelity --quick"):
        done = CliRunner().invoke(app, [*command.split(), "--executor", "ray"])
        assert done.exit_code == 2, done.output
        assert done.stderr.endswith("refused: executor ray: Ray is not installed; pip install 'nhtrack[ray]'\n")
        assert not list(tmp_path.iterdir())
