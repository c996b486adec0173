"""Runs of several laws as one recording: who drives, in which colour, and where those are whose run ended."""

from __future__ import annotations

import json

import numpy as np
import pytest

from nhtrack.recording import Recording
from nhtrack.simulation.scene import SceneSpec
from nhtrack.video.together import together
from recordings import robot_names, synthetic_recording

ROOM = (-100.0, 100.0, -100.0, 100.0)


def run(followers: int = 2, shift: float = 0.0, **changes: object) -> Recording:
    scene = SceneSpec(robot_names(followers), robot_contact=True)
    recording = synthetic_recording(followers, samples=81, scene=scene.to_json(), **changes)
    recording.dataset["pose"].values[:, 1:, 0] += shift
    return recording


def test_the_leader_drives_once_and_the_followers_of_all_laws_with_it() -> None:
    runs = {"kanayama": run(), "universal-2": run(shift=0.3)}
    merged = together(runs, ROOM)
    assert merged.robots == ("leader", "f1-kanayama", "f2-kanayama", "f1-universal-2", "f2-universal-2")
    pose = merged["pose"].values
    assert np.array_equal(pose[:, 0], runs["kanayama"]["pose"].values[:, 0])
    assert np.array_equal(pose[:, 1:3], runs["kanayama"]["pose"].values[:, 1:])
    assert np.array_equal(pose[:, 3:], runs["universal-2"]["pose"].values[:, 1:])
    assert np.array_equal(merged["error"].values[:, 3:], runs["universal-2"]["error"].values[:, 1:])
    assert (merged.outcome, merged.name) == ("completed", "example1: 2 laws")
    assert merged.parents["f2-universal-2"] == ("leader",)


def test_each_law_has_a_colour_and_no_robot_touches_another() -> None:
    merged = together({"kanayama": run(), "samson": run(), "universal": run()}, ROOM)
    spec = SceneSpec.from_json(merged.dataset.attrs["scene"])
    assert spec.robots == merged.robots
    assert spec.colours == (0, 1, 1, 2, 2, 3, 3)
    assert not spec.robot_contact
    assert json.loads(merged.dataset.attrs["groups"])["samson"] == ["f1-samson", "f2-samson"]


def test_a_law_whose_run_ended_stands_where_it_was() -> None:
    runs = {"kanayama": run(stop=30.0), "samson": run()}
    merged = together(runs, ROOM)
    ended = len(runs["kanayama"].time)
    assert np.array_equal(merged.time, runs["samson"].time)  # the root is of a run that did not end early
    assert np.array_equal(merged["pose"].values[:, 0], runs["samson"]["pose"].values[:, 0])
    last = runs["kanayama"]["pose"].values[-1, 1:]
    assert np.array_equal(merged["pose"].values[ended:, 1:3], np.broadcast_to(last, (len(merged.time) - ended, 2, 3)))
    assert np.isnan(merged["error"].values[ended:, 1:3]).all()
    assert np.isfinite(merged["error"].values[:ended, 1:]).all()
    assert (merged["wheel_speed"].values[ended:, 1:3] == 0).all()


def test_a_follower_out_of_sight_is_held_until_it_is_back() -> None:
    wild = run()
    away = wild["pose"].values[:, 2, 1]
    away[20:30], away[50:] = 1e200, -300.0
    merged = together({"kanayama": wild, "samson": run()}, ROOM)["pose"].values[:, 2]
    original = wild["pose"].values[:, 2]
    for rows, shown in ((slice(0, 20), slice(0, 20)), (slice(30, 50), slice(30, 50))):
        assert np.array_equal(merged[rows], original[shown])
    assert (merged[20:30] == original[19]).all()
    assert (merged[50:] == original[49]).all()


@pytest.mark.parametrize("virtual", [False, True])
@pytest.mark.parametrize("size", [9, 6])
def test_coordinates_are_copied_block_by_block(virtual: bool, size: int) -> None:
    """A virtual root has none; a planar base has fewer."""
    runs, blocks = {}, {}
    for label in ("a", "b"):
        recording = run()
        spec = SceneSpec(robot_names(2), virtual_root=virtual)
        recording.dataset.attrs["scene"] = spec.to_json()
        blocks[label] = np.random.default_rng(len(runs)).uniform(size=(81, len(spec.bodies), size))
        recording.dataset["qpos"] = (("time", "coordinate"), blocks[label].reshape(81, -1))
        runs[label] = recording
    merged = together(runs, ROOM)["qpos"].values.reshape(81, -1, size)
    roots = 0 if virtual else 1
    assert merged.shape[1] == roots + 4
    assert np.array_equal(merged[:, :roots], blocks["a"][:, :roots])
    assert np.array_equal(merged[:, roots : roots + 2], blocks["a"][:, roots:])
    assert np.array_equal(merged[:, roots + 2 :], blocks["b"][:, roots:])


def test_without_coordinates_of_every_run_there_are_none() -> None:
    assert "qpos" not in together({"a": run(), "b": run()}, ROOM).dataset
