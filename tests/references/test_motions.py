"""Leaders given by where they are to be: poses, velocities, paths; driven by the exact flow, and faults by row."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import tolerances as tol
from nhtrack.recording import Recording
from nhtrack.references import FileFaults, Motion
from nhtrack.references.columns import read_csv, read_words
from nhtrack.references.poses import PoseInput
from nhtrack.references.recorded import RecordingInput
from nhtrack.references.velocities import VelocityInput
from nhtrack.simulation.ideal import propagate
from nhtrack.studies.run.run import run

PERIOD = 0.01
CURVES = {  # x, y and heading over time of what a unicycle can drive
    "circle": lambda t: (np.cos(t), np.sin(t), t + np.pi / 2),
    "lemniscate": lambda t: (np.cos(0.5 * t), np.sin(t) / 2, np.arctan2(np.cos(t), -np.sin(0.5 * t))),
    "reversing": lambda t: (np.sin(0.7 * t), 0 * t, 0 * t),
    "backwards": lambda t: (-t - 0.2 * np.sin(t), 0 * t, 0 * t),
    "spin": lambda t: (0 * t, 0 * t, 2 * np.sin(t)),
    "cusps": lambda t: (t - np.sin(t), 1 - np.cos(t), np.arctan2(np.cos(t / 2), np.sin(t / 2))),
}


def input_of(name: str, step: float = 0.05, until: float = 20.0) -> PoseInput:
    t = np.arange(0, until + step / 2, step)
    x, y, theta = CURVES[name](t)
    wrapped = np.remainder(theta + np.pi, 2 * np.pi) - np.pi
    return PoseInput.model_validate({"poses": {"t": list(t), "x": list(x), "y": list(y), "theta": list(wrapped)}})


def driven(motion: Motion, period: float, until: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns instants and what the exact flow makes of the accelerations, poses and twists."""
    instants = np.arange(round(until / period) + 1) * period
    g, (v, omega) = motion.poses(instants[:1])[0], motion.speeds(instants[:1])[0]
    xi = np.array([v, 0.0, omega])
    poses, twists = [g], [xi]
    for u in motion.held(instants):
        g, xi = propagate(g, xi, u, period)
        poses.append(g)
        twists.append(xi)
    return instants, np.array(poses), np.array(twists)


@pytest.mark.parametrize("name", CURVES)
def test_the_ideal_robot_is_where_the_curve_is(name: str) -> None:
    """Of third order in the period and of fourth in the step between rows: micrometres, and they do not add up."""
    instants, poses, _ = driven(input_of(name).reference(), PERIOD, 20.0)
    x, y, theta = CURVES[name](instants)
    late = instants > 10
    distance = np.hypot(poses[:, 0] - x, poses[:, 1] - y)
    assert distance.max() < 2e-5
    assert distance[late].max() < 1.1 * distance[~late].max() + 1e-9
    assert abs(np.remainder(poses[:, 2] - theta + np.pi, 2 * np.pi) - np.pi).max() < 1e-3


def test_what_is_left_is_told_as_it_is() -> None:
    motion = input_of("lemniscate").reference()
    instants, poses, _ = driven(motion, PERIOD, 20.0)
    missing = poses - motion.poses(instants)
    distance = np.hypot(missing[:, 0], missing[:, 1])
    told = motion.departure(instants)
    assert told.largest == pytest.approx(distance.max(), abs=1e-11)
    assert told.rms == pytest.approx(math.sqrt((distance**2).mean()), abs=1e-11)
    assert told.heading == pytest.approx(abs(missing[:, 2]).max(), abs=1e-11)


@given(st.floats(0.01, 100), st.floats(0.01, 100))
@settings(max_examples=10, deadline=None)
def test_accelerations_scale_with_length_and_time(length: float, time: float) -> None:
    rows = input_of("lemniscate", 0.1, 5.0).poses
    scaled = {"t": [time * t for t in rows.t], "x": [length * x for x in rows.x], "y": [length * y for y in rows.y]}
    larger = PoseInput.model_validate({"poses": {**scaled, "theta": list(rows.theta)}}).reference()
    instants = np.arange(501) * PERIOD
    expected = PoseInput(poses=rows).reference().held(instants) * [length / time**2, 1 / time**2]
    scale = abs(expected).max(axis=0)
    np.testing.assert_allclose(larger.held(time * instants) / scale, expected / scale, atol=1e-8)


def test_times_count_from_the_first_row_and_the_leader_stands_where_the_rows_end() -> None:
    t = np.linspace(0, 2, 21)
    x = t**2 * (3 - t) / 4  # at rest at both ends
    late = {"t": list(1.7e9 + t), "x": list(x), "y": [0.0] * 21, "theta": [0.0] * 21}
    instants, poses, twists = driven(PoseInput.model_validate({"poses": late}).reference(), PERIOD, 4.0)
    np.testing.assert_allclose(poses[instants <= 2, 0], np.interp(instants[instants <= 2], t, x), atol=3e-3)
    np.testing.assert_allclose(poses[instants > 2.5, 0], 1.0, atol=1e-6)
    assert abs(twists[instants > 3]).max() < 1e-6


