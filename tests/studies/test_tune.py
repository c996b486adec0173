"""The search of gains: objectives and figures by hand, the search on a small scenario, gains written into files."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import tolerances as tol
from nhtrack import assets
from nhtrack.analysis.metrics import limits_of, summary
from nhtrack.config.edit import EditError, save_law_gains, with_law_gains
from nhtrack.config.law_sections import law_names
from nhtrack.config.scenario import Scenario
from nhtrack.errors import ScenarioError
from nhtrack.experiment.build import make_law
from nhtrack.experiment.load import load, load_text
from nhtrack.experiment.loop import Rollout
from nhtrack.ground import Ground
from nhtrack.similarity import Similarity
from nhtrack.simulation.robot_models import load_robot
from nhtrack.studies.run.run import simulate
from nhtrack.studies.tune.box import SearchBox, ranges_of
from nhtrack.studies.tune.objective import Figures, Objective, ObjectiveError, figures_of
from nhtrack.studies.tune.result import Tuning
from nhtrack.studies.tune.run import tune

CASE = """
name: case
duration: 10
control_rate: 20
similarity: {length: 0.1, time: 1}
leader:
  start: {pose: [0, 0, 0]}
  input: {u_x: "where(t < 2, 0.5, 0)", u_theta: 0}
followers:
  - {name: follower, parents: [leader], start: {pose: [-3, 2, 0.5]}}
law: {name: published, kp: 0.3, kd: 2, ke: 0.05, k: 5}
"""
SMALL = {"budget": 40, "seed": 3}


def case(*overrides: str) -> Scenario:
    return load_text(CASE, overrides=overrides)


@pytest.fixture(scope="module")
def found() -> Tuning:
    return tune(case(), **SMALL)  # type: ignore[arg-type]


# -- objectives -------------------------------------------------------------------------------------


def test_an_objective_reads_as_it_is_written() -> None:
    assert Objective.parse("late") == Objective(late=1.0)
    assert Objective.parse("late=2, settling = 0.5") == Objective(late=2.0, settling=0.5)
    for text in ("late", "settling=0.5", "late=2,utilisation=0.1"):
        assert str(Objective.parse(text)) == text


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("lat", "no objective 'lat'; did you mean 'late'\\? available: late, settling, utilisation"),
        ("", "no objective ''"),
        ("late=much", "expected a number as its weight, got 'much'"),
        ("late=-1", "expected weights of at least 0"),
        ("late=nan", "expected weights of at least 0"),
        ("late=0", "one above it"),
    ],
)
def test_an_objective_that_makes_no_sense_is_refused(text: str, message: str) -> None:
    with pytest.raises(ObjectiveError, match=message):
        Objective.parse(text)


def test_cost_by_hand() -> None:
    good = Figures(0.02, 0.3, 0.4, 0.5, 0.9)
    assert float(Objective(late=1).cost(good)) == pytest.approx(2 + 3, rel=tol.HAND)
    assert float(Objective(late=2, settling=0.5, utilisation=1).cost(good)) == pytest.approx(10 + 2 + 5, rel=tol.HAND)
    assert float(Objective(late=1).cost(good._replace(pace=1.2))) == pytest.approx(5 + 20, rel=tol.HAND)


def test_what_is_lost_or_can_never_fit_is_worth_nothing() -> None:
    lost = Figures(*(np.array([0.1, np.nan, 0.1]) for _ in range(5)))._replace(pace=np.array([0.1, np.nan, np.inf]))
    assert np.isfinite(Objective(late=1).cost(lost)).tolist() == [True, False, False]


def test_figures_of_a_batch_are_those_of_the_summary() -> None:
    settles = ("law.kp=4", "law.kd=6", "law.ke=0", "leader.input.u_x=0")
    recording = simulate(case("backend=ideal", *settles)).recording
    told = summary(recording)
    names = ("pose", "error", "twist", "input")
    batch = {name: np.stack([recording[name].values] * 2, axis=1) for name in names}
    drive = load_robot("nh_mini").model
    figures = figures_of(Rollout(recording.time, batch, None), limits_of(recording), [0, 1], drive, Ground(), 0.7)
    follower, robots = told["followers"]["follower"], told["robots"]
    assert figures.late_position[0] * max(
        robots["leader"]["path_length"], follower["initial_position_error"]
    ) == pytest.approx(follower["late_position_error"], rel=tol.HAND)
    assert figures.late_heading[1] == follower["late_heading_error"]
    assert figures.settling[0] * recording.time[-1] == pytest.approx(follower["settling_time"], rel=0.01)
    # A recording has the ends of periods only; figures look at their starts too.
    assert figures.utilisation[0] >= max(robot["peak_utilisation_predicted"] for robot in robots.values())
    assert figures.utilisation[0] == figures.utilisation[1]


# -- the search -------------------------------------------------------------------------------------


def test_a_search_betters_a_bad_start(found: Tuning) -> None:
    assert found.gains_before == {"kp": 0.3, "kd": 2, "ke": 0.05, "k": 5}
    assert found.cost < 0.3 * found.cost_before
    assert found.figures.late_position < 0.3 * found.figures_before.late_position
    costs = [generation.best for generation in found.history]
    assert costs == sorted(costs, reverse=True)
    assert found.candidates == SMALL["budget"]


def test_the_figures_are_those_of_a_run_with_the_gains(found: Tuning) -> None:
    recording = simulate(found.scenario.model_copy(update={"backend": "ideal"})).recording
    told = summary(recording)
    follower = told["followers"]["follower"]
    scale = max(told["robots"]["leader"]["path_length"], follower["initial_position_error"])
    assert found.figures.late_heading == pytest.approx(follower["late_heading_error"], abs=tol.CLOSED_LOOP)
    assert found.figures.late_position * scale == pytest.approx(follower["late_position_error"], abs=tol.CLOSED_LOOP)


def test_the_same_seed_finds_the_same_gains_and_another_others(found: Tuning) -> None:
    assert tune(case(), **SMALL) == found  # type: ignore[arg-type]
    assert tune(case(), budget=40, seed=4).gains != found.gains


def test_gains_keep_their_bounds_unless_told(found: Tuning) -> None:
    assert make_law(found.scenario.law, Similarity()).warnings() == ()
    kp, kd, ke, k = found.gains.values()
    assert k > 2 * (1 + ke / kp)
    assert kd >= 2 * math.sqrt(kp)
    bad = case("law.kd=0.5")
    free = tune(bad, budget=8, below_bound=True)
    held = tune(bad, budget=8)
    assert make_law(held.scenario.law, Similarity()).warnings() == ()
    assert free.cost <= free.cost_before
    assert "below their bounds allowed" in free.account
    assert "below" not in held.account


def test_good_gains_below_the_bounds_are_not_kept_unless_told() -> None:
    free = tune(case(), budget=40, seed=1, below_bound=True)
    assert make_law(free.scenario.law, Similarity()).warnings() != ()
    held = tune(free.scenario, budget=8)
    assert held.gains_before == free.gains
    assert held.cost > held.cost_before
    assert make_law(held.scenario.law, Similarity()).warnings() == ()


def test_later_generations_gather_around_the_best() -> None:
    box = SearchBox.of(case(), seed=0, below_bound=True)
    everywhere, best = np.log(box.spread(64)), np.array([2.0, 4.0, 0.5, 6.0])
    near = np.log(box.around(np.tile(best, (8, 1)), 64))
    assert np.all(np.abs(near - np.log(best)) < 0.3)
    assert near.std(axis=0) == pytest.approx(0.05, rel=0.2)
    assert np.all(everywhere.std(axis=0) > 1)


def test_a_slow_scenario_is_searched_coarsely_and_judged_at_its_own_rate() -> None:
    told: list[tuple[int, int]] = []
    found = tune(case("control_rate=250"), budget=8, progress=lambda _, done, total: told.append((done, total)))
    assert len(told) < 2000
    assert told[-1] == (8, 8)
    fine = simulate(found.scenario.model_copy(update={"backend": "ideal"})).recording
    assert len(fine.time) == 2501
    late = summary(fine)["followers"]["follower"]["late_heading_error"]
    assert found.figures.late_heading == pytest.approx(late, abs=tol.CLOSED_LOOP)


def test_candidates_side_by_side_are_candidates_one_by_one(found: Tuning) -> None:
    """A batch is split where memory asks for it; here into single candidates."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("nhtrack.studies.tune.trial._ROBOT_PERIODS", 1)
        alone = tune(case(), **SMALL)  # type: ignore[arg-type]
    assert alone.gains == found.gains
    assert alone.figures == pytest.approx(found.figures, rel=tol.HAND)


