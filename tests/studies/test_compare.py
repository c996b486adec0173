"""Laws side by side: how they are asked for, one time scale, how they did, what is kept of them."""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import numpy as np
import pytest

from nhtrack import se2
from nhtrack.config.law_sections import LawSection, law_section
from nhtrack.config.scenario import Scenario
from nhtrack.errors import FeasibilityError, ScenarioError
from nhtrack.experiment.load import load, load_text
from nhtrack.files.folder import OutputError
from nhtrack.recording import Recording
from nhtrack.studies.compare import run as study
from nhtrack.studies.compare.laws_file import load_laws
from nhtrack.studies.compare.ranking import MEASURES, Standing, best, control_effort, standing
from nhtrack.studies.compare.result import Comparison, Search
from nhtrack.studies.compare.run import compare_laws, labels
from nhtrack.studies.feasibility.run import fitting_time
from nhtrack.studies.run.run import run_scenario
from nhtrack.studies.tune.box import TuningError
from nhtrack.studies.tune.objective import Objective
from nhtrack.studies.tune.run import find_gains
from recordings import synthetic_recording

# Figures computed anew from a recording as it was saved: the same sums in another order, some 1e5 terms.
RECOMPUTED = 1e-9

CASE = """
name: case
duration: 6
control_rate: 20
backend: ideal
similarity: {length: 0.1, time: 1}
leader:
  start: {pose: [0, 0, 0]}
  input: {u_x: "where(t < 2, 0.5, 0)", u_theta: "0.1*sin(t)"}
followers:
  - {name: near, parents: [leader], start: {pose: [-1, 0.5, 0.5]}}
  - {name: far, parents: [near], start: {pose: [-3, 2, -0.5]}}
law: {name: published, kp: 1, kd: 3, ke: 0.3, k: 5}
"""
KANAYAMA, SAMSON, UNIVERSAL = (law_section(name)(name=name) for name in ("kanayama", "samson", "universal"))
WILD = law_section("kanayama")(name="kanayama", k_inner=250.0)  # far beyond what 20 Hz bears: diverges within a second


PLAIN = {"figures": False, "video": False, "report": False}


def case(*overrides: str) -> Scenario:
    return load_text(CASE, overrides=overrides)


def asked(*texts: str, scenario: Scenario | None = None) -> tuple[LawSection, ...]:
    return load_laws(lambda: scenario or case(), texts, load)[1]


# -- which laws -------------------------------------------------------------------------------------


def test_the_scenarios_own_law_comes_first_unless_it_is_listed() -> None:
    own = case().law
    assert asked("kanayama", "samson") == (own, KANAYAMA, SAMSON)
    assert asked("kanayama", "published") == (KANAYAMA, own)  # with the gains of the scenario, not of a schema


def test_a_law_written_out_or_in_a_file_has_those_gains(tmp_path: Path) -> None:
    other = tmp_path / "other.yaml"
    other.write_text(CASE.replace("kp: 1,", "kp: 7.5,"))
    written, filed = asked("{name: kanayama, k_x: 2}", str(other))[1:]
    assert written == law_section("kanayama")(name="kanayama", k_x=2.0)
    assert filed == case("law.kp=7.5").law
    assert asked("tour/universal")[1] == load("tour/universal").law  # a bundled one, its limits with it


def test_labels_are_names_numbered_where_they_must_be() -> None:
    laws = (KANAYAMA, SAMSON, WILD, UNIVERSAL)
    assert labels(laws) == ("kanayama-1", "samson", "kanayama-2", "universal")


