"""What files may hold that breaks readers: each kind by many of its inputs, told in one line with its place, soon."""

from __future__ import annotations

import itertools
import math
import os
import re
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from nhtrack.assets import find_campaign, find_sweep
from nhtrack.errors import ScenarioError, did_you_mean
from nhtrack.experiment.load import load, load_either, load_text
from nhtrack.references import Expression, ReferenceInputError

CASE = """name: case
duration: 10
leader:
  start: {pose: [0, 0, 0]}
  input: {u_x: 0.1, u_theta: "0.2*cos(t)"}
followers:
  - {name: follower, parents: [leader], start: {pose: [-1, 0, 0]}}
law: {name: published, kp: 4, kd: 6, ke: 1, k: 5}
"""
INPUT = '{u_x: 0.1, u_theta: "0.2*cos(t)"}'
SECONDS = 5.0  # of the CPU


def faults_of(text: str, directory: Path | None = None) -> list[str]:
    """Returns the lines that tell what is wrong with a text, all of them with a place of their own."""
    begin = time.process_time()
    with pytest.raises(ScenarioError) as caught:  # and a warning is an error, see pyproject.toml
        load_text(text, source="case.yaml", directory=directory)
    assert time.process_time() - begin < SECONDS
    assert all(fault.line for fault in caught.value.faults)
    lines = str(caught.value).split("\n")
    # each is told, but for those beyond the first hundred
    assert len(lines) == min(len(caught.value.faults), 101)
    assert all(line.isprintable() for line in lines)
    return lines


# -- formulas --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "formula",
    [
        "floor(1e3)**floor(4e6)",
        "ceil(1e3)**ceil(4e5)",
        "abs(floor(-1e3))**floor(1e6)",
        "-floor(1e300)**3",
        "floor(1e308)*floor(1e308)",
        "(floor(9)**9)**(9**9)",
        "((1 > 0) + (1 > 0))**(9**9)",
        "(not 0)*2**5000",
        "max(floor(7), 2)**1e9",
        "(t >= 0)*floor(10)**400",
        "(" + "(t > 0) + " * 90 + "1)**((t > 0)*1e6)",
    ],
)
def test_whole_numbers_do_not_grow_without_end(formula: str) -> None:
    (line,) = faults_of(CASE.replace("u_x: 0.1", f'u_x: "{formula}"'))
    assert line.startswith("case.yaml:5:11: leader.input.u_x: ")


@pytest.mark.parametrize("formula", ["floor(t)", "ceil(t)", "t > 1", "not t", "abs(floor(t))", "sign(t)", "t < 2 < 3"])
def test_every_value_within_a_formula_is_a_float(formula: str) -> None:
    """A sum of them as the exponent of a power of them then overflows, and does not fill the memory."""
    with pytest.raises(ReferenceInputError, match="has no value"):
        Expression(f"(({formula}) + 2*1e1)**(({formula}) + 1e9)")(np.array([1.5]))


@pytest.mark.parametrize(
    "formula",
    [
        "*".join("t" * 499),
        "-" * 900 + "t",
        "**".join("t" * 300),
        "not " * 240 + "t",
        "(" * 480 + "t" + ")" * 480,
        "abs(" * 199 + "t" + ")" * 199,
        "min(" * 190 + "t" + ",t)" * 190,
    ],
)
def test_deep_formulas_are_refused(formula: str) -> None:
    (line,) = faults_of(CASE.replace("u_x: 0.1", f'u_x: "{formula}"'))
    assert line.startswith("case.yaml:5:11: leader.input.u_x: ")


@pytest.mark.parametrize("formula", ["abs(" * 190 + "t" + ")" * 190, "-" * 190 + "t", "+".join("t" * 190)])
def test_formulas_as_deep_as_is_allowed_have_values(formula: str) -> None:
    load_text(CASE.replace("u_x: 0.1", f'u_x: "{formula}"').replace("duration: 10", "duration: 0.1"))


# -- YAML ------------------------------------------------------------------------------------------

TAGS = ("int", "float", "bool", "null", "str", "map", "seq", "binary", "timestamp")
TEXTS = ("''", "x", "'-'", "'0x'", "'0b'", "'.'", "'+'", "1:2", "~")


