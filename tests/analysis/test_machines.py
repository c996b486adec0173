"""Machines that work for this one: files travel with tasks, and what is not the same is told before any is done."""

from __future__ import annotations

import os
import sys
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path

import pandas as pd
import pytest

from nhtrack.analysis import machines, sources
from nhtrack.analysis.account import account_of, held_account
from nhtrack.analysis.machines import MachineError, ready
from nhtrack.config.sweep import Sweep
from nhtrack.execution import Executor, Processes, Serial, serial
from nhtrack.execution.contract import Done, Result, Task
from nhtrack.experiment.load import load, load_campaign, load_sweep
from nhtrack.files.carried import carried
from nhtrack.files.folder import save_json
from nhtrack.laws import law_in
from nhtrack.robots.reading.companions import files_of
from nhtrack.studies.campaign.run import CampaignError, run_campaign
from nhtrack.studies.fidelity.bench import Bench
from nhtrack.studies.fidelity.suite import run_suite, tasks
from nhtrack.studies.sweep.run import plan_of, run_sweep
from nhtrack.studies.tune.run import find_gains
from odd_robots.on_disk import shell, urdf, written
from odd_robots.plain import add, plain_robot, section, text_of

LAW = Path(__file__).parents[1] / "own_laws" / "spring.py"
PICTURE = bytes.fromhex(
    "89504e470d0a1a0a0000000d4948445200000001000000010802000000907753de0000000c4944415478da63f8cfc0000003010100f7034143"
    "0000000049454e44ae426082"
)
SWEEP = """\
name: case
base: paper/example1
set: {duration: 0.2, leader.virtual: true, law: {file: spring.py, k: 0.05, d: 0.2}}
axes:
  robot: [plain/plain.xml, {file: cart_description/urdf/cart.urdf, wheels: [left_axle, right_axle]}]
  law.file: [spring.py, pull.py]
  leader.input: [{csv: a.csv}, {csv: b.csv}]
metrics: [late_position_error, gap_position_rms, effort_x, path_length]
"""
CAMPAIGN = """\
name: case
duration: 4
backend: mujoco
robot: plain/plain.xml
similarity: {length: 0.1, time: 4}
laws: {spring: {file: spring.py}, k: {name: kanayama}}
families: [sinus]
starts: {count: 2, seed: 3}
arrival: {last: 1}
tuning: {laws: [k], budget: 8, starts: 2}
"""


class Elsewhere(Serial):
    """Works on another machine, which has what `change` makes of this one's."""

    elsewhere = True

    def __init__(self, change: Callable[..., tuple[machines._Facts, bool]]) -> None:
        self._change = change

    def everywhere(self, work: Callable[[], Result]) -> list[tuple[str, Result]]:
        return [("10.0.0.2", self._change(*work()))]  # type: ignore[list-item,misc]


class Away(Executor):
    """Works in processes that find some folders gone, as another machine would."""

    workers = 2
    elsewhere = True

    def __init__(self, *folders: Path) -> None:
        self._folders = folders

    @contextmanager
    def _gone(self) -> Iterator[None]:
        hidden = {folder: folder.with_name(f"gone-{folder.name}") for folder in self._folders}
        for folder, other in hidden.items():
            folder.rename(other)
        try:
            yield
        finally:
            for folder, other in hidden.items():
                other.rename(folder)

    def __call__(self, tasks: Sequence[Task], work: Callable[[Task], Result]) -> Done[Result]:
        with self._gone():
            yield from Processes(2)(tasks, work)

    def survived(self, tasks: Sequence[Task], work: Callable[[Task], Result]) -> Done[bool]:
        with self._gone():
            yield from Processes(2).survived(tasks, work)

    def everywhere(self, work: Callable[[], Result]) -> list[tuple[str, Result]]:
        with self._gone():
            return [("10.0.0.2", work())]