def test_velocities_are_met_at_every_row() -> None:
    t, v, omega = [5.0, 6.0, 7.5, 9.0], [0.2, 1.0, -0.5, 0.0], [0.0, 0.3, -1.0, 0.0]
    given = VelocityInput.model_validate({"velocities": {"t": t, "v": v, "omega": omega}})
    assert given.start() == (None, (0.2, 0.0))
    _, _, twists = driven(given.reference(), PERIOD, 5.0)
    np.testing.assert_allclose(twists[[0, 100, 250, 400]], np.stack([v, np.zeros(4), omega], -1), atol=1e-11)
    assert abs(twists[400:]).max() < tol.HAND


# -- files -----------------------------------------------------------------------------------------


def written(folder: Path, text: str, name: str = "rows.csv") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def test_columns_are_found_by_name_and_every_number_knows_its_place(tmp_path: Path) -> None:
    text = '\ufeff"b", note ,a\n 1.5,"x, ""y""", -2e3 \n\n,,\n3,,"4"\n'
    columns = read_csv(written(tmp_path, text), ("a", "b"))
    assert columns.values == {"a": [-2000.0, 4.0], "b": [1.5, 3.0]}
    assert columns.places == {"a": [(2, 18), (5, 4)], "b": [(2, 2), (5, 1)]}
    assert columns.fault(1, "a", "so").endswith("rows.csv:5:4: so")


@pytest.mark.parametrize(
    ("text", "faults"),
    [
        ("a;b\n1;2\n", ["1:1: expected the columns a, b, got a;b; separate them by commas"]),
        ("a\tb\n1\t2\n", ["1:1: expected the columns a, b, got a\tb; separate them by commas"]),
        ("a,b,a\n1,2,3\n", ["1:1: the column a is there twice"]),
        ("a,b\n1,x\ny,2\n3\n", ["2:3: b must", "3:1: a must", "4:2: no value for b"]),
        ("a,b\n\n", ["1:1: no rows"]),
        ("a,b\n" + "x,1\n" * 15, [f"{line}:1: a must" for line in range(2, 12)] + ["and 5 more faults like these"]),
    ],
)
def test_every_fault_of_a_file_has_line_and_column(tmp_path: Path, text: str, faults: list[str]) -> None:
    with pytest.raises(FileFaults) as caught:
        read_csv(written(tmp_path, text), ("a", "b"))
    assert len(caught.value.faults) == len(faults)
    for told, expected in zip(caught.value.faults, faults, strict=True):
        assert told.startswith(expected if expected.startswith("and") else f"rows.csv:{expected}")


def test_what_cannot_be_read_is_told(tmp_path: Path) -> None:
    with pytest.raises(FileFaults, match="no such file"):
        read_csv(tmp_path / "none.csv", ("a",))
    with pytest.raises(FileFaults, match="is a directory"):
        read_csv(tmp_path, ("a",))
    (tmp_path / "binary.csv").write_bytes(b"a\xff\n")
    with pytest.raises(FileFaults, match="not UTF-8 text"):
        read_csv(tmp_path / "binary.csv", ("a",))


def test_blanks_separate_and_a_hash_begins_a_comment(tmp_path: Path) -> None:
    columns = read_words(written(tmp_path, "# a b\n\n 1\t 2 3 # more\n4 5\n"), ("a", "b"))
    assert columns.values == {"a": [1.0, 4.0], "b": [2.0, 5.0]}
    assert columns.places["b"] == [(3, 5), (4, 3)]


def poses_in(folder: Path, rows: list[str], name: str = "rows.csv") -> dict[str, list[float]]:
    head = ["t,x,y,theta"] if name.endswith(".csv") else ["# t tx ty tz qx qy qz qw"]
    written(folder, "\n".join([*head, *rows]), name)
    found: dict[str, list[float]] = PoseInput.resolved({"poses": name}, folder)["poses"]
    return found


@pytest.mark.parametrize("yaw", [0.0, 1.0, -2.5, math.pi])
def test_a_quaternion_becomes_its_heading(tmp_path: Path, yaw: float) -> None:
    turned = f"0 0 {2 * math.sin(yaw / 2)!r} {2 * math.cos(yaw / 2)!r}".replace("2 *", "")
    with pytest.raises(FileFaults, match=r"rows.tum:2:9: a quaternion has norm 1, this has 2"):
        poses_in(tmp_path, [f"0 0 0 0 {turned}", f"1 0 0 0 {turned}"], "rows.tum")
    unit = f"0 0 {-math.sin(yaw / 2)!r} {-math.cos(yaw / 2)!r}"  # of either sign
    found = poses_in(tmp_path, [f"0 1 2 9 {unit}", f"1 1 2 9 {unit}"], "rows.tum")
    assert (found["x"], found["y"]) == ([1.0, 1.0], [2.0, 2.0])
    np.testing.assert_allclose(np.cos(np.array(found["theta"]) - yaw), 1, atol=tol.HAND)


