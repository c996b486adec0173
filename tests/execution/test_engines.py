"""Executors by name: what cannot be had is told before anything is run, so are machines that are not like this one."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner

from nhtrack.analysis import machines
from nhtrack.analysis.machines import MachineError, require_machines
from nhtrack.cli import app
from nhtrack.execution import EngineError, Serial, executor_of
from nhtrack.execution.contract import Result

LAW = Path(__file__).parents[1] / "own_laws" / "spring.py"


class Elsewhere(Serial):
    """Works on another machine, which has what `change` makes of this one's."""

    elsewhere = True

    def __init__(self, change: Callable[..., tuple[machines._Facts, bool]]) -> None:
        self._change = change

    def everywhere(self, work: Callable[[], Result]) -> list[tuple[str, Result]]:
        return [("10.0.0.2", self._change(*work()))]  # type: ignore[list-item,misc]


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


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda facts, writes: (facts, False), "cannot write into"),
        (lambda facts, writes: (facts._replace(sources=""), writes), "has other sources of nhtrack"),
        (lambda facts, writes: (facts._replace(versions={"numpy": "1"}), writes), "has numpy 1, this machine has 2"),
        (lambda facts, writes: (facts._replace(files=dict.fromkeys(facts.files, "")), writes), "spring.py is not"),
        (lambda facts, writes: (facts._replace(files=dict.fromkeys(facts.files, "0")), writes), "is another there"),
    ],
)
def test_machines_that_are_not_like_this_one_are_refused(
    change: Callable[..., tuple[machines._Facts, bool]], said: str, tmp_path: Path
) -> None:
    with pytest.raises(MachineError, match=rf"(?s)^10\.0\.0\.2: .*{said}"):
        require_machines(Elsewhere(change), tmp_path / "out", {"law": {"file": str(LAW)}})
    assert not list(tmp_path.iterdir())


def test_machines_like_this_one_are_taken(tmp_path: Path) -> None:
    require_machines(Elsewhere(lambda *same: same), tmp_path / "out", {"law": [str(LAW)]})
