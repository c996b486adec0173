"""Compiled code where it meets processes, threads, folders, and laws that fail in the middle of a run."""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from nhtrack import compiled
from nhtrack.experiment.build import build
from nhtrack.experiment.followers import begin_followers
from nhtrack.experiment.kernels import run_ideal
from nhtrack.experiment.load import load
from nhtrack.experiment.loop import FullRecorder, Rollout, rollout, run_loop
from nhtrack.laws import LawKind, address, law_in
from nhtrack.laws.address import InterpretedLawWarning
from nhtrack.network import Network
from nhtrack.simulation.flow import drive_flows
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.scene import stepped_scene
from nhtrack.simulation.state import State
from watching import ECHO

DT = 0.01
CHAIN = Network.from_parents({"leader": (), "a": ("leader",), "b": ("a",)})


@pytest.fixture(scope="module")
def as_python(tmp_path_factory: pytest.TempPathFactory) -> LawKind:
    """The law that echoes, with a statement in it that is not compiled."""
    path, seen = tmp_path_factory.mktemp("laws") / "echo.py", "    return Memory(\n"
    path.write_text(ECHO.source.replace(seen, "    import json\n" + seen))
    return law_in(path)


def ran(kind: LawKind, **gains: float) -> Rollout:
    inputs = np.random.default_rng(0).uniform(-1, 1, (100, 2))
    begin = State(0.5, np.zeros((3, 3)), np.tile([0.5, 0.0, 0.2], (3, 1)))
    return rollout(IdealSimulation(CHAIN.names, None, DT), kind(**gains), CHAIN, inputs, begin)


@pytest.mark.slow
def test_a_law_as_python_does_what_it_does_compiled_and_says_so_once(as_python: LawKind) -> None:
    with pytest.warns(InterpretedLawWarning, match="law 'echo' runs as Python") as told:
        first = ran(as_python)
    assert len(told) == 1
    again, compiled = ran(as_python), ran(ECHO)
    for done in (first, again):
        for name, values in compiled.variables.items():
            np.testing.assert_array_equal(done.variables[name], values, err_msg=name)


def test_memory_of_any_order_is_run_by_the_code_there_is() -> None:
    """Starts and inputs that are views, in another order or not to be written to: what is compiled is compiled once."""
    begin, inputs = State(0.0, np.zeros((3, 3)), np.zeros((3, 3))), np.zeros((3, 2))
    several = State(0.0, np.broadcast_to(begin.g, (2, 3, 3)), np.zeros((3, 3, 2)).T)
    inputs.flags.writeable = False
    simulation = IdealSimulation(CHAIN.names, None, DT)
    for start, root in ((begin, inputs), (several, np.broadcast_to(inputs[:, None], (3, 2, 2)))):
        rollout(simulation, ECHO(), CHAIN, root, start)
        simulation.drive_by(np.zeros((1, *start.g.shape[:-1], 2)[::-1]).T)
    assert [len(each.signatures) for each in (begin_followers, run_ideal, drive_flows)] == [1, 1, 1]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::nhtrack.laws.address.InterpretedLawWarning")
@pytest.mark.parametrize("how", ["compiled", "as Python"])
@pytest.mark.parametrize("calls", [0, 7, 8, 50])
def test_a_law_that_raises_leaves_the_rows_before(as_python: LawKind, how: str, calls: int) -> None:
    """At the start, at either end of the first block of periods, and in the middle of another."""
    kind = ECHO if how == "compiled" else as_python
    whole, done = ran(ECHO), ran(kind, raises=calls)
    line = kind.source.splitlines().index('        raise ValueError("enough")') + 1
    assert done.failure is not None
    assert (done.failure.robot, done.failure.time) == ("a", pytest.approx(0.5 + calls * DT))
    assert done.failure.reason == f"law 'echo' raised ValueError: enough ({kind.file}:{line})"
    assert len(done.time) == calls
    for name, values in done.variables.items():
        np.testing.assert_array_equal(values, whole.variables[name][:calls], err_msg=name)