def with_mesh(
    folder: Path,
    meshes: str = "stl",
    pictures: str = "pics",
    include: str = "parts/assets.xml",
    *,
    within: bool = False,
) -> Path:
    """Returns the file of a plain robot with a mesh and a picture, which a file that it includes names, if any."""
    robot, folders = plain_robot(), {"meshdir": meshes, "texturedir": pictures}
    if not within:
        robot.insert(0, robot.makeelement("compiler", folders))
    shell(folder / meshes, "shell.stl")
    (folder / pictures).mkdir()
    (folder / pictures / "wood.png").write_bytes(PICTURE)
    assets = '<mesh file="shell.stl"/><texture name="wood" type="2d" file="wood.png"/>'
    assets += '<material name="wood" texture="wood"/>'
    for each in ET.fromstring(f"<asset>{assets}</asset>") if not include else ():
        section(robot, "asset").append(each)
    if include:
        head = f'<compiler meshdir="{meshes}" texturedir="{pictures}"/>' if within else ""
        assets = f"{head}<asset>{assets}</asset>"
        written(folder, "parts/assets.xml", f"<mujocoinclude>{assets}</mujocoinclude>")
        add(robot, f'<include file="{include}"/>')
    drawn = '<geom type="mesh" mesh="shell" material="wood" mass="0" contype="0" conaffinity="0"/>'
    add(next(robot.iter("body")), drawn)
    return written(folder, "plain.xml", text_of(robot))


def cart(folder: Path, mesh: str = "package://cart_description/meshes/shell.stl") -> Path:
    """Returns a URDF with a mesh, of its package unless told otherwise."""
    shell(folder, "meshes/shell.stl")
    text = urdf().replace("package://cart_description/meshes/shell.stl", mesh)
    return written(folder, "urdf/cart.urdf", text)


def alone(folder: Path) -> Path:
    """Returns a folder with one robot, a scene around it, and a name that is no text."""
    file = with_mesh(folder, include="")
    Path(os.fsdecode(os.fsencode(folder) + b"/gr\xf6\xdfe.xml")).write_text("<include/>")
    written(folder, "scene.xml", f'<mujoco><include file="{file.name}"/></mujoco>')
    return folder


ROBOTS: dict[str, Callable[[Path], Path]] = {
    "folders": with_mesh,
    "folders of an include": lambda folder: with_mesh(folder, "stl", "pics", "parts/assets.xml", within=True),
    "full paths": lambda folder: with_mesh(folder, str(folder / "a" / "stl"), str(folder / "b"), ""),
    "package": lambda folder: cart(folder / "cart_description"),
    "file": lambda folder: cart(folder, f"file://{folder}/meshes/shell.stl"),
    "a folder": alone,
}


@pytest.fixture
def own(tmp_path: Path) -> Path:
    """Returns a folder with laws, robots and tables, and with a sweep and a campaign of them."""
    folder = tmp_path / "own"
    folder.mkdir()
    with_mesh(folder / "plain")
    cart(folder / "cart_description")
    (folder / "spring.py").write_text(LAW.read_text())
    (folder / "pull.py").write_text(LAW.read_text().replace("gains.k * ", "2 * gains.k * "))
    for name, speed in (("a", 0.1), ("b", 0.2)):
        (folder / f"{name}.csv").write_text(f"t,u_x,u_theta\n0,{speed},0\n1,0,{speed}\n")
    (folder / "sweep.yaml").write_text(SWEEP)
    (folder / "campaign.yaml").write_text(CAMPAIGN)
    return folder


def sweep_in(folder: Path) -> Sweep:
    return load_sweep(folder / "sweep.yaml")


@pytest.mark.parametrize("make", ROBOTS.values(), ids=list(ROBOTS))
def test_a_robot_is_the_same_by_its_copies_and_another_by_any_other_byte(
    make: Callable[[Path], Path], tmp_path: Path
) -> None:
    folder = tmp_path / "robots"
    folder.mkdir()
    robot = make(folder)
    known, outline, files = sources.fingerprint(str(robot)), sources.outline(str(robot)), files_of(robot)
    assert "[" in outline
    assert files >= {each for each in folder.rglob("*") if each.is_file()}
    copies = carried(files)
    for away in (Away(folder), Away()):
        with away._gone(), copies.here():
            assert (sources.fingerprint(str(robot)), sources.outline(str(robot))) == (known, outline)
    assert sources.fingerprint(str(robot)) == known
    for file in sorted(files):
        before = file.read_bytes()
        file.write_bytes(before + b" ")
        assert sources.fingerprint(str(robot)) != known, file
        file.write_bytes(before)
    folder.rename(tmp_path / "elsewhere")
    assert not sources.fingerprint(str(robot))


