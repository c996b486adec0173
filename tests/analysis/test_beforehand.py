"""What is told before a run of a leader beyond law or robot, and what would help."""

from __future__ import annotations

import re

import numpy as np
import pytest

from nhtrack import assets
from nhtrack.analysis.beforehand import beforehand, beforehand_without_time, leader_beyond_law
from nhtrack.analysis.demand import root_predictions
from nhtrack.analysis.motion import motion_of, root_motion
from nhtrack.config.degrees import degree_warnings
from nhtrack.config.scenario import Scenario
from nhtrack.errors import FeasibilityError, ScenarioError
from nhtrack.experiment.build import build
from nhtrack.experiment.load import load
from nhtrack.laws import Limits
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.studies.run.run import simulate

ALIGN, CYCLE = "will not align", "followers end on a cycle about it"
# By their names what is told of bundled scenarios: gains below the bound of Lemma 1, leaders that drive on under the
# paper's law, one that crosses ice, casters that swing.
TOLD = {
    **{f"paper/{name}": [CYCLE] for name in ("example1", "example2", "example3_minus_pi", "example3_pi", "example4")},
    "paper/example5": [CYCLE],
    "stress/formation1000": [ALIGN, CYCLE],
    "stress/formation64": [ALIGN, CYCLE],
    "stress/ice_patch": [ALIGN, CYCLE, "a robot in the place of leader is predicted to slip"],
    "stress/slope": [CYCLE],
    "stress/weak_motors": [CYCLE],
    "tour/caster": ["casters swing"],
}


def said(scenario: Scenario) -> tuple[str, ...]:
    return beforehand(scenario, build(scenario))


def time_in(sentence: str) -> float:
    (found,) = re.findall(r"similarity\.time ([0-9.]+) would", sentence)
    return float(found)


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] * ("formation" in name)) for name in assets.bundled_scenarios()],
)
def test_of_bundled_scenarios_nothing_is_said_but_what_is_so(name: str) -> None:
    found, expected = said(load(name)), TOLD.get(name, [])
    assert len(found) == len(expected)
    assert all(words in sentence for words, sentence in zip(expected, found, strict=True))


@pytest.mark.parametrize("name", ["tour/universal", "tour/lemniscate"])
def test_the_root_moves_without_a_run_as_it_does_in_one(name: str) -> None:
    experiment = build(load(name, ["duration=8"]))
    names, ground = experiment.network.names, experiment.scene.ground
    run = experiment.rollout(IdealSimulation(names, None, experiment.dt, ground, size=experiment.size))
    for found, expected in zip(root_motion(experiment), motion_of(run, 0), strict=True):
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)


FAST = ["similarity.time=0.2", "law={name: universal}", "physics.friction=0.3", "duration=20"]


def test_a_leader_on_wheels_is_told_what_its_run_predicts() -> None:
    """The same sentences, with the time scale that the leader alone needs; a marker's are those of a robot there."""
    fast = load("tour/universal", FAST)
    found = said(fast)
    run = [each for each in simulate(fast).summary["warnings"] if each.startswith("leader is predicted")]
    assert [each.partition(";")[0] for each in found] == [each.partition(";")[0] for each in run] != []
    marker = said(load("tour/universal", [*FAST, "leader.virtual=true"]))
    assert tuple(each.replace("a robot in the place of leader", "leader") for each in marker) == found != marker
    assert said(load("tour/universal", [*FAST, "backend=ideal"])) == ()


def test_the_time_scale_that_is_told_fits_the_robot_and_a_smaller_one_does_not() -> None:
    fast = load("tour/universal", FAST)
    fits = max(time_in(each) for each in root_predictions(fast, build(fast)))
    assert said(load("tour/universal", [*FAST, f"similarity.time={fits}"])) == ()
    # It leaves a part of the friction unused, sqrt(0.7) in time.
    assert said(load("tour/universal", [*FAST, f"similarity.time={0.8 * fits}"])) != ()


