"""Laws of one's own: what is refused and where, what is compiled, what is kept with a recording, and the contract."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest

import nhtrack
from nhtrack import assets
from nhtrack.config.law_sections import FileLaw
from nhtrack.errors import ScenarioError, SimulationDiverged
from nhtrack.experiment.load import load_text
from nhtrack.laws import Law, LawError, LawKind, LeaderMotion, law_in, registry
from nhtrack.laws.address import InterpretedLawWarning, entry_of
from nhtrack.laws.contract import dimension
from nhtrack.laws.evaluate import commands, first_memories
from nhtrack.laws.faults import RESERVED
from nhtrack.recording.rerun import load_recorded
from nhtrack.studies.run.run import simulate
from nhtrack.testing import LawContract
from nhtrack.testing.scenes import plain_walk

HEAD = """\
from math import cos, nan, sin
from typing import Annotated, NamedTuple
from nhtrack.laws import Gain, compiled
"""
GAINS = 'class Gains(NamedTuple):\n    k: Annotated[float, Gain("1/T", "gain", above=0.0)] = 2.0\n'
BODY = "return gains.k * (leader.v_x - follower.v_x), leader.omega - follower.omega, memory"


def command(body: str = BODY) -> str:
    arguments = "gains, period, limits, follower, leader, memory"
    return f"def command({arguments}):\n" + textwrap.indent(textwrap.dedent(body), "    ") + "\n"


def written(folder: Path, text: str, name: str = "mine.py") -> Path:
    path = folder / name
    path.write_text(HEAD + text)
    return path


def scenario(law: str, duration: float = 0.3) -> str:
    return f"""\
