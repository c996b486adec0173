"""Commands from the outside: what they print and write, and their exit codes."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

import nhtrack
from commands import invoke
from nhtrack import assets
from nhtrack.config.tree import parse_yaml
from nhtrack.errors import RobotError, SimulationDiverged
from nhtrack.experiment.load import load
from nhtrack.recording import Recording
from nhtrack.references import MotionInput


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


# -- start-up --------------------------------------------------------------------------------------

# What no command needs before it works, and what a run without pictures needs never.
HEAVY = {"mujoco", "dm_control", "xarray", "scipy", "numpy", "numba", "rich"}
PICTURES = {"matplotlib", "plotly", "jinja2", "imageio", "PIL", "networkx"}
RUN = ["run", "tour/hello", "--backend", "ideal", "--set", "duration=0.1", "--no-video", "--no-figures"]
# One after the other in one process, each with what is not imported after it.
WORK = [
    ("nhtrack.cli.app(['run', '--help'], standalone_mode=False)", HEAVY | PICTURES),
    ("import nhtrack.studies.run.run", {"xarray", "pandas", *PICTURES}),
    (f"nhtrack.cli.app({[*RUN, '--no-report']}, standalone_mode=False)", PICTURES),
    (f"nhtrack.cli.app({RUN}, standalone_mode=False)", {"matplotlib", "imageio", "networkx"}),
]
PROBE = """
{work}
print("imported", sorted({heavy} & {{name.split(".")[0] for name in sys.modules}}), file=sys.stderr)
"""


@pytest.mark.slow
def test_nothing_is_imported_that_is_not_needed() -> None:
    script = "import sys\nimport nhtrack.cli" + "".join(PROBE.format(work=work, heavy=heavy) for work, heavy in WORK)
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert [line for line in done.stderr.splitlines() if line.startswith("imported")] == 4 * ["imported []"]


def test_the_package_lends_its_names_when_asked() -> None:
    assert nhtrack.Recording is Recording
    assert set(nhtrack.__all__) <= set(dir(nhtrack))
    assert all(getattr(nhtrack, name) is not None for name in nhtrack.__all__)
    with pytest.raises(AttributeError, match="no attribute 'laod'; it has NhtrackError, Recording, Scenario"):
        nhtrack.laod  # noqa: B018


def test_version_and_help() -> None:
    assert invoke("--version").stdout == f"nhtrack {nhtrack.__version__}\n"
    listed = invoke("--help").stdout
    for command in ("run", "validate", "schema", "init", "render", "list", "doctor", "paper"):
        assert f" {command} " in listed
        assert invoke(command, "--help").exit_code == 0


@pytest.mark.parametrize(
    "arguments",
    [
        ("rum",),
        ("run",),
        ("run", "tour/hello", "--sed", "3"),
        ("run", "tour/hello", "--seed", "x"),
        ("run", "tour/hello", "--backend", "gazebo"),
        ("run", "tour/hello", "--set", "law.kp"),
        ("run", "tour/hello", "--seed", "-1"),
        ("render", "x.nc", "--size", "641x480"),
        ("render", "x.nc", "--size", "big"),
        ("render", "x.nc", "--speed", "0"),
        ("validate",),
    ],
)
def test_a_wrong_command_line_exits_2(arguments: tuple[str, ...], tmp_path: Path) -> None:
    result = invoke(*arguments)
    assert result.exit_code == 2
    assert result.stderr
    assert "Traceback" not in result.output
    assert list(tmp_path.iterdir()) == []


# -- files -----------------------------------------------------------------------------------------


def test_scenarios_and_campaigns_are_valid_by_name_and_by_file() -> None:
    path = assets.find_scenario("paper/example4")
    told = {
        "tour/hello": "1 follower, 24 s on the robot's clock, published law",
        path: "3 followers, 100 s on the robot's clock, published law",
        "campaign/small": "3 laws, 4 references, 480 runs, ideal backend",
        assets.find_campaign("campaign/mujoco"): "1 law, 10 references, 10\N{NO-BREAK SPACE}000 runs, mujoco backend",
    }
    assert invoke("validate", *told).stdout.splitlines() == [f"{name}: ok ({said})" for name, said in told.items()]


QUICK = "leader={start: {pose: [0, 0, 0]}, input: {u_x: 2*cos(4*t), u_theta: 0}}"


def test_validate_warns_and_is_strict_if_asked(tmp_path: Path) -> None:
    text = assets.find_scenario("tour/universal").read_text().replace("limits: {utilisation: 0.5}", "k2: 7")
    (tmp_path / "mine.yaml").write_text(text)
    warned = invoke("validate", "mine.yaml", "tour/hello")
    assert warned.exit_code == 0
    assert [line.split(":")[0] for line in warned.stdout.splitlines()] == ["mine.yaml", "tour/hello"]
    said = "law.k2 = 5.83333 is below 2 sqrt(k1) = 6.66667: the heading overshoots"
    assert warned.stderr == f"mine.yaml: warning: {said}\n"
    assert invoke("validate", "--strict", "mine.yaml", "tour/hello").exit_code == 2
    assert invoke("validate", "--strict", "tour/hello").exit_code == 0
    changed = [word for change in ("similarity.time=1", "law.kp=9", "law.kd=0.1") for word in ("--set", change)]
    assert "law.kd = 0.1 is below" in invoke("validate", "paper/example1", *changed).stderr
    for name in ("campaign/agile", "sweep/small", "tour/hello"):
        assert invoke("validate", name, "--set", "name=a/b").exit_code == 2


def test_validate_tells_that_ground_and_motors_leave_no_limits_and_what_friction_would(tmp_path: Path) -> None:
    def infeasible(friction: float) -> str:
        result = invoke("validate", "tour/universal", "--set", f"physics.friction={friction:.10f}")
        assert result.exit_code == (2 if "infeasible" in result.stderr else 0)
        return result.stderr if result.exit_code else ""

    told = infeasible(0.0)
    assert told.startswith("tour/universal: infeasible: ")
    (enough,) = re.findall(r"fits a floor without friction; (\S+) would do", told)
    assert f"{enough} would do" in infeasible(0.98 * float(enough))
    assert not infeasible(1.02 * float(enough))


def test_a_run_warns_of_its_leader_before_it_starts_and_does_not_repeat_it() -> None:
    changes = ("--set", QUICK, "--set", "duration=6", "--backend", "ideal", "--no-video", "--no-figures", "--no-report")
    result = invoke("run", "tour/universal", *changes)
    assert result.exit_code == 0
    (told,) = [line for line in result.stderr.splitlines() if "v_0 changes its sign" in line]
    assert told.startswith("warning: leader: ")
    assert "v_0 changes its sign" not in result.stdout
    assert "v_0 changes its sign" in Path("runs/universal-1/summary.json").read_text()


def test_a_law_that_is_asked_for_another_instant_than_its_commands_arrive_at_is_told(tmp_path: Path) -> None:
    hello = assets.find_scenario("tour/hello").read_text()
    (tmp_path / "late.yaml").write_text(f"{hello}delay: 3\n")
    (tmp_path / "right.yaml").write_text(f"{hello}delay: 3\n".replace("k: 6.0}", "k: 6.0, delay_periods: 3}"))
    laws = "laws: {one: {name: agile, delay_periods: 3}, two: {name: agile, delay_periods: 2}}"
    (tmp_path / "several.yaml").write_text(f"name: several\ndelay: 3\nfamilies: [rest]\n{laws}\n")
    said = invoke("validate", "late.yaml", "right.yaml", "several.yaml").stderr.splitlines()
    assert [line.partition(" and `delay` is 3: ")[0] for line in said] == [
        "late.yaml: warning: law.delay_periods is 0", "several.yaml: warning: laws.two.delay_periods is 2",
    ]  # fmt: skip


def test_schema_prints_and_writes_the_same(tmp_path: Path) -> None:
    printed = json.loads(invoke("schema").stdout)
    assert printed["title"] == "Scenario"
    assert printed["$schema"].endswith("2020-12/schema")
    assert invoke("schema", "--out", "schema.json").exit_code == 0
    assert json.loads((tmp_path / "schema.json").read_text()) == printed


def test_init_writes_a_scenario_that_runs_under_its_own_name(tmp_path: Path) -> None:
    result = invoke("init", "mine.yaml")
    assert result.exit_code == 0
    assert "nhtrack run mine.yaml" in result.stdout
    assert load("mine.yaml").name == "mine"
    assert load("mine.yaml").law.name == "agile"  # which arrives from everywhere
    assert (tmp_path / "mine.yaml").read_text().count("#") > 10


@pytest.mark.slow
@pytest.mark.parametrize(
    ("overrides", "told"),
    [
        ({"duration": 150}, ""),
        ({"duration": 600}, "60000 control periods of 64 robots: about "),
        ({"duration": 600, "record": {"every": 10}}, ""),
        ({"duration": 6000, "control_rate": 10}, "a recording of at most 2 GB; `record: {every: 10}`"),
    ],
)
def test_validate_says_how_large_a_recording_will_be(overrides: dict[str, Any], told: str, tmp_path: Path) -> None:
    tree = parse_yaml(assets.find_scenario("stress/formation64").read_text()).tree | overrides
    (tmp_path / "long.yaml").write_text(json.dumps(tree))
    warnings = [line for line in invoke("validate", "long.yaml").stderr.splitlines() if "GB" in line]
    assert len(warnings) == bool(told)
    assert all(told in line for line in warnings)


def test_init_never_replaces_a_file_unless_told(tmp_path: Path) -> None:
    (tmp_path / "scenario.yaml").write_text("precious")
    result = invoke("init")
    assert result.exit_code == 1
    assert "scenario.yaml exists" in result.stderr
    assert (tmp_path / "scenario.yaml").read_text() == "precious"
    assert invoke("init", "--force").exit_code == 0
    assert load("scenario.yaml").name == "scenario"
    assert [path.name for path in tmp_path.iterdir()] == ["scenario.yaml"]


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("my drive.csv", "t,x,y,theta\n0,1,2,0\n2,1.5,2,0\n4,2,2,0\n"),
        ("slam.tum", "# stamp, pose\n1e9 1 2 0 0 0 0 1\n1000000002 1.5 2 0 0 0 0 1\n1000000004 2 2 0 0 0 0 1\n"),
        ("fast.csv", "t,v,omega\n0,0.2,0\n4,0.3,0.1\n"),
    ],
)
def test_init_writes_a_scenario_along_a_file(tmp_path: Path, name: str, text: str) -> None:
    (tmp_path / name).write_text(text)
    (tmp_path / "in").mkdir()
    assert invoke("init", "in/mine.yaml", "--path", name).exit_code == 0
    scenario = load("in/mine.yaml")
    assert (scenario.name, scenario.duration) == ("mine", 4)
    assert isinstance(scenario.leader.input, MotionInput)
    assert scenario.leader.start.twist[0] == pytest.approx(0.2 if name == "fast.csv" else 0.25)
    assert (tmp_path / "in" / "mine.yaml").read_text().count("#") > 10


def test_init_tells_what_is_wrong_with_a_file_and_writes_nothing(tmp_path: Path) -> None:
    (tmp_path / "drive.csv").write_text("t,x,y,theta\n0,0,0,0\n1,x,0,0\n0,0,y,0\n")
    (tmp_path / "other.csv").write_text("a,b\n")
    result = invoke("init", "--path", "drive.csv")
    assert result.exit_code == 2
    assert [line.split(": ")[0] for line in result.stderr.splitlines()] == [
        f"drive.csv:{place}" for place in ("3:3", "4:1", "4:5")
    ]
    other = invoke("init", "--path", "other.csv")
    assert other.exit_code == 2
    assert "other.csv:1:1: expected the columns t, x, y, theta or t, v, omega, got a, b" in other.stderr
    assert invoke("init", "--law", "--path", "drive.csv").exit_code == 2
    assert not (tmp_path / "scenario.yaml").exists()


def test_a_place_that_cannot_be_written_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    result = invoke("init", "file/scenario.yaml")
    assert result.exit_code == 1
    assert result.stderr.startswith("error: ")
    assert len(result.stderr.splitlines()) == 1


def test_list_names_everything_there_is() -> None:
    listed = " ".join(invoke("list").stdout.split())
    for name in (*assets.bundled_scenarios(), *assets.robots()):
        assert name in listed
    assert "Paper, Example 1: a smooth trajectory, followed" in listed
    assert "Half a minute of a campaign; three laws, four references," in listed


# -- run and its exit codes ------------------------------------------------------------------------


class Runs:
    """Stands in for `nhtrack.studies.run.run`: remembers what it was asked, and ends as it is told."""

    def __init__(self, ending: BaseException) -> None:
        self.ending, self.calls = ending, list[tuple[Any, ...]]()

    def run_scenario(self, scenario: Any, out: Path | None, **options: Any) -> None:
        self.calls.append((scenario, out, options))
        raise self.ending


@pytest.mark.parametrize(
    ("ending", "code", "message"),
    [
        (SimulationDiverged("fell over", "follower", 1.25), 3, "diverged: fell over: robot 'follower' at t = 1.250 s"),
        (RobotError("no wheels"), 2, "error: no wheels"),
        (KeyboardInterrupt(), 130, "interrupted"),
        (OSError(28, "No space"), 1, "error: cannot write the output: No space left on device"),
        (PermissionError(13, "Permission denied", "runs"), 1, "error: [Errno 13] Permission denied: 'runs'"),
    ],
)
def test_errors_become_exit_codes(
    ending: BaseException, code: int, message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    study = ModuleType("nhtrack.studies.run.run")
    study.run_scenario = Runs(ending).run_scenario  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "nhtrack.studies.run.run", study)
    result = invoke("run", "tour/hello")
    assert result.exit_code == code
    assert result.stderr.strip().startswith(message)
    assert "Traceback" not in result.output


def test_run_passes_on_what_it_was_asked(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    runs = Runs(RobotError("stop"))
    monkeypatch.setitem(sys.modules, "nhtrack.studies.run.run", SimpleNamespace(run_scenario=runs.run_scenario))
    options = ["--no-video", "--no-figures", "--pdf", "--no-report", "--force", "--out", "there", "--seed", "7"]
    invoke("run", "tour/hello", *options, "--backend", "ideal", "--set", "law.kp=3", "--set", "physics.friction=0.5")
    ((scenario, out, asked),) = runs.calls
    assert (scenario.seed, scenario.backend, scenario.law.kp, scenario.physics.friction) == (7, "ideal", 3.0, 0.5)
    assert out == Path("there")
    assert {name: asked[name] for name in ("overwrite", "figures", "pdf", "video", "report")} == {
        "overwrite": True, "figures": False, "pdf": True, "video": False, "report": False,
    }  # fmt: skip


@pytest.mark.slow
def test_a_run_leaves_a_recording_that_reproduces_it(tmp_path: Path) -> None:
    quiet = ["--no-video", "--no-figures", "--no-report"]
    first = invoke("run", "tour/hello", *quiet, "--set", "duration=0.5")
    assert first.exit_code == 0, first.output
    assert "wrote runs/hello-1/recording.nc" in first.stdout
    assert invoke("run", "runs/hello-1/recording.nc", *quiet).exit_code == 0
    one, two = (Recording.load(f"runs/hello-{n}/recording.nc") for n in (1, 2))
    assert one.dataset.identical(two.dataset)
    again = invoke("run", "tour/hello", *quiet, "--out", "runs/hello-1")
    assert again.exit_code == 1
    assert "--force" in again.stderr