@pytest.mark.parametrize(("tag", "text"), list(itertools.product(TAGS, TEXTS)))
def test_a_tag_that_its_text_does_not_fit_is_told(tag: str, text: str) -> None:
    assert all(":9:" in line and ": seed: " in line for line in faults_of(f"{CASE}seed: !!{tag} {text}\n"))


@pytest.mark.parametrize("deep", [60, 400, 2000, 20000])
@pytest.mark.parametrize(
    ("begin", "end"), [("[", "]"), ("{a: ", "}"), ("- ", ""), ("? ", ""), ("[ ", ""), ("a: {", ""), ("[{a: ", "}]")]
)
def test_what_is_nested_without_end_is_told_where_it_gets_too_deep(begin: str, end: str, deep: int) -> None:
    line = faults_of(f"{CASE}physics:\n  {begin * deep}1{end * deep}\n")[0]
    assert line.startswith("case.yaml:10:")


@pytest.mark.parametrize(
    "line",
    [
        '"a\\nb\\e[31m": 3',
        'physics: {"a\\rb": 3}',
        '"\\u202e": 3',
        '"a\\nb": 3\n"a\\nb": 4',
        'backend: "mujoco\\e[2J"',
        'robot: "a\\0b.xml"',
        'robot: "a\\nb.xml"',
        'robot: "\\ud800.xml"',
        'law2: {file: "\\x7f.py"}',
        'description: "\\x9b31m"',
    ],
)
def test_what_a_screen_would_obey_is_told_escaped(line: str) -> None:
    assert faults_of(f"{CASE}{line}\n")


@pytest.mark.parametrize("law", ['{file: "\\0.py"}', '{file: "\\ud800.py"}', f"{{file: {'a' * 5000}.py}}", "{file: .}"])
def test_names_that_no_file_can_have_are_told_of_laws(law: str) -> None:
    assert faults_of(CASE.replace("{name: published, kp: 4, kd: 6, ke: 1, k: 5}", law))


@pytest.mark.parametrize("name", ['"a\\0b"', '"\\ud800"', "a" * 300, "a/" * 3000 + "a", "'..'", "/dev/zero"])
@pytest.mark.parametrize(
    "given", ["{{csv: {}}}", "{{poses: {}}}", "{{velocities: {}}}", "{{recording: {{file: {}, robot: a}}}}"]
)
def test_names_that_no_file_can_have_are_told_of_inputs(given: str, name: str, tmp_path: Path) -> None:
    lines = faults_of(CASE.replace(INPUT, given.format(name)), tmp_path)
    assert all(line.startswith("case.yaml:5:") for line in lines)


@pytest.mark.parametrize("name", ["a" * 300 + ".xml", "a/" * 3000 + "a.xml", "/dev/zero", "pipe.xml", "pipe.urdf"])
def test_names_that_no_file_can_have_are_told_of_robots(name: str, tmp_path: Path) -> None:
    for ending in ("xml", "urdf"):
        os.mkfifo(tmp_path / f"pipe.{ending}")
    (line,) = faults_of(f"{CASE}robot: {name}\n", tmp_path)
    assert line.startswith("case.yaml:9:")


@pytest.mark.parametrize("anchors", ["k: &a 3\nl: &a 4", "k: &a 3\nl: *a", "k: &a [*a]", "<<: *b", "k: &a {x: &a 3}"])
def test_anchors_are_told_and_bring_no_warnings(anchors: str) -> None:
    assert faults_of(f"{CASE}{anchors}\n")


