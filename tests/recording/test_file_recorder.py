"""A run that is kept in a file, block by block, is the run that is kept in memory."""

from __future__ import annotations

import resource
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from nhtrack.analysis import extent
from nhtrack.analysis.beforehand import beforehand
from nhtrack.analysis.metrics import summary
from nhtrack.config.scenario import Scenario
from nhtrack.errors import WriteError
from nhtrack.experiment.build import build
from nhtrack.experiment.load import load
from nhtrack.files.appended import AppendedDataset
from nhtrack.presentation import thinned as thinning
from nhtrack.recording import Recording, file_recorder, reading, recording
from nhtrack.studies.run.run import simulate
from random_recording import SOME, assert_same_bits, sample


@pytest.fixture
def tiny(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every run goes to a file, some rows at a time, and is read a robot at a time."""
    monkeypatch.setattr(extent, "MEMORY", 0)
    monkeypatch.setattr(file_recorder, "_BUFFER", 5000)
    monkeypatch.setattr(reading, "LARGE", 0)
    monkeypatch.setattr(recording, "_SHARE", 1)


def scenario(backend: str, every: int) -> Scenario:
    return load("tour/hello", ["duration=0.35", f"backend={backend}", f"record.every={every}"])


@pytest.mark.parametrize(("backend", "every"), [("mujoco", 3), ("ideal", 1)])
def test_a_run_in_blocks_is_the_run_in_memory(backend: str, every: int, tmp_path: Path, tiny: None) -> None:
    whole, blocks = (simulate(scenario(backend, every), folder=folder) for folder in (None, tmp_path))
    file = blocks.recording.save(tmp_path / "named.nc")
    read = Recording.load(file)
    for found in (blocks.recording, read):
        assert_same_bits(found.dataset, whole.recording.dataset)
        assert found.dataset.attrs == whole.recording.dataset.attrs
    assert blocks.summary == whole.summary
    assert summary(read).items() <= whole.summary.items()
    assert not list(tmp_path.glob("recording.nc"))


def test_an_interrupted_run_keeps_its_rows(tmp_path: Path, tiny: None) -> None:
    def stopped(name: str) -> object:
        def report(done: int, total: int) -> None:
            if name == "MuJoCo" and done > total / 2:
                raise KeyboardInterrupt

        return report

    whole, part = simulate(scenario("mujoco", 1)), simulate(scenario("mujoco", 1), stopped, tmp_path)
    assert part.recording.outcome == "interrupted"
    rows = part.recording.rows
    assert len(whole.recording.time) / 2 <= rows < len(whole.recording.time)
    read = Recording.load(part.recording.save(tmp_path / "named.nc"))
    for name in ("pose", "ideal_pose", "wheel_load", "qpos"):
        np.testing.assert_array_equal(read[name], whole.recording[name][:rows])


@pytest.fixture
def full_disk() -> Iterator[None]:
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, hard))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_a_full_disk_names_the_file_and_ends_nothing_else(tmp_path: Path, full_disk: None) -> None:
    data = sample(2000, SOME).dataset
    file = AppendedDataset(tmp_path / "large.nc", data.isel(time=slice(0)), 16)

    def fill() -> None:
        for first in range(0, 2000, 16):
            rows = slice(first, first + 16)
            file.append(first, {str(name): data[name].values[rows] for name in (*SOME, "qpos", "time")})

    with pytest.raises(WriteError, match=r"cannot write .*large\.nc: File too large"):
        fill()
    file.discard()


def test_a_thinned_recording_keeps_peaks_ends_and_wanted_times(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = sample(5000)
    assert thinning.thinned(whole) is whole
    monkeypatch.setattr(thinning, "LARGE", 0)
    monkeypatch.setattr(thinning, "_DRAWN", 1000)
    monkeypatch.setattr(thinning, "_BLOCK", 10**6)
    whole.dataset["wheel_torque"][1234, 1, 0] = -1e3
    few = thinning.thinned(whole, at=np.array([7.001, 23.456]))
    assert len(few.time) < 1500
    assert few.rows == 5000
    assert {0.0, 7.0, 7.01, 23.45, 23.46, 12.34, 49.99} <= set(np.round(few.time, 9))
    rows = np.searchsorted(whole.time, few.time)
    np.testing.assert_array_equal(few["pose"], whole["pose"][rows])


def test_how_large_a_run_is_and_what_has_no_room(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    large = load("stress/formation64", ["duration=600"])
    experiment = build(large)
    said = beforehand(large, experiment)[-1]
    assert said.startswith("60000 control periods of 64 robots: about ")
    assert "record: {every: 10}" in said
    found = extent.extent_of(experiment, wheels=True)
    assert 1.9e9 < found.file < 2.1e9
    assert found.memory(in_file=True) < 6e8
    assert not extent.extent_of(build(scenario("mujoco", 1)), wheels=True).sentence
    with pytest.raises(extent.RoomError, match=r"^duration: .* GB of memory .*`nhtrack run`"):
        extent.require_room(found._replace(rows=10**15), None)
    monkeypatch.setattr(extent.shutil, "disk_usage", lambda folder: type("Usage", (), {"free": 10**9}))
    with pytest.raises(extent.RoomError, match=rf"on the disk of {tmp_path}.*`record: {{every: 10}}`"):
        extent.require_room(found, tmp_path)