name: own
duration: {duration}
backend: ideal
leader: {{start: {{pose: [0, 0, 0], twist: [0.2, 0]}}, input: {{u_x: 0, u_theta: 0}}}}
followers: [{{name: robot, parents: [leader], start: {{pose: [-0.5, 0.2, 0]}}}}]
law: {law}
"""


def told(folder: Path, text: str, law: str = "{file: mine.py}") -> list[str]:
    """Returns the faults of a scenario with a law."""
    written(folder, text)
    with pytest.raises(ScenarioError) as error:
        load_text(scenario(law), directory=folder)
    return [fault.message.replace(f"{folder}/", "") for fault in error.value.faults]


# -- what is refused ------------------------------------------------------------------------------------------------

MEMORY = "class Memory(NamedTuple):\n    last: tuple[float, float]\n"
INIT = "def init(gains, period, follower, leader):\n    return Memory((0.0, 0.0))\n"
SIGNATURE = "command(gains, period, limits, follower, leader, memory) -> (u_x, u_theta, memory)"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (GAINS, [f"mine.py:1: no function `command`: {SIGNATURE}"]),
        (command(),
         ["mine.py:1: no class `Gains`: a NamedTuple of the law's gains, each a float; `pass` where it has none"]),
        (GAINS + "def command(gains):\n    pass\n",
         [f"mine.py:6: `command` takes other arguments; expected {SIGNATURE}"]),
        (GAINS + command().replace("memory)", "memory, more)", 1),
         [f"mine.py:6: `command` takes other arguments; expected {SIGNATURE}"]),
        (GAINS + command() + "def beyond(gains, leader):\n    return ()\n",
         ["mine.py:8: `beyond` takes other arguments; expected beyond(gains, period, leader) -> tuple[str, ...]"]),
        (GAINS + "command = 1\n", [f"mine.py:1: `command` is no function; expected {SIGNATURE}"]),
        ("class Gains:\n    pass\n" + command(), ["mine.py:4: `Gains` is not a NamedTuple"]),
        (
            "class Gains(NamedTuple):\n    a: str\n    b: list[float]\n" + command(),
            [
                "mine.py:5: `Gains.a`: expected float, int or bool, got str",
                "mine.py:6: `Gains.b`: expected float, int or bool, got list[float]",
            ],
        ),
        ("class Gains(NamedTuple):\n    copy: float = 1.0\n" + command("return 0.0, 0.0, memory"),
         ["mine.py:5: `Gains.copy`: no gain can have this name; it means something else in scenarios"]),
        (GAINS.replace("2.0", "-2.0") + command(), ["mine.py:5: `Gains.k`: its default -2 is not above 0"]),
        (GAINS.replace("1/T", "1/T2") + command(),
         ["mine.py:5: `Gains.k`: no unit '1/T2'; lengths L and times T such as '1', '1/T^2', 'L/T', '1/(L*T)', or "
          "robot units"]),
        (GAINS.replace("above=0.0", "search=(0, 1)") + command(),
         ["mine.py:5: `Gains.k`: search: expected 0 < low < high, got (0, 1)"]),
        (GAINS + MEMORY + command(),
         ["mine.py:6: no function `init`: init(gains, period, follower, leader) -> Memory"]),
        (GAINS + INIT + command(),
         ["mine.py:6: `init` without `Memory`: the NamedTuple that it returns, or leave `init` out"]),
        (GAINS + MEMORY.replace("tuple[float, float]", "tuple[float, ...]") + INIT + command(),
         ["mine.py:7: `Memory.last`: expected float, int or bool, or a tuple of so many of them such as "
          "tuple[float, float], got tuple[float, ...]"]),
        (GAINS + "x = (\n", ["mine.py:6: '(' was never closed"]),
        ("import nowhere_to_be_found\n",
         ["mine.py:4: ModuleNotFoundError: No module named 'nowhere_to_be_found'; a law is one file, and what it "
          "imports must be installed"]),
        (GAINS + "print(1 / 0)\n", ["mine.py:6: ZeroDivisionError: division by zero"]),
    ],
)  # fmt: skip
def test_a_file_that_is_no_law_says_where(tmp_path: Path, text: str, expected: list[str]) -> None:
    assert told(tmp_path, text) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (GAINS + command("return 0.0, 0.0"), f"mine.py:6: `command` returned (0.0, 0.0); expected {SIGNATURE}"),
        (GAINS + command("return 0.0, nan, memory"),
         "mine.py:6: `command` returned u_theta = nan; expected a finite number"),
        (GAINS + command("x = 1.0\nreturn x / (gains.k - 2), 0.0, memory"),
         "mine.py:8: `command` raised ZeroDivisionError: float division by zero, for a plain state"),
        (GAINS + "@compiled\ndef helper(x):\n    return x / (x - x)\n" + command("return helper(gains.k), 0.0, memory"),
         "mine.py:8: `command` raised ZeroDivisionError: float division by zero, for a plain state"),
        (GAINS + command("return 0.0, 0.0, (1.0,)"),
         "mine.py:6: `command` returned the memory (1.0,), and the file has no class `Memory`; return `memory`"),
        (GAINS + MEMORY + INIT.replace("Memory((0.0, 0.0))", "(0.0, 0.0)") + command(),
         "mine.py:8: `init` returned (0.0, 0.0) as memory; expected a `Memory`"),
        (GAINS + MEMORY + INIT.replace("(0.0, 0.0)", "(0.0,)") + command(),
         "mine.py:8: `init` returned Memory.last = (0.0,); expected 2 finite numbers"),
        (GAINS + MEMORY + INIT + command("return 0.0, 0.0, Memory(1.0)"),
         "mine.py:10: `command` returned Memory.last = 1.0; expected 2 finite numbers"),
        (GAINS + command() + "def warnings(gains, limits):\n    return 'no'\n",
         "mine.py:8: `warnings` returned 'no'; expected a tuple of texts"),
        (GAINS + command() + "def beyond(gains, period, leader):\n    return (float(leader.v_x.max()),)\n",
         "mine.py:8: `beyond` returned (0.2,); expected a tuple of texts"),
    ],
)  # fmt: skip
def test_a_law_is_tried_before_a_run(tmp_path: Path, text: str, expected: str) -> None:
    assert told(tmp_path, text) == [expected]


def test_a_law_says_what_of_its_leader_is_beyond_it_and_where_it_fails_to(tmp_path: Path) -> None:
    bound = "    most = leader.v_x.max()\n    return (f'{most:.1f} m/s',) if most > gains.k else ()\n"
    written(tmp_path, GAINS + command() + "def beyond(gains, period, leader):\n" + bound)
    leaders = [still_leader(speed) for speed in (1.0, 3.0)]
    law = law_in(tmp_path / "mine.py")(k=2.0)
    assert [law.beyond(0.01, leader) for leader in leaders] == [(), ("3.0 m/s",)]
    fails = "    return () if leader.v_x.max() < gains.k else (str(leader.v_z),)\n"
    written(tmp_path, GAINS + command() + "def beyond(gains, period, leader):\n" + fails)
    law = law_in(tmp_path / "mine.py")(k=2.0)
    assert law.beyond(0.01, leaders[0]) == ()
    with pytest.raises(LawError, match=r"mine\.py:9: `beyond` raised AttributeError: 'LeaderMotion' object has no"):
        law.beyond(0.01, leaders[1])


def still_leader(speed: float) -> LeaderMotion:
    """A leader that keeps its speed over ten periods."""
    return LeaderMotion(*(np.full(10, speed if name == "v_x" else 0.0) for name in LeaderMotion._fields))


def test_gains_are_judged_like_any_key(tmp_path: Path) -> None:
    text = GAINS + "    k_theta: float = 1.0\n" + command()
    assert told(tmp_path, text, "{file: mine.py, k: -1, k_teta: 2}") == [
        "expected a value greater than 0, got -1",
        "unknown key; did you mean 'k_theta'? available: name, delay_periods, file, k, k_theta",
    ]


def test_names_that_no_gain_can_have_are_those_of_its_section() -> None:
    names = {name for name in dir(FileLaw) if not name.startswith(("_", "model_"))}
    assert names | {"name", "delay_periods", "file", "limits", "kind"} == RESERVED


@pytest.mark.parametrize(
    ("unit", "powers"), [("1", (0, 0)), ("L/T^2", (1, -2)), ("1/(L*T)", (-1, -1)), ("m/s", (1, -1)), ("rad", (0, 0))]
)
def test_dimension_of_a_unit(unit: str, powers: tuple[int, int]) -> None:
    assert dimension(unit) == powers


# -- what is compiled -----------------------------------------------------------------------------------------------


def asked(law: Law) -> tuple[np.ndarray, np.ndarray]:
    walk = plain_walk()
    memory = first_memories(law, walk.follower[0], walk.leader[0])
    return commands(law, walk.follower[0], walk.leader[0], memory)


HELPERS = "def half(x):\n    return 0.25 * twice(x)\n@compiled\ndef twice(x):\n    return 2 * x\n"
QUEUE = """\
class Memory(NamedTuple):
    count: int
    queue: tuple[float, float, float]
    seen: bool
