"""Scenario files: what a valid one becomes, overrides, round trips, and how faults are placed and told."""

from __future__ import annotations

import copy
import json
import math
import re
import runpy
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nhtrack import assets
from nhtrack.config.changes import apply_overrides
from nhtrack.config.documentation import COMMAND, campaign_reference, json_schema, scenario_reference
from nhtrack.config.scenario import Scenario
from nhtrack.config.tree import dotted, lookup, parse_path, parse_yaml
from nhtrack.effects.motors import Motors
from nhtrack.effects.patches import Patches
from nhtrack.effects.payload import Payload
from nhtrack.effects.slope import Slope
from nhtrack.effects.wheel_mismatch import WheelMismatch
from nhtrack.errors import ScenarioError
from nhtrack.experiment.build import build, make_scene_spec
from nhtrack.experiment.leader_notes import leader_warnings
from nhtrack.experiment.load import load, load_text, load_tree
from nhtrack.experiment.robot_checks import robot_warnings
from nhtrack.ground import Ground, Patch
from nhtrack.references import Segment, SignalInput, TableInput
from nhtrack.simulation.spec import SceneSpec

DOCS = Path(__file__).parents[2] / "docs"
MINIMAL = """
name: case
duration: 10
leader:
  start: {pose: [0, 0, 0]}
  input: {u_x: 0.1, u_theta: "0.2*cos(t)"}
followers:
  - {name: follower, parents: [leader], start: {pose: [-1, 0, 0]}}
law: {name: published, kp: 4, kd: 6, ke: 1, k: 5}
"""


def minimal_tree() -> dict[str, Any]:
    tree: dict[str, Any] = parse_yaml(MINIMAL).tree
    return tree


def faults_of(text: str, **options: Any) -> list[str]:
    with pytest.raises(ScenarioError) as caught:
        load_text(text, source="case.yaml", **options)
    return str(caught.value).splitlines()


# -- what a file becomes ---------------------------------------------------------------------------


def test_defaults_fill_what_a_file_leaves_out() -> None:
    scenario = load_text(MINIMAL)
    assert (scenario.backend, scenario.robot.file, scenario.seed, scenario.control_rate) == (
        "mujoco",
        "nh_mini",
        0,
        100,
    )
    assert (scenario.similarity.length, scenario.similarity.time) == (1, 1)
    assert scenario.physics.contact.model == "stiff"
    assert scenario.physics.contact.rate_correction
    assert not scenario.physics.robot_contact
    assert scenario.followers[0].start.twist == (0, 0)
    assert scenario.law.name == "published"
    assert (scenario.law.hysteresis, scenario.law.dead_zone.length, scenario.law.dead_zone.speed) == (0.25, 1e-6, 1e-3)
    assert scenario.video.size == (640, 480)
    assert scenario.parents == {"leader": (), "follower": ("leader",)}
    assert scenario.periods == 1000


bundled = cache(load)


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] * ("formation" in name)) for name in assets.bundled_scenarios()],
)
def test_every_bundled_scenario_loads_says_what_it_is_and_comes_back_from_json(name: str) -> None:
    scenario = bundled(name)
    assert scenario.description
    dumped = scenario.model_dump(mode="json")
    assert load_tree(dumped) == scenario
    if len(scenario.followers) < 10:
        assert load_text(json.dumps(dumped)) == scenario


def test_segments_and_formulas_are_kept_as_written() -> None:
    text = MINIMAL.replace("u_x: 0.1", "u_x: [{until: 3, value: 0.5}, {value: sin(t)}]")
    given_input = load_text(text).leader.input
    assert isinstance(given_input, SignalInput)
    assert given_input.u_x == (Segment(until=3.0, value=0.5), Segment(value="sin(t)"))
    assert given_input.u_theta == "0.2*cos(t)"