@pytest.mark.parametrize(
    ("texts", "faults"),
    [
        (("kanyama",), ["command line: no law called 'kanyama'; did you mean 'kanayama'? available: published,"]),
        (("stabiliser",), ["law 'stabiliser' has no gains by default; write '{name: stabiliser, kp: ..., kd: ..., k:"]),
        (("published",), ["command line: nothing to compare: 'published' is the scenario's own law; name another"]),
        (("samson", "samson"), ["command line: law 'samson' is asked for twice"]),
        (("samson", "{name: samson}"), ["law '{name: samson}' is the same as 'samson'; name it once"]),
        (("{name: kanayama, kx: 2}",), ["{name: kanayama, kx: 2}:1:18: kx: unknown key; did you mean 'k_x'?"]),
        (("{name: kanayama, k_x: -2}",), [":1:18: k_x: expected a value greater than 0, got -2"]),
        (("{name: kanayama, dead_zone: {sped: 1}}",), [":1:30: dead_zone.sped: unknown key; did you mean 'speed'?"]),
        (("{name: kanyama}",), ["{name: kanyama}:1:2: name: no law called 'kanyama'; did you mean 'kanayama'?"]),
        (("{k_x: 2}",), ["{k_x: 2}:1:1: expected a section with a `name`"]),
        (("{name:",), ["{name::1:7: not valid YAML", "in a shell a mapping stands in quotes"]),
        (("{name: published, kp: 1, kd: 1, ke: 1}",), [":1:1: k: required key is missing: steering gain"]),
        (("nowhere.yaml",), ["nowhere.yaml: no such file"]),
        (("tour/helo",), ["tour/helo: no such file, and no bundled scenario of that name; did you mean 'tour/hello'?"]),
    ],
)
def test_faults_of_what_is_asked_for(texts: tuple[str, ...], faults: list[str]) -> None:
    with pytest.raises(ScenarioError) as caught:
        asked(*texts)
    for fault in faults:
        assert fault in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


def test_all_faults_are_told_at_once_each_with_its_source() -> None:
    texts = ("published", "kanyama", "{name: samson, c: 1, zeta: -1}", "nowhere.yaml", "tour/hello", "tour/hello")
    with pytest.raises(ScenarioError) as caught:
        load_laws(lambda: case("law.kp=x", "duration=-1"), texts, load)
    lines = str(caught.value).splitlines()
    begins = ["<text>: duration: ", "<text>: law.kp: ", "command line: no law called 'kanyama'; "]
    begins += ["{name: samson, c: 1, zeta: -1}:1:16: c: ", "{name: samson, c: 1, zeta: -1}:1:22: zeta: "]
    begins += ["nowhere.yaml: ", "command line: law 'tour/hello' is asked for twice"]
    assert len(lines) == len(begins)
    for line, begin in zip(lines, begins, strict=True):
        assert line.startswith(begin)
    assert len(caught.value.faults) == len(lines)
    again = pickle.loads(pickle.dumps(caught.value))
    assert (str(again), again.faults) == (str(caught.value), caught.value.faults)


def test_there_may_be_more_laws_than_colours() -> None:
    assert len(asked(*(f"{{name: kanayama, k_x: {k}}}" for k in range(1, 12)))) == 12


# -- how they did -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A comparison of three laws, of which one diverges and one is the scenario's own."""
    folder = tmp_path_factory.mktemp("comparison")
    compare_laws(case(), asked("kanayama", "{name: kanayama, k_inner: 250}"), folder, **PLAIN)
    return folder


@pytest.fixture(scope="module")
def runs(folder: Path) -> dict[str, Recording]:
    return {row["label"]: Recording.load(folder / row["label"] / "recording.nc") for row in tree_of(folder)["laws"]}


def tree_of(folder: Path) -> dict:
    return json.loads((folder / "comparison.json").read_text())


