"""What reports are made of: runs of formulas, whole enough to have a summary, and small real studies."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from nhtrack.analysis.metrics import summary
from nhtrack.config.documentation import json_schema
from nhtrack.experiment.load import load
from nhtrack.recording import Recording
from nhtrack.studies.compare.laws_file import load_laws
from nhtrack.studies.compare.result import Comparison
from nhtrack.studies.compare.run import compare_laws
from nhtrack.studies.run.report import Extras, write_run_page
from nhtrack.video.encode import write_film
from recordings import HALF_SEPARATION, WHEEL_RADIUS, synthetic_recording

HOSTILE = "<script>alert(1)</script>"
WILD = "{name: kanayama, k_inner: 250}"  # is lost within a second
CASE = """\
name: case
duration: 4
control_rate: 20
backend: ideal
similarity: {length: 0.1, time: 1}
leader:
  start: {pose: [0, 0, 0]}
  input: {u_x: 0.1, u_theta: "0.2*cos(t)"}
followers:
  - {name: follower, parents: [leader], start: {pose: [-1, 0, 0]}}
law: {name: published, kp: 1, kd: 3, ke: 0.3, k: 5}
"""
SCENARIOS = {1: "paper/example1", 63: "stress/formation64"}  # by the number of followers


def scenario_tree(followers: int = 1, **changes: Any) -> dict[str, Any]:
    """Returns the tree of a bundled scenario of so many followers with other sections."""
    return load(SCENARIOS.get(followers, "tour/hello")).model_copy(update=changes).model_dump(mode="json")


def whole_recording(followers: int = 1, **changes: Any) -> Recording:
    """Returns `synthetic_recording` with the variable and the attributes that only a summary and a report ask for."""
    attributes: dict[str, Any] = {
        "half_separation": HALF_SEPARATION,
        "wheel_radius": WHEEL_RADIUS,
        "no_load_speed": 50.0,
        "scenario": scenario_tree(followers),
        "model_hash": "0123456789abcdef" * 4,
        "seed": 0,
        "versions": {"python": "3.11.2", "nhtrack": "0.1.0", "mujoco": "3.17.0"},
    }
    recording = synthetic_recording(followers, **attributes | changes)
    cut = np.abs(recording["wheel_torque"]) < np.abs(recording["wheel_torque_demand"])
    return Recording(recording.dataset.assign(torque_saturation=cut.astype(float)))


def write_report(recording: Recording, path: Path, **extras: Any) -> Path:
    """Writes the report of a recording as `nhtrack run` does."""
    told = summary(recording) | {"warnings": []}
    return write_run_page(recording, told, path, Extras(schema=json_schema(), **extras))


def write_pictures(path: Path, count: int, fps: int = 25) -> Path:
    """Writes a small film of so many pictures, each brighter than the one before."""
    size = (160, 120)
    write_film((np.full((size[1], size[0], 3), 2 * k, np.uint8) for k in range(count)), path, size, fps)
    return path


def small_comparison(folder: Path, **scenario: Any) -> Comparison:
    """Runs a short scenario on the ideal model under its own law, one that follows and one that is lost."""
    file = folder / "case.yaml"
    file.write_text(CASE, encoding="utf-8")
    own = load(file).model_copy(update=scenario)
    _, laws = load_laws(lambda: own, ["kanayama", WILD], lambda _: own)
    return compare_laws(own, laws, folder / "results", figures=False, video=False)