def test_a_robot_that_lies_on_its_side_is_no_planar_one(tmp_path: Path) -> None:
    with pytest.raises(FileFaults, match=r"rows.tum:2:9: leans by 90 degrees"):
        poses_in(tmp_path, ["0 0 0 0 0.7071068 0 0 0.7071068", "1 0 0 0 0 0 0 1"], "rows.tum")


@pytest.mark.parametrize(
    ("row", "fault"),
    [
        ("0.25,0.3,0,0", "rows.csv:5:1: times must increase, got 0.25 after 0.3"),
        ("0.3,0.3,0,0", "rows.csv:5:1: times must increase, got 0.3 after 0.3"),
        ("0.4,5,0,0", "rows.csv:5:5: a jump of 4.7 in 0.1"),
        ("0.4,0.4,0,3.1", "rows.csv:5:11: turns by 178 degrees"),
        ("0.4,0.3,0.1,0", "rows.csv:5:13: drives at 90 degrees to its heading"),
    ],
)
def test_rows_that_no_unicycle_drives_to_are_told_by_their_place(tmp_path: Path, row: str, fault: str) -> None:
    rows = ["0.1,0.1,0,0", "0.2,0.2,0,0", "0.3,0.3,0,0", row]
    _, x, rest = row.split(",", 2)
    rows += [f"{0.1 * i:.1f},{float(x) + 0.1 * (i - 4):.1f},{rest}" for i in range(5, 30)]
    with pytest.raises(FileFaults) as caught:
        poses_in(tmp_path, rows)
    assert caught.value.faults[0].startswith(fault)
    assert len(caught.value.faults) == 1


def test_noise_of_measured_poses_is_no_sliding() -> None:
    """Between rows 3 mm apart, noise of a millimetre points anywhere; it says nothing of the robot."""
    t = np.arange(2000) * PERIOD
    x, y, theta = CURVES["circle"](0.3 * t)
    noise = np.random.default_rng(1).normal(scale=1e-3, size=(3, 2000))
    rows = {"t": list(t), "x": list(x + noise[0]), "y": list(y + noise[1]), "theta": list(theta + noise[2])}
    assert list(PoseInput.findings({"poses": rows}, t[:-1])) == []


def test_headings_that_are_a_little_off_do_not_lead_away_from_the_positions() -> None:
    """Left alone they would, by 0.6 m; where both corrections agree it is 2 * 0.03 v / (5/s) = 12 mm aside."""
    t = np.linspace(0, 20, 201)
    rows = {"t": list(t), "x": list(t), "y": [0.0] * 201, "theta": [0.03] * 201}
    _, poses, _ = driven(PoseInput.model_validate({"poses": rows}).reference(), PERIOD, 20.0)
    assert poses[-1] == pytest.approx([20, 0.012, 0], abs=1e-3)


# -- recordings ------------------------------------------------------------------------------------


def recorded_in(folder: Path) -> Path:
    """Returns the recording of a run whose units are decimetres and half seconds."""
    scenario = "tour/trajectory"
    made = run(scenario, backend="ideal", duration=8.0, set={"similarity": {"length": 0.1, "time": 0.5}})
    return made.recording.save(folder / "recording.nc")


@pytest.mark.slow
def test_a_recorded_robot_is_a_leader_in_the_units_of_its_scenario(tmp_path: Path) -> None:
    recording = Recording.load(recorded_in(tmp_path))
    given = {"recording": {"file": "recording.nc", "robot": "follower"}}
    motion = PoseInput.model_validate(RecordingInput.resolved(given, tmp_path)).reference()
    _, poses, _ = driven(motion, PERIOD / 0.5, 8.0)
    expected = recording.dataset["pose"].sel(robot="follower").values
    np.testing.assert_allclose(0.1 * poses[:, :2], expected[:, :2], atol=1e-5)
    np.testing.assert_allclose(poses[:, 2], expected[:, 2], atol=5e-4)  # a spline rounds off where accelerations jump


@pytest.mark.slow
def test_what_is_no_recording_or_has_no_such_robot_is_told(tmp_path: Path) -> None:
    recorded_in(tmp_path)
    (tmp_path / "text.nc").write_text("not a recording")
    for file, robot, message in (
        ("recording.nc", "folower", "did you mean 'follower'"),
        ("none.nc", "leader", "no file"),
        ("text.nc", "leader", "not a recording"),
    ):
        with pytest.raises(FileFaults, match=message):
            RecordingInput.resolved({"recording": {"file": file, "robot": robot}}, tmp_path)
