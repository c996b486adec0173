"""Habits of other people's robots combined at random, driven on wheels; now and then with a fault, which is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

import nhtrack
from nhtrack.errors import ScenarioError
from odd_robots.faults import FAULTS
from odd_robots.plain import text_of
from odd_robots.variants import EVERY, made, variants

COUNT = 100
# How far wheels and ideal twin may part, of the path: a few micrometres where an axle leans by 1.57 for pi/2; and what
# a swivel caster does, of which the reduced model does not know.
FOLLOWED, SWIVELLED = 3e-5, 1e-3

SCENARIO = """
name: variant
duration: 3.0
robot: {robot}
leader:
  start: {{pose: [0, 0, 0]}}
  input:
    u_x: [{{until: 1, value: 0.2}}, {{until: 3, value: 0}}]
    u_theta: "1.5*cos(2*pi*t/2)"
followers:
  - {{name: follower, parents: [leader], start: {{pose: [-0.1, 0.06, 0.3]}}}}
law: {{name: universal, limits: {{utilisation: 0.5}}}}
"""


def test_validation_tells_every_reason_and_where_the_scenario_names_the_robot(tmp_path: Path) -> None:
    faults = ("springs_on_wheels", "coupled_wheels", "a_weightless_chassis")
    (tmp_path / "robot.xml").write_text(text_of(made((), *faults)), encoding="utf-8")
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text(SCENARIO.format(robot="robot.xml"), encoding="utf-8")
    found = nhtrack.validate(scenario)
    assert [(fault.line, fault.key) for fault in found] == [(4, "robot")] * 4
    for name in faults:
        for kind, element in FAULTS[name].blames:
            assert sum(f"{kind} {element!r} (line " in fault.message for fault in found) == 1


@pytest.mark.slow
def test_variants_are_followed_or_refused(tmp_path: Path) -> None:
    wrong, seen = list[str](), 0
    for number, variant in enumerate(variants(COUNT, seed=20)):
        file = tmp_path / f"{number}.xml"
        file.write_text(text_of(variant.robot), encoding="utf-8")
        forward = f", forward: {variant.hints.forward}" if variant.hints.forward else ""
        scenario = SCENARIO.format(robot=f"{{file: {file}{forward}}}")
        label = f"{number} {' '.join((*variant.made_of, variant.fault and variant.fault.upper()))}"
        try:
            robots = nhtrack.run(scenario).summary["robots"].values()
        except ScenarioError as error:
            if not variant.fault:
                wrong.append(f"{label}: refused: {error}")
            continue
        if variant.fault:
            wrong.append(f"{label}: not refused")
        seen += 1
        share = max(robot["gap_position_max"] / robot["path_length"] for robot in robots)
        if share > (SWIVELLED if "swivel_caster" in variant.made_of else FOLLOWED):
            wrong.append(f"{label}: gap {share:.1e} of the path")
    assert not wrong, "\n".join(wrong)
    assert seen >= COUNT * (EVERY - 1) // EVERY