@pytest.mark.parametrize("source", ["pipe", "/dev/zero", "/dev/urandom", "folder", "a" * 5000, "\0", "\ud800", "long"])
def test_what_is_no_file_of_a_scenario_is_told(source: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe")
    Path("folder").mkdir()
    Path("long").write_text(CASE + "#" * 5_000_000)
    with pytest.raises(ScenarioError, match=r"no regular file|this is a directory|no such file|more than 4 MB"):
        load(source)


# -- columns ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "place"),
    [
        (b"t,u_x,u_theta\n0,1,1\n5,\xff,1\n", "3:3"),
        (b"\xff\xfet\0,\0", "1:1"),
        (b'0,"1,1\n', "2:3"),
        (b"0,0,5,1\n", "2:7"),
        (b"0,1,1,1,1\n", "2:7"),
        (b"0,1,1\n5,\0,1\n", "3:3"),
        (b"0,1,0x10\n", "2:5"),
        (b"0,1e999,1\n", "2:3"),
        (b"0,1,1\n\n\n0,1,1\n", "5:1"),
    ],
)
def test_columns_are_told_by_their_own_line(text: bytes, place: str, tmp_path: Path) -> None:
    whole = text if text[:1] in b"t\xff" else b"t,u_x,u_theta\n" + text
    (tmp_path / "u.csv").write_bytes(whole)
    (line,) = faults_of(CASE.replace(INPUT, "{csv: u.csv}"), tmp_path)
    assert line.startswith(f"case.yaml:5:11: leader.input.csv: u.csv:{place}: ")


# -- numbers ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("old", "new", "key", "value"),
    [
        ("[-1, 0, 0]", "[-1, 0, pi/2]", "followers.0.start.pose.2", math.pi / 2),
        ("duration: 10", "duration: 6*pi", "duration", 6 * math.pi),
        ("kp: 4", "kp: 2**2", "law.kp", 4.0),
        ("name: case", "name: case\nseed: 2**10", "seed", 1024),
        ("name: case", "name: case\nphysics: {slope: {angle: pi/60}}", "physics.slope.angle", math.pi / 60),
        ("name: case", "name: case\nsimilarity: {time: sqrt(4)}", "similarity.time", 2.0),
        ("name: case", "name: case\nrecord: {every: 1 + 1}", "record.every", 2),
        (INPUT, "{table: {t: [0, 2*5], u_x: [1/4, 0], u_theta: [0, 0]}}", "leader.input.table.u_x.0", 0.25),
        (INPUT, "{u_x: [{until: 2*pi, value: 1}], u_theta: 0}", "leader.input.u_x.0.until", 2 * math.pi),
    ],
)
def test_a_number_may_be_a_formula_of_numbers(old: str, new: str, key: str, value: float) -> None:
    found: object = load_text(CASE.replace(old, new))
    for step in key.split("."):
        found = found[int(step)] if step.isdigit() else getattr(found, step)  # type: ignore[index]
    assert found == value


@pytest.mark.parametrize(
    ("formula", "said"),
    [
        ("t", "a number, got the text 't'; 't' depends on the time t"),
        ("6*pie", "a number, got the text '6*pie'; unknown name 'pie'"),
        ("1/0", "a number, got the text '1/0'; '1/0' has no value at t = 0: division by zero"),
        ("2^3", "a number, got the text '2^3'; '2^3': write powers as a**b, not a^b"),
        ("soon", "a number, got the text 'soon'"),
        ("'10'", "write it without quotes"),
        ("-pi", "a value greater than 0, got -3.14159265358979"),
        ("__import__('os')", "a number, got the text"),
        ("9**9**9", "a number, got the text"),
    ],
)
def test_what_is_no_number_is_told_as_it_stands(formula: str, said: str) -> None:
    lines = faults_of(CASE.replace("duration: 10", f"duration: {formula}"))
    assert lines == [line for line in lines if line.startswith("case.yaml:2:1: duration: expected ") and said in line]


def test_faults_of_one_place_stay_in_the_order_in_which_they_were_found(tmp_path: Path) -> None:
    (tmp_path / "d.csv").write_text("t,u_x,u_theta\n" + "".join(f"{t},x,0\n" for t in range(30)))
    (tmp_path / "case.yaml").write_text(CASE.replace(INPUT, "{csv: d.csv}"))
    with pytest.raises(ScenarioError) as caught:
        load(tmp_path / "case.yaml")
    lines = [re.findall(r"d\.csv:(\d+)|(more)", str(fault.message))[0] for fault in caught.value.faults]
    assert lines == [*((str(line), "") for line in range(2, 12)), ("", "more")]