@pytest.mark.slow
def test_studies_come_to_the_same_where_files_are_not_there(
    own: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    away = Away(own)
    runs = [run_sweep(sweep_in(own), tmp_path / f"s{k}", executor=by).runs for k, by in enumerate((serial, away))]
    pd.testing.assert_frame_equal(*runs, check_exact=True)
    assert set(runs[0]["outcome"]) == {"completed"}
    assert runs[0]["late_position_error"].nunique() == 8
    campaign = load_campaign(own / "campaign.yaml")
    tables = [run_campaign(campaign, tmp_path / f"c{k}", executor=by).runs for k, by in enumerate((serial, away))]
    pd.testing.assert_frame_equal(*tables, check_exact=True)
    searched = LAW.read_text().replace("k: float", 'k: Annotated[float, Gain("1/T^2", "pull", search=(1, 9))]')
    searched = searched.replace("import NamedTuple", "import Annotated, NamedTuple")
    (own / "searched.py").write_text(searched.replace("import Follower,", "import Follower, Gain,"))
    law, robot = f"law={{file: {own / 'searched.py'}}}", f"robot={own / 'plain' / 'plain.xml'}"
    scenario = load("tour/hello", [law, robot, "duration=5"])
    gains = [find_gains(scenario, budget=9, executor=by, below_bound=True).gains for by in (serial, away)]
    assert gains[0] == gains[1]
    wanted = tasks(["own/plain/plain.xml"], ["load_shares", "creep"])
    found = run_suite(wanted, executor=away)
    assert found == run_suite(wanted, executor=serial)
    assert {finding.robot for finding in found} == {"own/plain/plain.xml"}


def test_a_row_names_the_file_and_not_its_copy(tmp_path: Path) -> None:
    folder = tmp_path / "own"
    robot = text_of(plain_robot())
    written(folder, "a.xml", robot.replace("</mujoco>", '<keyframe><key name="low"/></keyframe></mujoco>'))
    written(folder, "b.xml", robot)
    axes = "axes: {robot.file: [a.xml, b.xml], robot.pose: ['', low]}"
    changes = "set: {duration: 0.1, leader.virtual: true, robot: {file: a.xml}, backend: ideal}"
    written(folder, "sweep.yaml", f"name: case\nbase: paper/example1\n{changes}\n{axes}\nmetrics: [path_length]\n")
    executors = enumerate((serial, Away(folder)))
    runs = [run_sweep(sweep_in(folder), tmp_path / f"{k}", executor=by).runs for k, by in executors]
    pd.testing.assert_frame_equal(*runs, check_exact=True)
    assert list(runs[1]["outcome"]) == ["completed"] * 3 + ["failed"]
    assert f"robot.file: {folder}/b.xml: no key 'low'" in runs[1]["reason"][3]


def test_a_campaign_goes_on_with_the_same_files_only(own: Path, tmp_path: Path) -> None:
    (own / "campaign.yaml").write_text(CAMPAIGN.replace("mujoco", "ideal").partition("tuning")[0])
    campaign = load_campaign(own / "campaign.yaml")
    run_campaign(campaign, tmp_path / "out", executor=serial)
    shell(own / "plain" / "stl", "shell.stl", 2.0)
    with pytest.raises(CampaignError, match=r"What is not the same:\n  .*plain\.xml has changed$"):
        run_campaign(campaign, tmp_path / "out", executor=serial)
    with pytest.raises(CampaignError, match=r"tuned for something else: .*plain\.xml differ"):
        run_campaign(campaign, tmp_path / "other", executor=serial, tuned_by=tmp_path / "out")


@pytest.mark.parametrize(
    ("leader", "axis"),
    [
        ("leader.virtual: true", "leader.input: [{csv: a.csv}]"),
        ("leader.virtual: true, leader.input: {csv: b.csv}", "leader.input.csv: [a.csv]"),
        ("duration: 1", "leader: {choices: {a: {input: {csv: a.csv}, virtual: true}}}"),
    ],
)
def test_tables_of_an_axis_are_known_wherever_they_are_named(leader: str, axis: str, own: Path) -> None:
    text = f"name: case\nbase: paper/example1\nset: {{{leader}}}\naxes: {{{axis}}}\nmetrics: [path_length]\n"
    (own / "sweep.yaml").write_text(text)
    assert str(own / "a.csv") in plan_of(sweep_in(own)).files


def test_includes_that_go_round_come_to_an_end(tmp_path: Path) -> None:
    for folder in "xy":
        (tmp_path / folder).mkdir()
    names = [f'<include file="{name}"/>' for name in ("a.xml", "x/../a.xml", "y/../b.xml", "b.xml")]
    files = {written(tmp_path, name, f"<mujoco>{''.join(names)}</mujoco>") for name in ("a.xml", "b.xml")}
    assert files_of(tmp_path / "a.xml") == files


def test_a_robot_is_measured_as_it_is(tmp_path: Path) -> None:
    robot = with_mesh(tmp_path)
    first = Bench(str(robot)).drive
    assert Bench(str(robot)).drive == first
    robot.write_text(robot.read_text().replace('mass="2"', 'mass="3"'))
    assert Bench(str(robot)).drive.mass == pytest.approx(first.mass + 1)


def test_what_a_killed_run_left_is_gone_when_its_folder_is_gone_on_with(tmp_path: Path) -> None:
    asked, left = account_of({}, asked={"a": 1}), tmp_path / "parts" / ".nhtrack-0123"
    save_json(tmp_path / "sweep.json", asked)
    left.mkdir(parents=True)
    assert held_account(tmp_path / "sweep.json", "sweep", asked) == (asked, "")
    assert not left.exists()


@pytest.mark.parametrize("text", ["[]", "3", "{", "null"])
def test_an_account_that_is_none_is_told(text: str, tmp_path: Path) -> None:
    written(tmp_path, "sweep.json", text)
    _, why = held_account(tmp_path / "sweep.json", "sweep", account_of({}, asked={"a": 1}))
    assert "choose another --out" in why


def test_what_is_too_much_is_not_sent(own: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machines, "_MOST_SENT", 500)
    with pytest.raises(MachineError) as refused:
        run_sweep(sweep_in(own), tmp_path / "out", executor=Away(own))
    lines = str(refused.value).splitlines()
    assert len(lines) == 6
    assert lines[0].endswith("a.csv is not there: more than 0.0005 MB in all are not sent along")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("meshes", "include"), [("stl", "{}/parts/assets.xml"), ("{}/stl", "parts/assets.xml")])