def test_a_time_left_open_is_found_for_the_gains_that_are_there() -> None:
    found = tune(case("similarity.time=auto"), budget=8)
    assert isinstance(found.scenario.similarity.time, float)


# Lengths, speeds and times that a law has of its own, which are not searched.
REST = {
    "universal": {"m", "field_speed", "turn_rate", "dock_radius", "dock_speed"},
    "agile": {"m", "field_speed", "turn_rate", "dock_radius", "least_speed", "near_radius", "zeta"}
    | {"window", "smoothing"},
    "vfo": {"least_speed", "dock_radius"},
    "guiding_field": {"least_speed"},
    "polar_backstepping": {"dock_radius"},
}


@pytest.mark.parametrize("name", law_names())
def test_every_range_is_a_gain_of_its_law(name: str) -> None:
    gains = {"published": ", kp: 4, kd: 6, ke: 1, k: 5", "stabiliser": ", kp: 4, kd: 6, k: 5"}.get(name, "")
    law = case(f"law={{name: {name}{gains}}}").law
    rest = REST.get(name, set())
    own = set(type(law).model_fields) - {"name", "variant", "hysteresis", "dead_zone", "limits", "delay_periods"}
    assert set(ranges_of(law)) == own - rest


def test_universal_is_tuned_too() -> None:
    found = tune(case("law={name: universal, k1: 40, k2: 13, k3: 6, c: 1}"), budget=24)
    assert set(found.gains) == {"k1", "k2", "k3", "c"}
    assert found.cost <= found.cost_before