@pytest.mark.slow
def test_rows_are_what_the_recordings_say(folder: Path, runs: dict[str, Recording]) -> None:
    rows = tree_of(folder)["laws"]
    assert [row["label"] for row in rows] == ["published", "kanayama-1", "kanayama-2"]
    for row in rows[:2]:
        run = runs[row["label"]].dataset
        error = np.asarray(se2.between(run.leader_pose.values, run.pose.values))[:, 1:]
        distance, heading = np.hypot(error[..., 0], error[..., 1]), np.abs(se2.wrap(error[..., 2]))
        late = run.time.values >= 0.85 * run.time.values[-1] - 1e-9
        gap = (run.pose - run.ideal_pose).values[:, 1:, :2]
        outside = (distance > 0.01) | (heading > 0.02)
        settled = run.time.values[np.minimum(len(outside) - outside[::-1].argmax(axis=0), len(outside) - 1)]
        effort = np.sqrt(np.nanmean(run.input.values[:, 1:] ** 2, axis=(0, 1)))
        cut = run.torque_saturation.values[:, 1:].max(axis=-1)
        expected = {
            "end": 6.0,
            "late_position_error": distance[late].max(),
            "late_heading_error": heading[late].max(),
            "settling_time": None if outside[late].any() else settled.max(),
            "gap_position_rms": np.sqrt((gap**2).sum(axis=-1).mean(axis=0)).max(),
            "peak_utilisation": run.friction_utilisation.values[:, 1:].max(),
            "torque_saturation_share": cut.mean(axis=0).max(),
            "effort_x": effort[0],
            "effort_theta": effort[1],
        }
        for measure, value in expected.items():
            assert row[measure] == (None if value is None else pytest.approx(value, rel=RECOMPUTED)), measure
        assert (row["outcome"], row["tuning"]) == ("completed", None)


def test_a_law_that_diverges_says_so_and_is_kept(folder: Path, runs: dict[str, Recording]) -> None:
    tree = tree_of(folder)
    row = tree["laws"][2]
    assert row["outcome"].startswith("diverged: ")
    assert row["law"] == WILD.model_dump(mode="json")
    assert 0 < row["end"] < 1
    assert [row[name] for name in ("late_position_error", "late_heading_error", "settling_time")] == [None] * 3
    assert runs["kanayama-2"].time[-1] == row["end"]
    assert json.loads((folder / "kanayama-2" / "summary.json").read_text())["outcome"] == row["outcome"]
    assert all(label != "kanayama-2" for label in tree["best"].values())


def test_the_tree_says_what_was_compared(folder: Path, runs: dict[str, Recording]) -> None:
    tree = tree_of(folder)
    assert tree["scenario"] == case().model_dump(mode="json")
    assert tree["similarity"] == {"length": 0.1, "time": 1.0}
    assert (tree["name"], tree["backend"], tree["search"], tree["notes"]) == ("case", "ideal", None, [])
    assert {"nhtrack", "mujoco"} <= set(tree["versions"])
    for row in tree["laws"]:
        assert runs[row["label"]].scenario.law.model_dump(mode="json") == row["law"]


def a_standing(outcome: str = "completed", **figures: float | None) -> Standing:
    return Standing("law", outcome, 1.0, **(dict.fromkeys(MEASURES, None) | figures))


def test_the_best_is_the_smallest_of_those_that_completed() -> None:
    laws = [
        a_standing(effort_x=2.0, peak_utilisation=0.5, settling_time=3.0, effort_theta=1.0),
        a_standing(effort_x=1.0, peak_utilisation=0.5, effort_theta=2.0),
        a_standing("diverged: far away", effort_x=0.1, effort_theta=0.1),
        a_standing(effort_x=1.5, peak_utilisation=0.7, effort_theta=None),
    ]
    # The utilisation has two that are alike; only one law settles.
    assert best(laws) == {"effort_x": 1, "effort_theta": 0}


@pytest.mark.parametrize(
    ("figure", "values", "ties"),
    [
        ("late_position_error", (592e-9, 593e-9), True),
        ("late_position_error", (0.0, 4.9e-15), True),
        ("late_position_error", (5e-7, 2e-6), False),
        ("late_position_error", (0.1000, 0.1009), True),
        ("late_position_error", (0.1000, 0.1011), False),
        ("settling_time", (0.50, 0.51), True),
        ("settling_time", (0.50, 0.53), False),
        ("peak_utilisation", (0.0200, 0.0209), True),
        ("torque_saturation_share", (0.0, 0.002), False),
    ],
)
@pytest.mark.parametrize("swapped", [False, True])
def test_laws_that_differ_by_nothing_that_means_anything_tie(
    figure: str, values: tuple[float, float], ties: bool, swapped: bool
) -> None:
    laws = [a_standing(**{figure: value}) for value in (reversed(values) if swapped else values)]
    assert best(laws) == ({} if ties else {figure: int(swapped)})