def test_a_copy_that_does_not_find_a_file_is_refused(meshes: str, include: str, tmp_path: Path) -> None:
    folder = tmp_path / "robots"
    folder.mkdir()
    robot = with_mesh(folder, meshes.format(folder), include=include.format(folder))
    with pytest.raises(MachineError, match=r"plain\.xml is another there: its copy does not find all files"):
        ready(Away(folder), None, {"robot": str(robot)})


def test_a_law_that_cannot_be_imported_there_is_told(
    own: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    law, library = own / "spring.txt", tmp_path / "library"
    future = "from __future__ import annotations\n"
    law.write_text(LAW.read_text().replace(future, f"{future}import shared_gains_of_mine\n"))
    written(library, "shared_gains_of_mine.py", "")
    monkeypatch.syspath_prepend(str(library))
    import_module("shared_gains_of_mine")  # so that Python knows the folder
    monkeypatch.delitem(sys.modules, "shared_gains_of_mine")
    with pytest.raises(MachineError, match=r"^10\.0\.0\.2: .*spring\.txt:4: ModuleNotFoundError"):
        ready(Away(library), None, {"law": {"file": str(law)}})


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda facts, writes: (facts, False), "cannot write into"),
        (lambda facts, writes: (facts._replace(package=""), writes), "has other sources of nhtrack"),
        (lambda facts, writes: (facts._replace(versions={"numpy": "1"}), writes), "has numpy 1, this machine has 2"),
        (lambda facts, writes: (facts._replace(sources={"pid": ("", "")}), writes), "law pid is not"),
        (lambda facts, writes: (facts._replace(sources={"pid": ("0", "")}), writes), "pid is another"),
    ],
)
def test_machines_that_are_not_like_this_one_are_refused(
    change: Callable[..., tuple[machines._Facts, bool]], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sources, "laws", lambda: {"pid": law_in(LAW)})
    with pytest.raises(MachineError, match=rf"(?s)^10\.0\.0\.2: .*{said}"):
        ready(Elsewhere(change), tmp_path / "out", {"law": {"name": "pid"}})
    assert not list(tmp_path.iterdir())


def test_machines_like_this_one_are_taken(tmp_path: Path) -> None:
    ready(Elsewhere(lambda *same: same), tmp_path / "out", {"law": [str(LAW)]})
    assert ready(serial, None, {"law": [str(LAW)]}) is serial