def test_a_leader_above_the_limits_of_the_law_is_told_with_the_time_scale_that_leaves_a_reserve() -> None:
    changes = ["leader.input.u_theta=0", "leader.start.twist=[0, 0]", "leader.input.u_x=0.05", "backend=ideal"]
    slow = load("tour/universal", changes)
    assert said(slow) == ()
    (found,) = said(load("tour/universal", [*changes, "leader.input.u_x=0.2"]))
    limit, speed = build(slow).law.limits.speed, 0.2 * 40 * 0.2 / 1.2
    assert found.startswith(f"leader: |v_0| = {speed:.3g} m/s at 48 s is above the speed limit {limit:.3g}")
    assert "of law.limits" in found
    assert time_in(found) == pytest.approx(1.05 * 1.2 * speed / limit, rel=2e-3)
    assert said(load("tour/universal", [*changes, "leader.input.u_x=0.2", f"similarity.time={time_in(found)}"])) == ()
    assert said(load("tour/universal", [*changes, "leader.input.u_x=0.2", "law.limits=null"])) == ()


def test_another_law_is_named_where_it_has_no_bound() -> None:
    quick = ["backend=ideal", "leader.start.twist=[0, 0]", "leader.input.u_theta=0", "leader.input.u_x=cos(2*t)"]
    (found,) = said(load("tour/universal", [*quick, "law={name: universal}"]))
    assert "v_0 changes its sign" in found
    assert found.endswith("; no such bound is known of law: {name: agile}")
    assert said(load("tour/universal", [*quick, "law={name: agile}"])) == ()
    hard = load("tour/universal", [*quick, "leader.input.u_x=5", "law={name: agile}"])
    (own,) = leader_beyond_law(build(hard).law, hard, build(hard))
    assert own.endswith("need not be reached from afar")


def test_what_no_limits_leave_room_for_names_the_patch_that_robots_meet() -> None:
    def limits(*patches: str) -> Limits:
        changes = [f"physics.patches=[{', '.join(patches)}]", "physics.slope={angle: 0.05}", "duration=8"]
        return build(load("tour/universal", changes)).law.limits

    far, near = "{friction: 0.001, disc: [90, 9, 1]}", "{friction: 0.002, rectangle: [0.3, 0.4, -1, 1]}"
    assert limits(far) == limits()
    with pytest.raises(FeasibilityError, match=r"law\.limits: .* friction 0\.002, .*physics\.patches\[1\]\.friction$"):
        limits(far, near)
    everywhere = [f"physics.patches=[{far}]", "physics.slope.angle=0.05", "law.limits.everywhere=true"]
    with pytest.raises(FeasibilityError, match=r"friction 0\.001, .*physics\.patches\[0\]\.friction$"):
        build(load("tour/universal", everywhere))


def test_headings_that_look_like_degrees_are_told() -> None:
    turned = ["followers[0].start.pose[2]=-90", "leader.start.pose[2]=6", "followers[1].start.pose[2]=7.5"]
    (told,) = degree_warnings(load("tour/universal", turned))
    assert told == "followers[0].start.pose[2] = -90 rad looks like degrees, of which it would be -1.571 rad"
    with pytest.raises(ScenarioError, match=r"got 5; 5 degrees are 0\.08727 rad"):
        load("tour/universal", ["physics.slope.angle=5"])


def test_with_time_auto_a_leader_is_told_and_its_limits_are_not() -> None:
    """A leader that cannot fit is refused as a run would refuse it; one that is beyond its law is told."""
    auto = ["similarity.time=auto", "leader.start.twist=[0, 0]", "leader.input.u_theta=0", "leader.input.u_x=cos(2*t)"]
    extent, found = beforehand_without_time(load("tour/universal", [*auto, "duration=5000"]))
    assert re.match(r"at similarity\.time [0-9.]+, the smallest that fits leader alone: \d+ control periods", extent)
    told = r"at similarity\.time [0-9.]+, the smallest that fits leader alone: leader: v_0 changes"
    assert [each for each in found if re.match(told, each)]
    assert not [each for each in found if "limits" in each]
    icy = load("tour/universal", [*auto, "physics.patches=[{friction: 0, disc: [0, 0, 1]}]", "law.limits=null"])
    with pytest.raises(FeasibilityError, match="asks for friction and there is none"):
        beforehand_without_time(icy)
    marker = icy.model_copy(update={"leader": icy.leader.model_copy(update={"virtual": True})})
    assert "asks for friction and there is none" in beforehand_without_time(marker)[1][0]