def test_a_byte_order_mark_is_skipped(tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    path.write_bytes(b"\xef\xbb\xbf" + MINIMAL.encode())
    assert load(path).name == "case"


# -- what robots are up against --------------------------------------------------------------------

PHYSICS = """
physics:
  friction: 0.8
  patches:
    - {friction: 0.05, rectangle: [1, 3, -2, 4]}
    - {friction: 0.3, disc: [5, -1, 2]}
  slope: {angle: 0.1, uphill: 2.0}
  payload: {mass: 0.2, offset: [0.01, -0.02], height: 0.07, size: [0.05, 0.04, 0.03]}
  wheel_mismatch: -0.01
  motors: {torque_limit: 0.02, no_load_speed: 30}
  compensation: actual
"""


def test_places_scale_with_length_and_what_a_robot_is_does_not() -> None:
    scenario = load_text(MINIMAL + PHYSICS + "similarity: {length: 0.5, time: 3}\n")
    spec = build(scenario).scene
    assert spec == make_scene_spec(scenario)
    patches = (Patch(0.05, rectangle=(0.5, 1.5, -1.0, 2.0)), Patch(0.3, disc=(2.5, -0.5, 1.0)))
    assert set(spec.effects) == {
        Patches(patches),
        Slope(0.1, 2.0),
        Payload(0.2, (0.01, -0.02, 0.07), (0.05, 0.04, 0.03)),
        WheelMismatch(-0.01),
        Motors(0.02, 30),
    }
    assert spec.ground == Ground(0.8, patches, 0.1, 2.0)
    assert spec.compensation == "actual"
    assert spec == SceneSpec.from_json(spec.to_json())
    assert load_tree(scenario.model_dump(mode="json")) == scenario


@pytest.mark.slow
@pytest.mark.parametrize(
    ("offset", "stands"),
    [
        ((-0.09, 0.0), False),
        ((-0.08, 0.0), True),
        ((0.02, 0.0), False),
        ((0.01, 0.0), True),
        ((0.0, 0.095), False),
        ((0.0, -0.095), False),
        ((0.0, 0.085), True),
    ],
    ids=str,
)
def test_a_payload_may_not_tip_its_robot(offset: tuple[float, float], stands: bool) -> None:
    """As heavy as the robot itself: the centre of mass is half-way between the two."""
    payload = {"mass": 0.70118, "offset": list(offset), "height": 0.07}
    tree = minimal_tree() | {"physics": {"payload": payload}}
    x, y = (offset[0] - 0.010422) / 2, offset[1] / 2
    inside = -0.048 < x < 0 and abs(y) < 0.05 * (1 + x / 0.048)  # the triangle of wheels and caster
    assert inside == stands
    if stands:
        load_tree(tree)
        return
    with pytest.raises(ScenarioError, match=r"physics\.payload: it tips the robot: .* would lift"):
        load_tree(tree)
    load_tree(tree | {"physics": {"payload": payload, "base": "planar"}})  # which no payload tips


def warned(*overrides: str) -> tuple[str, ...]:
    scenario = load_text(MINIMAL, overrides=overrides)
    return robot_warnings(scenario, build(scenario))


def test_a_slope_beyond_the_friction_angle_is_told() -> None:
    """Friction 0.3 holds up to atan(0.3) = 0.291 rad."""
    assert warned("physics.slope.angle=0.29", "physics.friction=0.3") == ()
    (told,) = warned("physics.slope.angle=0.3", "physics.friction=0.3")
    assert told == (
        "physics.friction 0.3 holds up to 0.291 rad, and physics.slope.angle is 0.3: nothing there stays where it is; "
        "0.31 would hold it"
    )
    near, far = (f"physics.patches=[{{friction: 0.2, disc: [{x}, 0, 1]}}]" for x in (0, 99))
    (told,) = warned("physics.slope.angle=0.25", "physics.friction=0.3", near)
    assert told.startswith("physics.patches[0].friction 0.2 holds up to 0.197 rad")
    assert warned("physics.slope.angle=0.25", "physics.friction=0.3", far) == ()
    assert warned("physics.friction=0.3") == warned("physics.friction=0") == ()


def test_a_slope_that_would_tip_a_robot_is_told() -> None:
    """Nose to the valley the caster lifts at atan(10.4/25.1) = 0.393 rad, nose to the top it only presses harder."""
    slope = ["physics.slope.angle=0.4", "physics.friction=2"]
    facing = [f"followers[0].start.pose=[-1, 0, {math.pi}]"]  # the leader looks to the top, the follower to the valley
    (told,) = warned(*slope, *facing)
    assert told == "follower starts on a slope too steep to stand on: held there, it would lift its caster"
    assert warned("physics.slope.angle=0.39", "physics.friction=2", *facing) == ()
    assert warned(*slope) == ()
    assert warned(*slope, *facing, "physics.base=planar") == ()
    across = ["physics.slope.angle=1.1", "physics.friction=9", "followers[0].start.pose=[-1, 0, 1.5707963]"]
    backwards, sideways = warned(*across)  # the leader looks to the top, the follower has the valley on its left
    assert backwards.startswith("leader starts on a slope too steep to stand on: held there, it would lift its ")
    assert sideways == "follower starts on a slope too steep to stand on: held there, it would lift its right wheel"


def test_of_a_leader_without_a_body_nothing_is_told() -> None:
    slope = ["physics.slope.angle=0.4", "physics.slope.uphill=3.14159", "physics.friction=2"]
    assert [line.split()[0] for line in warned(*slope)] == ["leader", "follower"]
    assert [line.split()[0] for line in warned(*slope, "leader.virtual=true")] == ["follower"]


# -- files a scenario names ------------------------------------------------------------------------


def test_a_csv_is_found_beside_the_scenario_and_kept_in_it(tmp_path: Path) -> None:
    (tmp_path / "u.csv").write_text("u_theta, t, note, u_x\n0.0, 0, start, 1\n0.5, 2, , -1\n\n")
    text = MINIMAL.replace('{u_x: 0.1, u_theta: "0.2*cos(t)"}', "{csv: u.csv}")
    path = tmp_path / "case.yaml"
    path.write_text(text)
    scenario = load(path)
    assert isinstance(scenario.leader.input, TableInput)
    assert scenario.leader.input.table.model_dump() == {"t": (0.0, 2.0), "u_x": (1.0, -1.0), "u_theta": (0.0, 0.5)}
    (tmp_path / "u.csv").unlink()
    assert load_tree(scenario.model_dump(mode="json")) == scenario


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t,u_x\n0,1\n", "u.csv:1:1: expected the columns t, u_x, u_theta, got t, u_x"),
        ("", "got nothing"),
        ("t,u_x,u_theta\n", "no rows under the header"),
        ("t,u_x,u_theta\n0,1\n", "u.csv:2:4: no value for u_theta"),
        ("t,u_x,u_theta\n0,1,x\n", "u.csv:2:5: u_theta must be a finite number, got 'x'"),
        ("t,u_x,u_theta\n0,1,nan\n", "u.csv:2:5: u_theta must be a finite number, got 'nan'"),
        ("t,u_x,u_theta\n0,1,1\n0,1,1\n", "u.csv:3:1: times must increase, got 0 after 0"),
        ("t,u_x,u_theta\n1,1,1\n20,1,1\n", "u.csv:2:1: the first row is at t = 1; a table starts at 0 or before"),
    ],
)
def test_a_bad_csv_is_a_fault_of_the_key(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "u.csv").write_text(text)
    scenario = MINIMAL.replace('{u_x: 0.1, u_theta: "0.2*cos(t)"}', "{csv: u.csv, interpolation: linear}")
    (line,) = faults_of(scenario, directory=tmp_path)
    assert line.startswith("case.yaml:6:")
    assert message in line