def test_ranges_of_lengths_go_with_the_size_of_the_experiment() -> None:
    """The case's leader covers 1 + 8 m in 10 s; ten times as far in lengths of a tenth is the same experiment."""
    law = "law={name: kanayama, k_y: 4, k_theta: 4}"
    box = SearchBox.of(case(law), seed=0, below_bound=True)
    low = dict(zip(box.names, np.exp(box._low), strict=True))
    assert low == pytest.approx({"k_x": 0.6, "k_y": 9 / 9**2, "k_theta": 6 / 9, "k_inner": 0.6}, rel=tol.HAND)
    longer = case(law, 'leader.input.u_x="where(t < 2, 5, 0)"', "followers[0].start.pose=[-30, 20, 0.5]")
    ten = SearchBox.of(longer, seed=0, below_bound=True)
    np.testing.assert_allclose(ten._high - box._high, np.log([1, 1 / 100, 1 / 10, 1]), atol=tol.HAND)
    far = case(law, "leader.input.u_x=0", "followers[0].start.pose=[-30, 40, 0.5]")
    assert np.exp(SearchBox.of(far, seed=0, below_bound=True)._low[2]) == pytest.approx(6 / 50, rel=tol.HAND)


# -- gains in files ---------------------------------------------------------------------------------

GAINS = {"kp": 7.25, "kd": 12.0, "ke": 0.5, "k": 3.0}
REMARKS = ["objective late, seed 0;", "late error 1 %"]


@pytest.mark.parametrize("name", ["paper/example2", "stress/ice_patch", "tour/hello"])
def test_only_gains_and_remarks_change_in_a_bundled_scenario(name: str, tmp_path: Path) -> None:
    source, target = assets.find_scenario(name), tmp_path / "new.yaml"
    save_law_gains(source, target, GAINS, "nhtrack tune:", REMARKS)
    before, after = source.read_text().splitlines(), target.read_text().splitlines()
    added = [line for line in after if line not in before]
    kept = [line for line in before if line not in after]
    assert [line for line in added if line.startswith("# nhtrack tune: ")] == [f"# nhtrack tune: {r}" for r in REMARKS]
    assert all("kp" in line or "# nhtrack tune:" in line for line in kept)
    changed, original = load(target), load(source)
    assert changed.law == original.law.model_copy(update=GAINS)
    assert changed.model_copy(update={"law": original.law}) == original


def test_a_block_keeps_its_comments_order_line_ends_and_mark(tmp_path: Path) -> None:
    block = "# top\r\n" + CASE.strip().rsplit("\n", 1)[0].replace("\n", "\r\n")
    law = "law:   # the law\n  name: 'published'\n  kp: 1.0  # stiff\n  k: 5\n  ke: 0\n  kd: 2e0 # end\n"
    block += "\r\n" + law.replace("\n", "\r\n")
    file = tmp_path / "case.yaml"
    file.write_bytes(b"\xef\xbb\xbf" + block.encode())
    save_law_gains(file, file, GAINS, "nhtrack tune:", ["a"])
    expected = block.replace("law:   #", "# nhtrack tune: a\r\nlaw:   #").replace("kp: 1.0  #", "kp: 7.25  #")
    expected = expected.replace("k: 5", "k: 3").replace("ke: 0", "ke: 0.5").replace("kd: 2e0 #", "kd: 12 #")
    assert file.read_bytes() == b"\xef\xbb\xbf" + expected.encode()
    assert [path.name for path in tmp_path.iterdir()] == ["case.yaml"]


def test_tuning_again_replaces_its_own_remarks_and_no_others() -> None:
    text = with_law_gains("a: 1\n# mine\nlaw: {kp: 1}\n", {"kp": 2.0}, "tune:", ["one", "two"])
    assert text == "a: 1\n# mine\n# tune: one\n# tune: two\nlaw: {kp: 2}\n"
    assert with_law_gains(text, {"kp": 3.0}, "tune:", ["three"]) == "a: 1\n# mine\n# tune: three\nlaw: {kp: 3}\n"


def test_a_gain_that_was_left_out_is_added_in_the_manner_of_the_others() -> None:
    assert with_law_gains("law: {kp: 1}\n", {"k": 0.5}, "tune:", []) == "law: {kp: 1, k: 0.5}\n"
    assert with_law_gains("law:\n  kp: 1\n", {"k": 0.5}, "tune:", []) == "law:\n  kp: 1\n  k: 0.5\n"


def test_what_cannot_be_changed_in_place_is_left_as_it_was(tmp_path: Path) -> None:
    with pytest.raises(EditError, match="no `law:` section"):
        with_law_gains("a: 1\n", {}, "tune:", [])
    file = tmp_path / "case.yaml"
    file.write_text(CASE)
    with pytest.raises(ScenarioError, match=r"law\.kp: expected a value greater than 0"):
        save_law_gains(file, file, {"kp": -1.0}, "tune:", [])
    assert file.read_text() == CASE
    assert [path.name for path in tmp_path.iterdir()] == ["case.yaml"]
