"""What a run leaves behind: every bit comes back, and a failed write leaves nothing."""

from __future__ import annotations

import errno
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from nhtrack import assets
from nhtrack.errors import RecordingError, WriteError
from nhtrack.experiment.build import build
from nhtrack.experiment.load import load
from nhtrack.files.checksums import with_checksums
from nhtrack.laws import LawError
from nhtrack.recording import FORMAT_VERSION, VARIABLES, Recording, make_recording
from nhtrack.recording.scenario import LawText, read_scenario
from random_recording import ATTRIBUTES, ROBOTS, SOME, assert_same_bits, sample


@pytest.fixture(scope="module")
def loaded(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    return Recording.load(sample().save(tmp_path_factory.mktemp("deep") / "er" / "recording.nc"))


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns the file of a recording with few variables, which takes less time to write and to read."""
    return sample(names=SOME).save(tmp_path_factory.mktemp("small") / "recording.nc")


def test_every_bit_comes_back(loaded: Recording) -> None:
    assert_same_bits(loaded.dataset, sample().dataset)
    assert loaded.dataset.attrs == sample().dataset.attrs


def test_run_that_ended_at_once_is_a_recording_too(tmp_path: Path) -> None:
    before = sample(0, SOME, outcome="interrupted")
    after = Recording.load(before.save(tmp_path / "recording.nc"))
    assert_same_bits(after.dataset, before.dataset)
    assert "example1" in repr(after)


def test_properties_read_what_was_stored(loaded: Recording) -> None:
    recording = loaded
    assert recording.name == "example1"
    assert recording.backend == "mujoco"
    assert recording.robots == ROBOTS
    assert recording.followers == ("follower",)
    assert recording.parents == {"leader": (), "follower": ("leader",)}
    assert (recording.length_scale, recording.time_scale) == (0.004, 4.0)
    assert recording.outcome == "completed"
    assert recording.scenario == load("tour/hello")
    assert recording.versions == ATTRIBUTES["versions"]
    assert (recording.seed, recording.model_hash, recording.law, recording.divergence) == (7, "3f", None, None)
    np.testing.assert_array_equal(recording.time, [0.0, 0.01, 0.02, 0.03, 0.04])
    assert repr(recording) == "Recording('example1', 2 robots, 0.04 s, backend='mujoco')"


@pytest.mark.slow
@pytest.mark.parametrize("name", assets.bundled_scenarios())
def test_a_scenario_comes_back_as_what_it_was(name: str) -> None:
    scenario = load(name)
    assert read_scenario(json.dumps(scenario.model_dump(mode="json"))) == scenario


def test_a_law_of_ones_own_is_read_and_not_run() -> None:
    tree = ATTRIBUTES["scenario"] | {"law": {"file": "/gone/mine.py", "name": "mine", "k": 3.0, "inner": {"far": 1.0}}}
    text = {"name": "mine", "file": "/gone/mine.py", "sha256": "", "source": "raise SystemExit", "gains": {"k": 6.0}}
    recording = sample(names=SOME, scenario=tree, law=text)
    assert recording.scenario.model_dump(mode="json") == tree
    assert recording.scenario.law.k == 3.0
    assert recording.law == LawText(**text)
    with pytest.raises(LawError, match=r"law 'mine' is not the package's own.*load_recorded"):
        build(recording.scenario)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"turns": 3}, r"turns: unknown key"),
        ({"law": {"name": "published", "kq": 1}, "duration": -1}, r"duration: .*greater than 0.*law.kq: unknown key"),
        ({"law": {}}, r"law: expected a section with a `name`"),
    ],
)
def test_a_scenario_of_another_version_is_told_key_by_key(changes: dict[str, Any], said: str) -> None:
    with pytest.raises(RecordingError, match=f"not one that this version reads: .*{said}"):
        sample(names=SOME, scenario=ATTRIBUTES["scenario"] | changes).scenario  # noqa: B018 - raises


def test_a_recording_without_a_scenario_says_so() -> None:
    recording = sample(names=SOME)
    del recording.dataset.attrs["scenario"]
    with pytest.raises(RecordingError, match="does not say which scenario"):
        recording.scenario  # noqa: B018 - raises


def test_variables_carry_units_and_named_components() -> None:
    recording = sample()
    for name, spec in VARIABLES.items():
        assert recording[name].attrs == {"units": spec.units, "long_name": spec.long_name}
    wheels = {name: spec.units for name, spec in VARIABLES.items() if name.startswith("wheel_")}
    expected = {"wheel_torque": "N m", "wheel_torque_demand": "N m", "wheel_speed": "rad/s", "wheel_load": "N"}
    assert wheels == expected | {"wheel_clearance": "m"}
    closing = recording["touch"].sel(robot="leader", touch_component="closing_speed")
    np.testing.assert_array_equal(closing, recording.dataset["touch"].values[:, 0, :, 3])
    heading = recording["pose"].sel(robot="follower", pose_component="theta")
    assert heading.dims == ("time",)
    torque = recording["wheel_torque"].sel(wheel="left", robot="leader")
    np.testing.assert_array_equal(torque, recording.dataset["wheel_torque"].values[:, 0, 0])


def test_unknown_variable_is_refused_with_the_known_ones() -> None:
    with pytest.raises(RecordingError, match=r"unknown variables \['speed'\]; known: pose, twist, input"):
        make_recording(np.zeros(1), ("leader",), {"speed": np.zeros((1, 1))}, ATTRIBUTES)


def test_missing_variable_is_named_with_those_there() -> None:
    recording = make_recording(np.zeros(1), ("leader",), {"tilt": np.zeros((1, 1))}, ATTRIBUTES)
    with pytest.raises(RecordingError, match="no variable 'pose' in this recording; it has tilt"):
        recording["pose"]


@pytest.mark.parametrize(("newer", "remedy"), [(1, ""), (-1, "; run its scenario again")])
def test_another_format_is_refused(newer: int, remedy: str, tmp_path: Path) -> None:
    recording = sample(names=SOME)
    recording.dataset.attrs["format_version"] = FORMAT_VERSION + newer
    path = recording.save(tmp_path / "recording.nc")
    message = f"recording format {FORMAT_VERSION + newer}; this version reads {FORMAT_VERSION}{remedy}$"
    with pytest.raises(RecordingError, match=message):
        Recording.load(path)


def test_other_netcdf_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "weather.nc"
    xr.Dataset({"rain": ("day", np.zeros(3))}).to_netcdf(path, engine="h5netcdf")
    with pytest.raises(RecordingError, match="not a recording: no 'scenario'"):
        Recording.load(path)


def test_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=re.escape(f"{tmp_path / 'no.nc'}: no such recording")):
        Recording.load(tmp_path / "no.nc")
    with pytest.raises(RecordingError, match="no such recording"):
        Recording.load(tmp_path)


@pytest.mark.parametrize("share", [0.0, 0.001, 0.1, 0.5, 0.9, 0.999])
def test_truncated_file_is_refused(small: Path, tmp_path: Path, share: float) -> None:
    whole = small.read_bytes()
    path = tmp_path / "cut.nc"
    path.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(RecordingError, match=re.escape(f"{path}: not a recording")):
        Recording.load(path)


@pytest.mark.parametrize("name", ["pose", "tilt", "time", "robot"])
def test_a_changed_number_is_told_by_its_variable(name: str, tmp_path: Path) -> None:
    """Whoever writes to the file without `save`, a disk or a program, does not change what is behind."""
    dataset = with_checksums(sample(names=SOME).dataset)
    values = dataset[name].values.copy()
    values.flat[-1] = "other" if name == "robot" else np.nextafter(values.flat[-1], np.inf)
    dataset.assign({name: (dataset[name].dims, values, dataset[name].attrs)}).to_netcdf(
        tmp_path / "changed.nc", engine="h5netcdf"
    )
    with pytest.raises(RecordingError, match=f"changed.nc: not a recording: {name}: not what was saved"):
        Recording.load(tmp_path / "changed.nc")


@pytest.mark.parametrize("name", ["outcome", "seed", "scenario"])
def test_a_changed_attribute_is_told(name: str, tmp_path: Path) -> None:
    dataset = with_checksums(sample(names=SOME).dataset).assign_attrs({name: 8})
    dataset.to_netcdf(tmp_path / "changed.nc", engine="h5netcdf")
    with pytest.raises(RecordingError, match="the attributes: not what was saved"):
        Recording.load(tmp_path / "changed.nc")


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        *(({name: None}, f"no '{name}'") for name in ("name", "scenario", "parents", "outcome", "time_scale")),
        ({"name": None, "scenario": None}, "no 'scenario'; no 'name'"),
        *(({name: "{3"}, f"'{name}' cannot be read") for name in ("scenario", "parents", "versions", "scene", "law")),
        *(({name: "[1]"}, f"'{name}' cannot be read") for name in ("scenario", "parents", "groups", "scene", "law")),
        ({"parents": {"leader": 3, "follower": []}}, "'parents' cannot be read"),
        ({"parents": {"leader": []}}, "'parents' speaks of leader, 'robot' of leader, follower"),
        ({"scene": "{}"}, "'scene' cannot be read"),
        ({"scene": {"robots": ROBOTS, "timestep": "x"}}, "'scene' cannot be read"),
        ({"scene": {"robots": ["leader", *"abc"]}}, "'scene' speaks of leader, a, b, c, 'robot' of leader, follower"),
        *(({name: "[" * 200_000}, f"'{name}' cannot be read") for name in ("scenario", "parents", "law")),
        ({"parents": {"leader": [], "follower": ["nobody"]}}, "'parents': follower: no robot 'nobody'"),
        ({"parents": {"leader": ["follower"], "follower": ["leader"]}}, "'parents': leader: every robot has parents"),
        ({"parents": {"\x1b[2J": []}}, "'parents' speaks of \\x1b[2J"),
        ({"name": "a\x1b[2J"}, "'name' cannot be read"),
        ({"rows": "x"}, "'rows' cannot be read"),
        ({"law": {"name": "x"}}, "'law' cannot be read"),
        ({"length_scale": 0.0}, "'length_scale' cannot be read"),
        ({"time_scale": "x"}, "'time_scale' cannot be read"),
        ({"seed": "x"}, "'seed' cannot be read"),
    ],
)
def test_what_a_recording_lacks_is_told_when_it_is_read(changes: dict[str, Any], said: str, tmp_path: Path) -> None:
    recording = sample(names=SOME, **{key: value for key, value in changes.items() if value is not None})
    for name in (key for key, value in changes.items() if value is None):
        del recording.dataset.attrs[name]
    with pytest.raises(RecordingError, match=re.escape(f"not a recording: {said}")):
        Recording.load(recording.save(tmp_path / "lacking.nc"))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda data: data.drop_vars("pose"), "no 'pose' of the dimensions time, robot, pose_component"),
        (lambda data: data.drop_vars("robot"), "no 'robot'"),
        (lambda data: data.assign(tilt=data["time"]), "'tilt' is no array of numbers of the dimensions time, robot"),
        (lambda data: data.assign(pose=data["pose"].T), "no 'pose' of the dimensions"),
        (lambda data: data.assign(pose=data["pose"] * np.nan), "'pose' of robot 'leader' is no number somewhere"),
        (lambda data: data.assign(pose=data["pose"].astype(str)), "are no numbers"),
        (lambda data: data.isel(time=slice(None, None, -1)), "'time' does not increase"),
    ],
)
def test_variables_that_say_nothing_are_told_when_they_are_read(
    change: Callable[[xr.Dataset], xr.Dataset], said: str, tmp_path: Path
) -> None:
    with pytest.raises(RecordingError, match=re.escape(said)):
        Recording.load(Recording(change(sample(names=SOME).dataset)).save(tmp_path / "strange.nc"))


def test_of_a_run_that_diverged_the_last_poses_need_not_be_numbers(tmp_path: Path) -> None:
    recording = sample(names=SOME, outcome="diverged: somewhere")
    recording.dataset["pose"][-1] = np.nan
    assert Recording.load(recording.save(tmp_path / "lost.nc")).dataset.identical(recording.dataset)


def test_the_signs_of_nan_are_no_damage(tmp_path: Path) -> None:
    recording = sample(names=SOME)
    recording.dataset["leader_pose"][:, 0] = -np.float64("nan")
    Recording.load(recording.save(tmp_path / "recording.nc"))


def test_text_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "scenario.yaml"
    path.write_text("name: example1\n")
    with pytest.raises(RecordingError, match="not a recording"):
        Recording.load(path)


def test_full_disk_while_saving_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The disk fills while the file is written: stopped half way."""
    write = Path.write_bytes

    def full(self: Path, data: Any) -> None:
        write(self, bytes(data)[: len(data) // 2])
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(WriteError, match=": No space left"):
        sample(names=SOME).save(tmp_path / "recording.nc")
    assert list(tmp_path.iterdir()) == []