def test_a_figure_that_one_follower_lacks_is_not_known() -> None:
    recording = synthetic_recording(2, samples=21)
    figures = {
        "followers": {name: dict.fromkeys(MEASURES, value) for name, value in (("f1", 3.0), ("f2", 5.0))},
        "robots": {name: dict.fromkeys(MEASURES, value) for name, value in (("leader", 0.9), ("f1", 0.2), ("f2", 0.1))},
    }
    law = standing("law", recording, figures)
    assert (law.settling_time, law.peak_utilisation) == (5.0, 0.2)  # the worst, and of followers
    figures["followers"]["f1"]["settling_time"] = figures["robots"]["f2"]["peak_utilisation"] = None
    law = standing("law", recording, figures)
    assert (law.settling_time, law.peak_utilisation) == (None, None)  # one never settles, one lifts a wheel


def test_effort_is_of_followers_and_leaves_out_the_end() -> None:
    recording = synthetic_recording(2, samples=5)
    u = np.full((5, 3, 2), 9.0)
    u[:, 1], u[:, 2] = (3.0, -1.0), (4.0, 7.0)
    u[-1] = np.nan
    recording.dataset["input"].values[:] = u
    assert control_effort(recording) == pytest.approx((np.sqrt(12.5), 5.0))
    recording.dataset["input"].values[0, 1] = (np.inf, 1e200)
    assert control_effort(recording) == (None, None)


# -- gains and time ---------------------------------------------------------------------------------