@pytest.mark.filterwarnings("ignore::nhtrack.laws.address.InterpretedLawWarning")
def test_a_law_as_python_that_is_stopped_leaves_the_rows_before(
    as_python: LawKind, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Machine code calls it, which goes on after what it raises."""
    calls, call_law = itertools.count(), address.call_law

    def stopped(*given: object) -> tuple[float, ...]:
        if next(calls) == 50:
            raise KeyboardInterrupt
        return call_law(*given)  # type: ignore[arg-type]

    monkeypatch.setattr(address, "call_law", stopped)
    done = ran(as_python)
    assert (done.interrupted, done.failure) == (True, None)
    assert 0 < len(done.time) <= 50


@pytest.mark.slow
def test_threads_change_no_bit_on_wheels() -> None:
    experiment = build(load("tour/hello", ["duration=1"]))
    rng, found = np.random.default_rng(0), []
    g = experiment.start.g + 0.1 * rng.uniform(-1, 1, (5, *experiment.start.g.shape)) * [1, 1, 3]
    begin = State(0.0, g, np.broadcast_to(experiment.start.xi, g.shape))
    for count in (1, 3):
        scene, recorder = stepped_scene(experiment.scene), FullRecorder()
        simulation = MujocoSimulation(scene, experiment.dt, (5,), count, spec=experiment.scene)
        failure = run_loop(
            simulation, experiment.law, experiment.network, experiment.inputs, begin, recorder, experiment.tracking
        )
        assert failure is None
        found.append(recorder.kept(batch=True))
    for name, values in found[0][0].items():
        np.testing.assert_array_equal(found[1][0][name], values, err_msg=name)
    np.testing.assert_array_equal(found[1][1], found[0][1])


# -- processes and their cache ----------------------------------------------------------------------

SCRIPT = """
import ctypes
import numpy as np
from nhtrack.compiled import cache_folder
from nhtrack.laws import law_in
from nhtrack.laws.address import entry_of
pointers = [np.full(size, 2.0) for size in (1, 5, 6, 9, 1, 3)]
command = ctypes.CFUNCTYPE(None, *6 * [ctypes.c_void_p])(entry_of(law_in({file!r})).command)
command(*(each.ctypes.data for each in pointers))
print(pointers[-1].tolist(), cache_folder("laws"))
"""
SMALL = """
from typing import NamedTuple
class Gains(NamedTuple):
    k: float = 2.0
def command(gains, period, limits, follower, leader, memory):
    return gains.k * leader.x, leader.u_theta, memory
"""


def begun(tmp_path: Path, cache: Path) -> subprocess.Popen[str]:
    """A process that compiles a small law and calls it."""
    file = tmp_path / "small.py"
    if not file.exists():
        file.write_text(SMALL)
    command = [sys.executable, "-W", "error", "-c", SCRIPT.format(file=str(file))]
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.Popen(command, env=os.environ | {"NUMBA_CACHE_DIR": str(cache)}, text=True, **streams)


def ended(process: subprocess.Popen[str]) -> str:
    said, complaint = process.communicate(timeout=300)
    assert process.returncode == 0, complaint
    return said.strip()


RESULT = "[4.0, 2.0, 2.0]"


@pytest.mark.slow
def test_two_processes_fill_one_cold_cache(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    pair = [begun(tmp_path, cache) for _ in range(2)]
    said = [ended(process) for process in pair]
    third = ended(begun(tmp_path, cache))
    assert said == [third, third]
    assert third.startswith(f"{RESULT} {cache}")
    assert not list(cache.rglob(".*")), "nothing half written is left"


def test_compiled_code_is_kept_apart_by_the_sources_it_is_made_of(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compiled, "_PACKAGE", tmp_path)
    for room in compiled._ROOMS:
        (tmp_path / f"{room}.py").write_text("first")
    stamps = {room: compiled._stamp.__wrapped__(room) for room in compiled._ROOMS}
    (tmp_path / "planar.py").write_text("other")
    changed = {room for room, stamp in stamps.items() if compiled._stamp.__wrapped__(room) != stamp}
    assert changed == {"planar", "laws", "simulation", "experiment"}


def test_old_compiled_code_of_a_room_is_swept(tmp_path: Path) -> None:
    now, fresh, old, other = (tmp_path / f"compiled-{name}" for name in ("laws-1", "laws-2", "laws-3", "planar-1"))
    for folder in (now, fresh, old, other):
        folder.mkdir()
    for folder in (now, old, other):
        os.utime(folder, (0.0, 0.0))
    compiled._sweep(now, "laws")
    assert set(tmp_path.iterdir()) == {now, fresh, other}