def init(gains, period, follower, leader):
    return Memory(0, (leader.v_x, 0.5, 0.25), False)
"""
SHIFT = "a, b, c = memory.queue\nreturn a, float(memory.count), Memory(memory.count + 1, (b, c, half(gains.k)), True)"


def assert_queues(law: Law) -> None:
    """Fails unless the law keeps what it saw first for three calls, and says how many there were."""
    follower, leader = np.zeros((1, 6)), np.full((1, 9), 0.75)
    memory, found = first_memories(law, follower, leader), []
    for _ in range(4):
        u, memory = commands(law, follower, leader, memory)
        found.append(u[0].tolist())
    assert found == [[0.75, 0.0], [0.5, 1.0], [0.25, 2.0], [1.0, 3.0]]
    assert memory.tolist() == [[4.0, 1.0, 1.0, 1.0, 1.0]]
    assert law.kind.modes == (0, 4)


@pytest.mark.slow
def test_memory_holds_tuples_and_helpers_are_compiled_decorated_or_not(tmp_path: Path) -> None:
    law = law_in(written(tmp_path, GAINS + HELPERS + QUEUE + command(SHIFT)))()
    assert entry_of(law.kind).interpreted is None
    assert_queues(law)


def test_what_cannot_be_compiled_says_why_and_where_and_does_the_same(tmp_path: Path) -> None:
    queue = QUEUE.replace("    return", "    import json\n    return")
    law = law_in(written(tmp_path, GAINS + HELPERS + queue + command(SHIFT)))()
    expected = r"law 'mine' runs as Python, each call some 250 times slower than compiled: .*IMPORT_NAME.*mine.py:16\)"
    with pytest.warns(InterpretedLawWarning, match=expected):
        assert entry_of(law.kind).interpreted is not None
    assert_queues(law)


def test_a_file_is_read_anew_when_it_changes(tmp_path: Path) -> None:
    """Within one second, and to a text of the same length."""
    for value in (1.0, 2.0, 1.0):
        kind = law_in(written(tmp_path, GAINS + command(f"return {value}, 0.0, memory")))
        assert kind.command(None, None, None, None, None, ()) == (value, 0.0, ())
    assert [path.name for path in tmp_path.iterdir()] == ["mine.py"]


@pytest.mark.slow
def test_code_is_not_used_where_what_imports_import_has_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    path = written(tmp_path, "from other import helper\n" + GAINS + command("return helper(1.0), 0.0, memory"))
    head = "from nhtrack.laws import compiled\nimport deeper\n@compiled\n"
    (tmp_path / "other.py").write_text(head + "def helper(x):\n    return deeper.inner(x)\n")
    for factor in (3.0, 5.0):
        inner = head.replace("import deeper\n", "") + f"def inner(x):\n    return {factor} * x\n"
        (tmp_path / "deeper.py").write_text(inner)
        registry.law_of_text.cache_clear()  # as another process, that finds the code of this one
        for name in ("other", "deeper"):
            monkeypatch.delitem(sys.modules, name, raising=False)
        assert asked(law_in(path)())[0][0, 0] == factor


def test_a_section_crosses_to_a_worker_with_its_text(tmp_path: Path) -> None:
    path = written(tmp_path, GAINS + command())
    loaded = load_text(scenario("{file: mine.py, k: 5}"), directory=tmp_path)
    sent = pickle.dumps(loaded.law)
    path.unlink()
    law = pickle.loads(sent)
    assert (law.k, law.kind.hash, law.name) == (5.0, loaded.law.kind.hash, "mine")


# -- runs -----------------------------------------------------------------------------------------------------------

LATE = """\
if follower.x > 0.05 and gains.k > 2:
    raise ValueError('far')