def test_all_that_is_wrong_with_a_csv_is_told_at_once_in_its_order(tmp_path: Path) -> None:
    (tmp_path / "u.csv").write_text("t,u_x,u_theta\n0,x,0\n2,1,1,7\n1,nan,0\n3\n")
    scenario = MINIMAL.replace('{u_x: 0.1, u_theta: "0.2*cos(t)"}', "{csv: u.csv}")
    found = [re.search(r"u\.csv:\d+:\d+", line) for line in faults_of(scenario, directory=tmp_path)]
    places = ["u.csv:2:3", "u.csv:3:7", "u.csv:4:1", "u.csv:4:3", "u.csv:5:2", "u.csv:5:2"]
    assert [match and match.group() for match in found] == places


@pytest.mark.parametrize("until", [5, 10])
def test_rows_that_are_joined_and_segments_are_zero_after_their_end(until: int) -> None:
    """That rows end early is told; the end of segments is written by hand."""
    table = f"{{table: {{t: [0, {until}], u_x: [1, 1], u_theta: [0, 0]}}, interpolation: linear}}"
    listed = f"{{u_x: [{{until: {until}, value: 1}}], u_theta: 0}}"
    sampled = []
    for text, told in ((table, until < 10), (listed, False)):
        scenario = load_text(MINIMAL.replace('{u_x: 0.1, u_theta: "0.2*cos(t)"}', text))
        sampled.append(scenario.leader.input.reference().held(np.array([0.0, 4.9, 5.3, 9.9])))
        assert [f"until t = {until} only" in said for said in leader_warnings(scenario)] == told * [True]
    np.testing.assert_array_equal(*sampled)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("{poses: one.csv, formt: csv}", ".formt: unknown key; did you mean 'format'?"),
        ("{poses: 3}", ".poses: expected a section"),
        ("{poses: {t: [0], x: [0], y: [0], theta: [0]}}", ".poses.t[0]: expected at least two rows"),
        ("{velocities: {t: [0, 9], v: [0], omega: [0, 1]}}", ".velocities.v[0]: expected as many numbers as times"),
        ("{velocities: {t: [0, 9, 9], v: [0, 1, 1], omega: [0, 1, 1]}}", ".velocities.t[2]: times must increase"),
        ("{path: 3}", ".path: expected a section"),
        ("{path: {x: t}}", ".path.y: required key is missing"),
        ("{path: {waypoints: [], speed: 1, acceleration: 1}}", ".path: expected at least 2 waypoints, got 0"),
        ("{path: {waypoints: [[0, 0], [1, 0]], speed: 1, acceleration: 1, laps: 2}}", "only a closed path"),
        ("{path: {waypoints: [[0, 0], [1, 0]], speed: 1, acceleration: 1, closed: true}}", "at least 3 waypoints"),
        ("{path: {x: 1e300*t**5, y: t}}", ".path: the curve"),
    ],
)
def test_a_path_of_a_wrong_form_is_one_fault_at_its_key(tmp_path: Path, given: str, message: str) -> None:
    (tmp_path / "one.csv").write_text("t,x,y,theta\n0,0,0,0\n20,20,0,0\n")
    text = MINIMAL.replace('{u_x: 0.1, u_theta: "0.2*cos(t)"}', given).replace("  start: {pose: [0, 0, 0]}\n", "", 1)
    (line,) = faults_of(text, directory=tmp_path)
    assert line.startswith("case.yaml:5:")
    assert message in line


