"""The paper's examples on wheels against their ideal twins."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from nhtrack import assets
from nhtrack.analysis.metrics import heading_gap, position_gap
from nhtrack.config.scenario import Scenario
from nhtrack.experiment.load import load
from nhtrack.recording import Recording
from nhtrack.studies.fidelity.bench import Bench, Finding
from nhtrack.studies.run.run import simulate

# What the code does, which the law does not let grow; a first-order error anywhere shows as a tenth of a millimetre.
_POSITION, _HEADING = 2e-6, 5e-6  # RMS [m], [rad]


def closed_loop(bench: Bench) -> Iterator[Finding]:
    """Yields the gap between a paper scenario on wheels and its ideal twin, RMS of the robot that has most.

    The scenarios are made for nh_mini; other robots have other motors and other friction demands. Robots that may touch
    have no twin to be held against, since ideal ones pass through each other.
    """
    if bench.robot != "nh_mini":
        return
    for name, scenario in paper_scenarios().items():
        recording = simulate(scenario).recording
        cause = "each runs its own closed loop; the open-loop error of a second or two, which the law takes back"
        gap, turn = (_rms(values) for values in (position_gap(recording), heading_gap(recording)))
        yield bench.find(f"{name}: gap to the twin", gap, "m", _POSITION, cause)
        yield bench.find(f"{name}: heading gap to the twin", turn, "rad", _HEADING, cause)
        cause = "predicted loads are quasi-static; contacts carry a jump of the command over in a few steps"
        yield bench.find(f"{name}: utilisation less prediction", _unpredicted(recording), "1", 1e-3, cause)


def paper_scenarios() -> dict[str, Scenario]:
    """Returns the paper's scenarios in which robots do not touch, by name."""
    found = {name: load(name) for name in assets.bundled_scenarios() if name.startswith("paper/")}
    return {name: scenario for name, scenario in found.items() if not scenario.physics.robot_contact}


def _rms(gap: np.ndarray) -> float:
    """Returns the root mean square over time of the robot with the largest, shape (time, robot)."""
    return float(np.sqrt(np.mean(gap**2, axis=0)).max())


def _unpredicted(recording: Recording) -> float:
    """Returns the RMS of measured less predicted utilisation of the wheel with the largest; row 0 is before the run."""
    measured, predicted = (recording[f"friction_utilisation{kind}"].values[1:] for kind in ("", "_predicted"))
    return float(np.sqrt(np.mean((measured - predicted) ** 2, axis=0)).max())