return nan if follower.x > 0.05 else 5.0, 0.0, memory
"""


@pytest.mark.slow
def test_a_law_that_fails_later_ends_the_run_with_its_line(tmp_path: Path) -> None:
    path = written(tmp_path, GAINS + command(LATE))
    for k, said in ((1, f"(`command` of {path}:6)"), (3, f"law 'mine' raised ValueError: far ({path}:8)")):
        outcome = simulate(load_text(scenario(f"{{file: mine.py, k: {k}}}", 2.0), directory=tmp_path))
        assert isinstance(outcome.failure, SimulationDiverged)
        assert f"{said}: robot 'robot' at t =" in str(outcome.failure)
        assert 10 < len(outcome.recording.time) < 200


@pytest.mark.slow
def test_a_recording_runs_again_with_the_law_it_holds(tmp_path: Path) -> None:
    path = written(tmp_path, GAINS + "    way: int = 1\n" + command())
    text = scenario("{file: mine.py, k: 3}") + "similarity: {length: 2, time: 0.5}\n"
    loaded = load_text(text, directory=tmp_path)
    first = nhtrack.run(loaded).recording
    assert '"gains": {"k": 6.0, "way": 1.0}' in first.dataset.attrs["law"]  # in robot units
    assert load_recorded(first, "it", trust=True)[1] == ()
    for change in ("changed", "gone"):
        if change == "changed":
            written(tmp_path, GAINS + command("return 0.0, 0.0, memory"))
        else:
            path.unlink()
        again, notes = load_recorded(first, "it", trust=True)
        assert change in notes[0]
        second = nhtrack.run(again).recording
        np.testing.assert_array_equal(second["pose"], first["pose"])
        assert again.law.kind.source == loaded.law.kind.source
        assert load_recorded(second, "it", trust=True)[1] == ()
    other = written(tmp_path, GAINS + "    way: int = 1\n" + command("return 0.0, 0.0, memory"), "other.py")
    assert load_recorded(first, "it", [f"law.file={other}"])[0].law.kind.file == str(other)


# -- installed laws -------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_laws_of_installed_packages(tmp_path: Path) -> None:
    """A good one is a name as any; a broken one is told only to who names it. Here no compiled code can be kept."""
    (tmp_path / "laws_of_mine").mkdir()
    written(tmp_path / "laws_of_mine", GAINS + command(), "good.py")
    written(tmp_path / "laws_of_mine", GAINS, "bad.py")
    info = tmp_path / "laws_of_mine-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: laws-of-mine\nVersion: 1\n")
    (info / "entry_points.txt").write_text(f"[{registry.GROUP}]\ngood = laws_of_mine.good\nbad = laws_of_mine.bad\n")
    script = f"""
import sys
sys.path.insert(0, {str(tmp_path)!r})
import numpy as np
from nhtrack.compiled import cache_folder
from nhtrack.errors import ScenarioError
from nhtrack.laws.evaluate import commands
from nhtrack.experiment.load import load_text
text = {scenario("LAW")!r}
law = load_text(text.replace("LAW", "{{name: good, k: 3}}")).law
u, _ = commands(law.kind(k=law.k), np.zeros((1, 6)), np.ones((1, 9)), np.zeros((1, 0)))
print(law.model_dump(mode="json"), u.tolist(), law.kind.built_in, cache_folder())
for law in ("{{name: bad}}", "{{name: goood}}"):
    try:
        load_text(text.replace("LAW", law))
    except ScenarioError as error:
        print(error)