@pytest.mark.slow
def test_gains_are_searched_for_every_law_alike_and_kept_where_none_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scenario = case("seed=3")
    reason = "none of 16 candidates keeps its robots"

    def tune_some(scenario: Scenario, *arguments: object) -> object:
        if scenario.law.name == "samson":
            raise TuningError(reason)
        return find_gains(scenario, *arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(study, "find_gains", tune_some)
    laws = asked("kanayama", "samson", scenario=scenario)
    found = compare_laws(scenario, laws, tmp_path, search=Search(Objective(late=1.0), 16), **PLAIN)
    rows = tree_of(tmp_path)["laws"]
    for law, row in zip(laws[:2], rows[:2], strict=True):
        expected = find_gains(scenario.model_copy(update={"law": law}), Objective(late=1.0), 16, seed=3)
        assert row["tuning"]["gains"] == expected.gains
        assert row["law"] == expected.scenario.law.model_dump(mode="json")
        assert row["tuning"]["cost"] == pytest.approx(expected.cost)
    assert tree_of(tmp_path)["search"] == {"objective": "late", "budget": 16, "seed": 3}
    assert set(found.tunings) == {"published", "kanayama"}
    assert found.notes == (f"samson: not tuned, its gains are those it came with: {reason}",)
    assert found.entrants["samson"].law == SAMSON
    assert rows[2]["tuning"] is None


@pytest.mark.slow
def test_one_time_scale_for_all_the_largest_that_one_asks_for(tmp_path: Path) -> None:
    scenario = case("similarity.time=auto", "similarity.length=1")
    laws = asked("kanayama", scenario=scenario)
    times = [fitting_time(scenario.model_copy(update={"law": law})) for law in laws]
    assert times[0] != times[1]
    found = compare_laws(scenario, laws, tmp_path, **PLAIN)
    assert found.scenario.similarity.time == max(times)
    assert {entrant.similarity.time for entrant in found.entrants.values()} == {max(times)}
    assert {run.time_scale for run in found.recordings.values()} == {max(times)}


@pytest.mark.slow
def test_a_law_that_fits_no_time_has_no_say_in_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fitting(scenario: Scenario, progress: object = None) -> float:
        if scenario.law.name == "samson":
            raise FeasibilityError("the ideal run diverges at every time scale tried, up to 100")
        return 2.5

    monkeypatch.setattr(study, "fitting_time", fitting)
    scenario = case("similarity.time=auto", "duration=1")
    found = compare_laws(scenario, (KANAYAMA, SAMSON), tmp_path, **PLAIN)
    assert {run.time_scale for run in found.recordings.values()} == {2.5}
    assert found.notes == (
        "similarity.time is 2.5, the smallest that fits the other laws: kanayama asks for it",
        "samson: fits no time scale and had no say in it: the ideal run diverges at every time scale tried, up to 100",
    )
    with pytest.raises(FeasibilityError, match="samson: the ideal run diverges"):
        compare_laws(scenario, (SAMSON,), tmp_path / "none", **PLAIN)
    assert not (tmp_path / "none").exists()


def test_limits_that_leave_nothing_are_refused_before_a_folder_is_made(tmp_path: Path) -> None:
    steep = case("physics.slope.angle=1.5")
    laws = asked("{name: universal, limits: {utilisation: 0.1}}", scenario=steep)
    with pytest.raises(FeasibilityError):
        compare_laws(steep, laws, tmp_path / "results")
    assert list(tmp_path.iterdir()) == []


# -- folders and interruptions ----------------------------------------------------------------------


def files_in(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.slow
def test_a_folder_never_holds_the_files_of_two(tmp_path: Path) -> None:
    """A folder of results forgets an earlier comparison's laws and an earlier run; what is not ours stays."""
    short = case("duration=1")
    compare_laws(short, (SAMSON,), tmp_path, **PLAIN)
    mine = ("notes.txt", "samson/notes.txt", "other/recording.nc", "other/summary.json")
    (tmp_path / "other").mkdir()
    for name in (*mine, "video.mp4", "recording.nc"):
        (tmp_path / name).write_text("old")
    with pytest.raises(OutputError, match="exists already"):
        compare_laws(short, (KANAYAMA,), tmp_path, **PLAIN)
    found = compare_laws(short, (KANAYAMA,), tmp_path, overwrite=True, **PLAIN)
    ours = {"comparison.json", "kanayama/recording.nc", "kanayama/summary.json"}
    assert files_in(tmp_path) == ours | set(mine)
    assert {path.relative_to(tmp_path).as_posix() for path in found.files} == ours
    run_scenario(short, tmp_path, overwrite=True, **PLAIN)
    assert files_in(tmp_path) == {"recording.nc", "summary.json"} | set(mine)


def stopping_at(label: str, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = study.simulate

    def simulate(scenario: Scenario, stage: object) -> object:
        if scenario.law.name == label:
            raise KeyboardInterrupt
        return whole(scenario)

    monkeypatch.setattr(study, "simulate", simulate)


@pytest.mark.slow
def test_an_interruption_keeps_the_laws_before_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stopping_at("samson", monkeypatch)
    found = compare_laws(case("duration=1"), (KANAYAMA, SAMSON, UNIVERSAL), tmp_path)
    assert found.interrupted
    assert found.completed
    assert "samson: not run, the comparison was interrupted" in found.warnings
    assert "universal: not run, the comparison was interrupted" in found.warnings
    kept = {"comparison.json", "kanayama/recording.nc", "kanayama/summary.json"}
    assert files_in(tmp_path) == kept
    assert [row["label"] for row in tree_of(tmp_path)["laws"]] == ["kanayama"]


def test_an_interruption_of_the_first_law_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stopping_at("kanayama", monkeypatch)
    with pytest.raises(KeyboardInterrupt):
        compare_laws(case("duration=1"), (KANAYAMA, SAMSON), tmp_path / "results")
    assert list(tmp_path.iterdir()) == []


def test_what_every_law_is_warned_of_is_said_once(tmp_path: Path) -> None:
    """Warnings of one law carry its name."""
    entrants = {law.name: case("duration=0.5").model_copy(update={"law": law}) for law in (KANAYAMA, SAMSON)}
    outcomes = {label: study.simulate(entrant) for label, entrant in entrants.items()}
    outcomes["kanayama"].summary["warnings"] = ["leans", "slips"]
    outcomes["samson"].summary["warnings"] = ["leans", "spins"]
    found = Comparison(entrants["samson"], entrants, outcomes, None, {}, (), tmp_path)
    assert found.warnings == ("every law: leans", "kanayama: slips", "samson: spins")
    assert not found.interrupted