def test_the_start_of_a_path_is_the_leader_s_unless_it_gives_its_own(tmp_path: Path) -> None:
    text = MINIMAL.replace('{u_x: 0.1, u_theta: "0.2*cos(t)"}', "{path: {x: 1 + t, y: 2}}")
    left_out = load_text(text.replace("  start: {pose: [0, 0, 0]}\n", "", 1)).leader.start
    assert (left_out.pose, left_out.twist) == ((1, 2, 0), (1, 0))
    assert load_text(text.replace("[0, 0, 0]", "[1, 2, 0]", 1)).leader.start == left_out
    (line,) = faults_of(text)
    assert line.endswith("leader.start.pose: the input begins elsewhere: write pose: [1, 2, 0], or leave it out")
    accelerations = load_text(MINIMAL.replace("  start: {pose: [0, 0, 0]}\n", "", 1)).leader.start
    assert (accelerations.pose, accelerations.twist) == ((0, 0, 0), (0, 0))


def test_a_robot_file_is_found_beside_the_scenario(tmp_path: Path) -> None:
    (tmp_path / "mine.xml").write_text(assets.find_robot("nh_mini").read_text())
    scenario = load_text(MINIMAL + "robot: mine.xml\n", directory=tmp_path)
    assert scenario.robot.file == str(tmp_path / "mine.xml")
    assert load_tree(scenario.model_dump(mode="json")) == scenario


# -- overrides -------------------------------------------------------------------------------------


def test_overrides_change_and_add_keys_without_touching_the_tree() -> None:
    tree = minimal_tree()
    before = copy.deepcopy(tree)
    overrides = ["law.kp=3", "followers[0].start.pose=[1, 2, 0]", "physics.contact.rate_correction=false", "robot=a b"]
    changed = apply_overrides(tree, overrides)
    assert tree == before
    assert changed["law"]["kp"] == 3
    assert changed["followers"][0]["start"]["pose"] == [1, 2, 0]
    assert changed["physics"] == {"contact": {"rate_correction": False}}
    assert changed["robot"] == "a b"


