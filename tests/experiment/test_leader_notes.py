"""What a run says of a leader on a path: how near it is to it, and what is wrong with the two."""

from __future__ import annotations

import re

import numpy as np
import pytest

from nhtrack.experiment.build import build, instants_of
from nhtrack.experiment.leader_notes import leader_notes, leader_warnings
from nhtrack.experiment.load import load
from nhtrack.references import Motion
from nhtrack.simulation.ideal import propagate
from nhtrack.studies.run.run import run


def test_a_note_says_how_near_the_ideal_leader_is_in_micrometres_of_the_floor() -> None:
    scenario = load("tour/lemniscate", ["similarity={length: 0.2, time: 0.8}", "duration=20", "control_rate=25"])
    experiment = build(scenario)
    g, xi = experiment.start.g[0], experiment.start.xi[0]
    motion = scenario.leader.input.reference()
    assert isinstance(motion, Motion)
    path = motion.poses(instants_of(scenario))
    distances = [0.0]
    for u, goal in zip(experiment.inputs, path[1:], strict=True):
        g, xi = propagate(g, xi, u, experiment.dt)
        distances.append(float(np.hypot(*(g[:2] - 0.2 * goal[:2]))))
    (note,) = leader_notes(scenario)
    largest, rms = map(float, re.findall(r"([0-9.]+) µm", note))
    assert largest == pytest.approx(1e6 * max(distances), rel=0.01)
    assert rms == pytest.approx(1e6 * np.sqrt(np.mean(np.square(distances))), rel=0.01)
    assert leader_warnings(scenario) == ()


def test_of_a_leader_by_accelerations_nothing_is_said() -> None:
    assert leader_notes(load("tour/hello")) == leader_warnings(load("tour/hello")) == ()


@pytest.mark.slow
def test_periods_too_long_for_a_path_and_a_run_too_short_for_it_are_warned_of() -> None:
    wild = load("tour/lemniscate", ["leader.input.path.y=0.6*sin(30*t)", "control_rate=10", "duration=5"])
    (warning,) = leader_warnings(wild)
    assert "away from its path" in warning
    assert "control periods of 0.1 s are too long" in warning
    (short,) = leader_warnings(load("tour/lap", ["duration=20"]))
    assert short == "leader: the run ends at t = 20, before its path does at t = 54.04"


def test_a_run_tells_notes_and_warnings() -> None:
    told = run("tour/lap", backend="ideal", duration=2.0).summary
    assert any("of its path" in note for note in told["notes"])
    assert any("before its path does" in warning for warning in told["warnings"])