"""
    environment = os.environ | {"NUMBA_CACHE_DIR": str(info / "METADATA")}  # a file where a folder should be
    command_line = [sys.executable, "-B", "-W", "error", "-c", script]
    done = subprocess.run(command_line, capture_output=True, text=True, check=True, env=environment)
    good, bad, unknown = done.stdout.splitlines()
    assert good == "{'name': 'good', 'delay_periods': 0, 'k': 3.0} [[3.0, 1.0]] False None"
    assert "bad.py:1: no function `command`" in bad
    assert "did you mean 'good'" in unknown


# -- the contract: each test fails for a law that breaks it -----------------------------------------------------------

BREAKS = {
    "test_commands_are_finite": "1.0 / (leader.x - follower.x), 0.0",
    "test_place_in_the_world_does_not_matter": "follower.x, 0.0",
    "test_axes_of_the_world_do_not_matter": "leader.x - follower.x, 0.0",
    "test_whole_turns_do_not_matter": "0.0, leader.theta - follower.theta",
    "test_left_is_as_right": "0.0, 1.0",
    "test_units_do_not_matter": "gains.k * leader.v_x + 1.0, 0.0",
}
CLAIMS_NOTHING = "follower.x, 1.0 + follower.theta"


@pytest.fixture(scope="module")
def faulty(tmp_path_factory: pytest.TempPathFactory) -> LawKind:
    """A law with a gain that says in which way it is faulty."""
    ways = (f"if gains.way == {i}:\n    return {u}, memory\n" for i, u in enumerate([*BREAKS.values(), CLAIMS_NOTHING]))
    text = GAINS + "    way: int = 0\n" + command("".join(ways) + "return 0.0, 0.0, memory")
    return law_in(written(tmp_path_factory.mktemp("faulty"), text))


@pytest.mark.slow
@pytest.mark.parametrize("name", BREAKS)
def test_contract_is_broken_by_a_law_that_breaks_it(faulty: LawKind, name: str) -> None:
    class Contract(LawContract):
        law = faulty(way=list(BREAKS).index(name))

    with pytest.raises(AssertionError):
        getattr(Contract(), name)()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::nhtrack.laws.address.InterpretedLawWarning")
def test_contract_is_broken_by_a_law_that_is_python_and_remembers(tmp_path: Path) -> None:
    class Contract(LawContract):
        body = "import json\nseen.append(0)\nreturn float(len(seen)), 0.0, memory"
        law = law_in(written(tmp_path, "seen = []\n" + GAINS + command(body)))()

    for broken in (Contract().test_same_in_same_out, Contract().test_compiled_is_python):
        with pytest.raises(AssertionError):
            broken()


@pytest.mark.slow
def test_contract_tests_only_what_is_claimed(faulty: LawKind) -> None:
    class Contract(LawContract):
        law = faulty(way=len(BREAKS))
        translation = rotation = turns = mirror = similarity = False

    for name in dir(LawContract):
        if name.startswith("test_"):
            getattr(Contract(), name)()


# -- the law to start from ------------------------------------------------------------------------------------------


def test_the_law_to_start_from_warns() -> None:
    kind = law_in(assets.find_example("write_a_law/my_law.py"))
    assert kind().warnings() == ()
    assert kind(k_y=9.0).warnings() == ("k_theta = 4 is below 2 sqrt(k_y) = 6: it swings onto a line",)


def test_what_is_no_text_of_a_bounded_size_is_not_read(tmp_path: Path) -> None:
    mine = tmp_path / "mine.py"
    with pytest.raises(LawError, match=r"mine\.py: no such file"):
        law_in(mine)
    for data, said in ((b"#" * 1_000_001, "mine.py: has more than 1 MB"), (b"\nx = '\xff'", "mine.py:2:6: not UTF-8")):
        mine.write_bytes(data)
        with pytest.raises(LawError, match=said):
            law_in(mine)
    with pytest.raises(LawError, match="is a directory"):
        law_in(tmp_path)
    os.mkfifo(tmp_path / "pipe.py")
    with pytest.raises(LawError, match="is no regular file"):
        law_in(tmp_path / "pipe.py")
