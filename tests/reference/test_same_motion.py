"""Runs of the package are the motions that the array code gives."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from pydantic import TypeAdapter

from lossy import write_lossy
from nhtrack.assets import bundled_scenarios
from nhtrack.config.law_sections import Law
from nhtrack.config.robot_section import RobotSection
from nhtrack.config.scenario import Scenario
from nhtrack.experiment.load import load
from nhtrack.studies.feasibility.run import with_time
from nhtrack.studies.run.run import simulate
from reference.comparison import POSITION, Comparison, arrays_of, compare, shortened
from reference.run import run_reference

SECONDS = 2.0
LAW_SECONDS = 0.3
CROWD = "stress/formation64"  # of which the array code takes long to make a scene; stress/formation1000 is like it
CROWD_PERIODS = 20
# Scenarios with nothing in them that another has not; `compare_recordings.py` runs them all, to their ends.
LIKE_OTHERS = {"paper/example2", "paper/example3_minus_pi", "tour/hello", "tour/lap", "tour/rounds", "tour/trajectory"}
# The array code knows of no casters that swivel.
ELSEWHERE = {CROWD, "stress/formation1000", "tour/caster"} | LIKE_OTHERS

LAWS: Mapping[str, Mapping[str, object]] = {
    "published": {"kp": 27.9, "kd": 50.8, "ke": 0.044, "k": 7.25},
    "full": {"name": "published", "variant": "full", "kp": 27.9, "kd": 50.8, "ke": 0.044, "k": 7.25},
    "stabiliser": {"kp": 27.9, "kd": 50.8, "k": 7.25},
    "universal": {},
    "limited": {"name": "universal", "limits": {"utilisation": 0.5}},
    "kanayama": {},
    "samson": {},
    "jiang_nijmeijer": {},
    "feedback_linearisation": {"v_min": 1.0},  # at its default one robot spins ever faster, and rounding with it
    "look_ahead": {},
}


def differences(scenario: Scenario, periods: int) -> Comparison:
    """Returns how far a run of the package is from the array code's."""
    reference = run_reference(scenario, periods, telemetry=False)
    found = arrays_of(simulate(shortened(scenario, periods)).recording)
    return compare(reference, found, tuple(scenario.parents))


def require_same(comparison: Comparison) -> None:
    """Fails with all differences where a pose of a run or of its twin differs."""
    assert comparison.is_same, comparison
    assert comparison.largest["ideal_pose [m]"].size <= POSITION, comparison


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted({*bundled_scenarios()} - ELSEWHERE))
def test_bundled_scenario_begins_as_on_the_array_code(name: str) -> None:
    scenario = with_time(load(name))
    require_same(differences(scenario, round(SECONDS * scenario.control_rate)))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["tour/hello", "stress/weak_motors", "stress/ice_patch"])
def test_robot_with_losses_moves_as_on_the_array_code(tmp_path: Path, name: str) -> None:
    """Within motors and friction, and where motors saturate or wheels slide."""
    robot = RobotSection(file=write_lossy(tmp_path, (1e-3, 0.003), (5e-4, 0.005)))
    scenario = with_time(load(name).model_copy(update={"robot": robot}))
    require_same(differences(scenario, round(SECONDS * scenario.control_rate)))


def test_crowd_begins_as_on_the_array_code() -> None:
    require_same(differences(load(CROWD).model_copy(update={"backend": "ideal"}), CROWD_PERIODS))


@pytest.mark.slow
@pytest.mark.parametrize(("law", "twist"), [*((law, "exact") for law in LAWS), ("published", "printed")])
def test_law_moves_ideal_robots_as_the_array_law(law: str, twist: str) -> None:
    """Four robots in formation, one with two parents, and all its displaced and folded leaders."""
    scenario = load("paper/example4")
    followers = tuple(
        follower.model_copy(update={"offset": (-1.0, 0.5 * place)}) for place, follower in enumerate(scenario.followers)
    )
    scenario = scenario.model_copy(
        update={
            "backend": "ideal",
            "followers": followers,
            "virtual_leader": "exact" if twist == "exact" else "convex",
            "formation": twist,
            "law": TypeAdapter(Law).validate_python({"name": law} | dict(LAWS[law])),
        }
    )
    require_same(differences(scenario, round(LAW_SECONDS * scenario.control_rate)))


def test_time_scale_has_to_be_a_number() -> None:
    scenario = load("tour/hello")
    scenario = scenario.model_copy(update={"similarity": scenario.similarity.model_copy(update={"time": "auto"})})
    with pytest.raises(ValueError, match="auto"):
        run_reference(scenario, 1)


def test_two_micrometres_are_not_the_same_motion() -> None:
    scenario = load("tour/hello").model_copy(update={"backend": "ideal"})
    one, other = (run_reference(scenario, 50, nudge=nudge) for nudge in (0.0, 2e-6))
    comparison = compare(one, other, tuple(scenario.parents))
    assert not comparison.is_same
    assert comparison.switch is None
    assert comparison.exceeded == 0.0


@pytest.mark.parametrize("sudden", [True, False])
def test_only_a_jump_of_the_inputs_counts_as_a_switch(sudden: bool) -> None:
    """A switch that comes a period later in one of two runs, and a gain that is wrong by little."""
    scenario = load("tour/hello").model_copy(update={"backend": "ideal"})
    one = run_reference(scenario, 50)
    one["input"][:, 1, 0] = np.where(np.arange(51) < 30, 1.0, -1.0)
    other = {name: values.copy() for name, values in one.items()}
    if sudden:
        other["input"][30, 1, 0] = 1.0
    else:
        other["input"][:, 1, 0] += 1e-5 * np.arange(51)
    other["pose"][31:, 1, 0] += 1e-4
    comparison = compare(one, other, tuple(scenario.parents))
    assert comparison.is_same == sudden
    assert comparison.position == pytest.approx(0.0 if sudden else 1e-4)
    assert (comparison.switch is not None) == sudden