@pytest.mark.skipif(not Path("/proc/kmsg").exists(), reason="the system has no such file")
def test_a_file_of_the_system_that_says_nothing_yet_is_not_waited_for() -> None:
    command = [sys.executable, "-m", "nhtrack", "validate", "/proc/kmsg"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("/proc/kmsg:")  # with a line, where the kernel has just said something


@pytest.mark.parametrize("place", ["arrival: {last: %s}", "sample: {count: %s}", "repeats: %s", "duration: %s"])
@pytest.mark.parametrize("kind", ["campaign/small", "sweep/small"])
def test_whole_numbers_beyond_all_others_are_told(place: str, kind: str, tmp_path: Path) -> None:
    find = find_campaign if kind.startswith("campaign") else find_sweep
    text = re.sub(r"^(duration|arrival|sample|repeats):.*\n", "", find(kind).read_text(), flags=re.MULTILINE)
    (tmp_path / "case.yaml").write_text(f"{text}\n{place % (400 * '9')}\n")
    with pytest.raises(ScenarioError, match=place.partition(":")[0]):
        load_either(tmp_path / "case.yaml")


def test_a_number_of_whole_things_is_no_fraction() -> None:
    (line,) = faults_of(f"{CASE}seed: 1/2\n")
    assert line == "case.yaml:9:1: seed: expected a whole number, got the text '1/2'"


# -- messages --------------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [0, 1, 60, 61, 2000])
def test_of_many_names_the_first_are_listed_and_the_nearest_is_found(count: int) -> None:
    told = did_you_mean("f1998x", (f"f{k}" for k in range(count)))
    assert len(told) < 500
    assert told.endswith(f" and {count - 60} more") == (count > 60)
    assert told.startswith("did you mean 'f1998'? ") == (count == 2000)


@pytest.mark.parametrize("count", [100, 101, 2000])
def test_of_very_many_faults_the_first_are_told(count: int) -> None:
    told = faults_of(CASE + "".join(f"strange{k}: 1\n" for k in range(count)))
    assert told[99].startswith("case.yaml:108:1: strange99: unknown key")
    assert told[100:] == ([f"case.yaml: and {count - 100} more"] if count > 100 else [])


# -- what MuJoCo takes otherwise -------------------------------------------------------------------


@pytest.mark.parametrize("friction", ["1e-6", "1e-9", "5e-324", "9.9e-6", "1/200000"])
@pytest.mark.parametrize("given", ["friction: {}", "patches: [{{friction: {}, disc: [0, 0, 1]}}]"])
def test_friction_that_mujoco_takes_for_another_is_refused(given: str, friction: str) -> None:
    (line,) = faults_of(f"{CASE}physics: {{{given.format(friction)}}}\n")
    assert "friction: expected 0, or at least 1e-05, the least that MuJoCo takes, got " in line


@pytest.mark.parametrize("number", ["1e100", "-1.7e308", "1.01e12", "9**99"])
@pytest.mark.parametrize(
    ("old", "new", "place"),
    [
        ("u_x: 0.1", "u_x: {}", "5:11: leader.input.u_x"),
        ("u_x: 0.1", "u_x: t*({})", "5:11: leader.input.u_x"),
        ("pose: [-1, 0, 0]", "pose: [-1, {}, 0]", "7:60: followers[0].start.pose[1]"),
        ("kd: 6", "kd: {}", "8:31: law.kd"),
    ],
)
def test_numbers_that_doubles_cannot_reckon_with_are_refused(old: str, new: str, place: str, number: str) -> None:
    told = faults_of(CASE.replace(old, new.format(number)))
    assert any(place in line and ("1e+12 in magnitude" in line or "at least 0" in line) for line in told), told


@pytest.mark.parametrize("friction", ["0", "1e-5", "2e-5"])
def test_friction_that_mujoco_takes_as_it_is_may_stand(friction: str) -> None:
    load_text(f"{CASE}physics: {{friction: {friction}}}\n")


@pytest.mark.parametrize("seconds", [200, 5000, 20000])
def test_of_long_runs_formulas_are_judged_soon(seconds: int) -> None:
    text = CASE.replace("duration: 10", f"duration: {seconds}")
    begin = time.process_time()
    load_text(text)
    assert time.process_time() - begin < SECONDS
    assert faults_of(text.replace("0.2*cos(t)", f"sqrt({0.99 * seconds} - t)"))