def leaves(tree: Any, path: tuple[str | int, ...] = ()) -> list[tuple[str | int, ...]]:
    if isinstance(tree, dict):
        return [leaf for key, value in tree.items() for leaf in leaves(value, (*path, key))]
    if isinstance(tree, list):
        return [leaf for i, value in enumerate(tree) for leaf in leaves(value, (*path, i))]
    return [path]


@pytest.mark.slow
@settings(max_examples=40)
@given(st.data())
def test_an_override_changes_one_leaf_and_nothing_else(data: st.DataObject) -> None:
    tree = minimal_tree()
    path = data.draw(st.sampled_from(leaves(tree)))
    value = data.draw(
        st.one_of(
            st.booleans(), st.integers(), st.floats(allow_nan=False, allow_infinity=False), st.text("abc", min_size=1)
        )
    )
    changed = apply_overrides(tree, [f"{dotted(path)}={json.dumps(value)}"])
    assert lookup(changed, path) == value
    for other in leaves(tree):
        if other != path:
            assert lookup(changed, other) == lookup(tree, other)


@pytest.mark.slow
@given(st.lists(st.one_of(st.text("abcxyz_", min_size=1), st.integers(0, 99)), min_size=1).map(lambda p: ["root", *p]))
def test_paths_are_read_as_they_are_written(path: list[str | int]) -> None:
    assert parse_path(dotted(path)) == tuple(path)


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("law.kp", "expected key.path=value"),
        ("=3", "expected a key such as law.kp"),
        ("law..kp=3", "expected a key such as law.kp"),
        ("followers[1].name=a", "followers has 1 items"),
        ("followers.name=a", "followers is not a section with keys"),
        ("law[0]=a", "law is not a list"),
        ("law.kp=[1", "is not a YAML value"),
    ],
)
def test_an_override_that_fits_nowhere_says_why(override: str, message: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        apply_overrides(minimal_tree(), ["seed=1", override])
    (line,) = str(caught.value).splitlines()
    assert line.startswith(f"command line: --set {override}: ")
    assert message in line


def test_a_fault_the_command_line_brought_points_there() -> None:
    assert faults_of(MINIMAL, overrides=["law.kp=four", "law.kq=1"]) == [
        "case.yaml: law.kp: expected a number, got the text 'four' (from --set law.kp=four)",
        "case.yaml: law.kq: unknown key; did you mean 'k'? available: name, delay_periods, kp, kd, ke, k, variant, "
        "hysteresis, dead_zone (from --set law.kq=1)",
    ]
    (fault,) = faults_of(MINIMAL, overrides=["lw.kp=1"])
    assert "lw: unknown key; did you mean 'law'?" in fault
    assert fault.endswith("(from --set lw.kp=1)")


def test_an_override_mends_a_file() -> None:
    broken = MINIMAL.replace("duration: 10", "duration: -1")
    assert load_text(broken, overrides=["duration=2"]).duration == 2.0


# -- faults ----------------------------------------------------------------------------------------


def test_checks_between_keys_run_in_spite_of_other_faults() -> None:
    text = MINIMAL.replace("kp: 4", "kp: x").replace("[leader]", "[leeder]") + "control_rate: 300\nphysics: {}\n"
    keys = [line.split(": ")[1] for line in faults_of(text)]
    assert keys == ["followers[0].parents[0]", "law.kp", "control_rate"]


def test_a_misspelt_name_of_a_robot_does_not_blame_those_who_track_it() -> None:
    text = MINIMAL.replace("law:", "  - {nam: b, parents: [c], start: {pose: [0, 0, 0]}}\nlaw:")
    assert not any("no robot" in line for line in faults_of(text))


@pytest.mark.parametrize("rate", [100, 1000, 500, 62.5, 1000 / 3, 1e-3])
def test_rates_that_divide(rate: float) -> None:
    tree = apply_overrides(minimal_tree(), [f"control_rate={rate!r}", "duration=2000", "leader.input.u_theta=0"])
    assert load_tree(tree).control_rate == rate


def test_a_rate_that_all_but_divides_does_not() -> None:
    """9.9995 physics steps a period: every two thousand periods one would be missing."""
    (line,) = faults_of(MINIMAL + "control_rate: 100.005\n")
    assert "100.005 Hz does not divide the physics rate of 1000 Hz" in line
    assert "try 100 " in line


def test_a_timestep_that_is_no_decimal_divides_too() -> None:
    tree = minimal_tree() | {"control_rate": 60, "physics": {"timestep": 1 / 480}}
    assert load_tree(tree).periods == 600


@pytest.mark.parametrize(
    "text",
    [
        "[" * 1000,
        "a: " * 3000,
        "duration: " + "1" * 400,
        "duration: " + "1" * 5000,
        "? [a, b]\n: 1",
        "a: *b",
        "--- 1\n--- 2",
    ],
)
def test_hostile_text_ends_in_faults(text: str) -> None:
    assert faults_of(text)


WORDS = [*Scenario.model_fields, "start", "pose", "input", "u_x", "parents", "csv", "table"]
anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(WORDS), inner),
    max_leaves=12,
)


@pytest.mark.slow
@settings(max_examples=50)
@given(st.sampled_from(["leader", "followers", "similarity", "physics", "duration", "control_rate", "robot"]), anything)
def test_nothing_that_a_key_may_hold_brings_down_a_check(key: str, value: Any) -> None:
    with pytest.raises(ScenarioError):
        load_tree(minimal_tree() | {key: value, "law": {"name": "none"}})


def test_a_missing_file_offers_bundled_names() -> None:
    with pytest.raises(ScenarioError, match=r"^paper/exmple1: no such file.*did you mean 'paper/example1'\?"):
        load("paper/exmple1")


def test_a_directory_is_not_a_scenario(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="this is a directory"):
        load(tmp_path)


# -- the schema ------------------------------------------------------------------------------------


def sections() -> list[tuple[str, dict[str, Any]]]:
    schema = json_schema()
    return [("Scenario", schema), *schema["$defs"].items()]


def test_every_key_is_described_and_unknown_keys_are_refused() -> None:
    for name, section in sections():
        assert section["additionalProperties"] is False, name
        assert len(section["description"]) > 10, name
        for key, value in section["properties"].items():
            assert len(value.get("description", "")) > 8, f"{name}.{key}"


def test_physical_numbers_name_their_unit() -> None:
    for name, section in sections():
        for key, value in section["properties"].items():
            forms = [value, *value.get("anyOf", []), *value.get("oneOf", [])]
            if key not in ("value",) and any(form.get("type") in ("number", "integer") for form in forms):
                assert "[" in value["description"], f"{name}.{key} has no unit"


@pytest.mark.parametrize(("file", "page"), [("scenario.md", scenario_reference), ("campaign.md", campaign_reference)])
def test_the_reference_pages_are_current(file: str, page: Callable[[], str]) -> None:
    assert (DOCS / file).read_text(encoding="utf-8") == page(), f"run: {COMMAND}"


@pytest.mark.parametrize("name", ["formation64", "formation1000"])
def test_wedges_are_those_of_their_script(name: str) -> None:
    script = runpy.run_path(str(DOCS / "_generate" / "generate_formation64.py"))
    written = assets.find_scenario(f"stress/{name}").read_text(encoding="utf-8")
    assert written == script["scenario"](script["WEDGES"][name])


@pytest.mark.parametrize(
    ("override", "key"),
    [("law=a.py", "law"), ("law={file: a.py}", "law"), ("law.file=a.py", "law"), ("robot=a.xml", "robot")],
)
def test_files_of_overrides_start_from_the_working_directory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, override: str, key: str
) -> None:
    monkeypatch.chdir(tmp_path)
    changed = apply_overrides({}, [override])[key]
    file = changed if key == "robot" else changed["file"]
    assert Path(file).parent == tmp_path


def test_who_tracks_a_robot_whose_name_cannot_be_read_is_spared() -> None:
    second = "\n  - {name: b, parents: [follower], start: {pose: [-2, 0, 0]}}\nlaw"
    (line,) = faults_of(MINIMAL.replace("name: follower", "name: 3").replace("\nlaw", second))
    assert "followers[0].name" in line
