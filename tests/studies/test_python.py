"""Python does what the command line does: the same numbers, files and messages; results show themselves."""

from __future__ import annotations

import dataclasses
import json
import pickle
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import nhtrack
from commands import invoke
from nhtrack import assets
from nhtrack.config.changes import overrides_of
from nhtrack.errors import RenderError
from nhtrack.files.folder import OutputError
from nhtrack.presentation.notebook import NotebookView, html_of
from nhtrack.presentation.result_table import ResultTable, TableRow
from nhtrack.studies.compare.result import Comparison
from nhtrack.studies.run.result import DivergedError, Outcome
from reports import CASE as DIVERGING
from reports import WILD

CASE = """\
name: case
duration: 1
leader: {start: {pose: [0, 0, 0]}, input: {u_x: 0.1, u_theta: "0.2*cos(t)"}}
followers: [{name: follower, parents: [leader], start: {pose: [-0.5, 0.1, 0]}}]
law: {name: published, kp: 1, kd: 2.5, ke: 0.5, k: 5}
"""
NASTY = CASE.replace("name: case", "name: case\ndescription: '<script>alert(1)</script> & <b>'")
LAW = Path(__file__).parents[2] / "examples/write_a_law/my_law.py"
FEW = {
    "families": ["rest"],
    "laws": {"samson": {"name": "samson"}},
    "starts.count": 4,
    "duration": 5,
    "arrival.last": 1,
    "tuning": None,
}
BURGER = assets.find_robot("burger")
PLAIN = ("--no-video", "--no-figures", "--no-report")


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of one's own, with a scenario file in it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "case.yaml").write_text(CASE)
    return tmp_path


def same(one: Any, other: Any) -> bool:
    """Returns whether values are equal, however JSON wrote them."""
    return bool(json.loads(json.dumps(one)) == json.loads(json.dumps(other)))


# -- the same numbers, the same files ---------------------------------------------------------------


@pytest.mark.slow
def test_run_is_what_the_command_writes(here: Path) -> None:
    options = ("--backend", "ideal", "--seed", 3, "--set", "law.k=6", "--set", "duration=2")
    assert invoke("run", "case.yaml", *options, *PLAIN, "--out", "cli").exit_code == 0
    run = nhtrack.run("case.yaml", backend="ideal", seed=3, duration=2, set={"law.k": 6})
    written = nhtrack.Recording.load("cli/recording.nc")
    assert run.recording.dataset.identical(written.dataset)
    assert same(run.summary, json.loads(Path("cli/summary.json").read_text()))
    assert [path.name for path in here.iterdir() if path.is_dir()] == ["cli"]
    made = nhtrack.run(written, out="python", figures=False, video=False, report=False)
    assert [path.as_posix() for path in made.files] == ["python/recording.nc", "python/summary.json"]
    assert Path("python/recording.nc").read_bytes() == Path("cli/recording.nc").read_bytes()


@pytest.mark.slow
def test_compare_is_what_the_command_writes() -> None:
    options = ("--backend", "ideal", "--tune", 8, "--set", "law.k=6")
    done = invoke("compare", "case.yaml", "samson", LAW, *options, *PLAIN, "--out", "cli")
    assert done.exit_code == 0, done.output
    found = nhtrack.compare("case.yaml", ["samson", LAW], tune=8, backend="ideal", set=["law.k=6"])
    assert same(found.tree, json.loads(Path("cli/comparison.json").read_text()))
    assert found.folder is None
    assert found.files == ()
    for law, run in found.recordings.items():
        assert run.dataset.identical(nhtrack.Recording.load(f"cli/{law}/recording.nc").dataset)


def test_tune_writes_the_copy_that_the_command_writes() -> None:
    wanted = ("--objective", "late=1,settling=1", "--budget", 16, "--seed", 2, "--set", "duration=3")
    assert invoke("tune", "case.yaml", *wanted, "--out", "cli.yaml").exit_code == 0
    found = nhtrack.tune("case.yaml", "late=1,settling=1", 16, 2, duration=3, out="python.yaml")
    assert Path("python.yaml").read_text() == Path("cli.yaml").read_text()
    assert nhtrack.load("python.yaml").law == found.scenario.law


def test_feasibility_and_inspect_are_what_the_commands_print() -> None:
    printed = invoke("feasibility", "case.yaml", "--json", "--set", "physics.friction=0.1")
    assert same(nhtrack.feasibility("case.yaml", set={"physics.friction": 0.1}).table, json.loads(printed.stdout))
    printed = invoke("inspect", "burger", "--json", "--friction", 0.5)
    assert same(nhtrack.inspect("burger", friction=0.5).summary, json.loads(printed.stdout))
    burger = nhtrack.inspect("burger")
    assert {each.name: each.value for each in burger.properties}["wheel radius"] == 0.033
    assert burger.path == BURGER
    shown = invoke("inspect", "burger").stdout
    assert all(words in shown for words in ("wheel radius", "33 mm", "motion limits", "joint 'left_wheel' (line"))


def test_limits_of_motion_grow_with_friction_and_end_where_there_is_none() -> None:
    slippery, rough = (nhtrack.inspect("nh_mini", friction=friction).limits for friction in (0.2, 0.8))
    assert slippery is not None
    assert rough is not None
    assert slippery.yaw_rate < rough.yaw_rate
    none = nhtrack.inspect("nh_mini", friction=0.0)
    assert none.limits is None
    assert "motion limits" not in {each.part for each in none.properties}
    assert any(note.startswith("no limits of motion: at ") for note in none.notes)


@pytest.mark.slow
def test_campaign_is_what_the_command_writes_and_goes_on() -> None:
    changes = [word for text in overrides_of(set=FEW) for word in ("--set", text)]
    done = invoke("campaign", "campaign/small", *changes, "--processes", 1, "--out", "cli", *PLAIN[1:])
    assert done.exit_code == 0, done.output
    found = nhtrack.campaign("campaign/small", set=FEW, processes=1, out="python")
    pd.testing.assert_frame_equal(found.runs, pd.read_parquet("cli/runs.parquet"))
    assert Path("python/cells.csv").read_bytes() == Path("cli/cells.csv").read_bytes()
    again = nhtrack.campaign("campaign/small", set=FEW, processes=1, out="python", progress=_never_more)
    pd.testing.assert_frame_equal(again.runs, found.runs)
    with pytest.raises(nhtrack.NhtrackError, match="python holds another campaign"):
        nhtrack.campaign("campaign/small", set=FEW | {"starts.count": 5}, processes=1, out="python")
    share = found.cells.iloc[0]
    shown = text_of(found)
    assert f"{share['converged']} of 4" in shown
    assert f"{100 * share['share_high']:.1f}".rstrip("0").rstrip(".") in shown


def _never_more(stage: str, done: int, total: int) -> None:
    assert stage != "runs"


@pytest.mark.slow
def test_plot_draws_what_run_draws(here: Path) -> None:
    made = nhtrack.run("case.yaml", backend="ideal", out="made", video=False, report=False)
    assert invoke("plot", "made/recording.nc", "--out", "again").exit_code == 0
    names = {path.name for path in Path("made/figures").iterdir()}
    assert names == {path.name for path in Path("again").iterdir()}
    assert all(Path("again", name).read_bytes() == Path("made/figures", name).read_bytes() for name in names)
    drawn = nhtrack.plot(made, "errors")
    assert list(drawn.figures) == ["errors"]
    assert drawn.save(here / "one")[0].read_bytes() == Path("made/figures/errors.png").read_bytes()
    assert text_of(drawn).startswith("case")


# -- changes ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "key", "value"),
    [
        ({"law": "kanayama"}, "law.name", "kanayama"),
        ({"law": "published"}, "law.k", 5.0),  # the scenario's own gains
        ({"law": {"name": "kanayama", "k_x": np.float64(2)}}, "law.k_x", 2.0),
        ({"law": LAW}, "law.file", str(LAW)),
        ({"law": {"file": LAW, "k_x": 3}}, "law.k_x", 3.0),
        ({"robot": "burger"}, "robot.file", "burger"),
        ({"robot": BURGER}, "robot.file", str(BURGER)),
        ({"duration": 3}, "duration", 3.0),
        ({"backend": "ideal", "set": {"backend": "mujoco"}}, "backend", "ideal"),  # keywords win
        ({"set": {"name": "0123"}}, "name", "0123"),
        ({"set": {"description": "a: [b"}}, "description", "a: [b"),
        ({"set": {"physics.friction": 1e-5}}, "physics.friction", 1e-5),
        ({"set": "seed=4"}, "seed", 4),
        ({"set": ["seed=4", "law.kp=2"]}, "law.kp", 2.0),
        ({"set": {"leader.start.pose": np.array([1.0, 2.0, 3.0])}}, "leader.start.pose", (1.0, 2.0, 3.0)),
    ],
)
def test_changes_are_made_before_anything_is_judged(changes: dict[str, Any], key: str, value: object) -> None:
    for source in ("case.yaml", nhtrack.load("case.yaml"), CASE):
        found: Any = nhtrack.load(source, **changes)
        for step in key.split("."):
            found = getattr(found, step)
        assert found == value


@pytest.mark.slow
def test_the_command_line_names_laws_likewise(here: Path) -> None:
    (here / "law.py").write_text(LAW.read_text())
    for law, name in (("samson", "samson"), ("law.py", "law")):
        done = invoke("run", "case.yaml", "--set", f"law={law}", "--backend", "ideal", *PLAIN, "--out", law[:3])
        assert done.exit_code == 0, done.output
        assert nhtrack.Recording.load(f"{law[:3]}/recording.nc").scenario.law.name == name


@pytest.mark.parametrize(
    ("changes", "arguments"),
    [
        ({"law": "kanyama"}, ["law=kanyama"]),
        ({"set": {"duratio": 3}}, ["duratio=3"]),
        ({"duration": -1, "robot": "burgr"}, ["robot=burgr", "duration=-1"]),
        ({"set": {"followers[3].name": "a"}}, ["followers[3].name=a"]),
        ({"law": {"name": "samson", "k_x": 1}}, ['law={"name": "samson", "k_x": 1}']),
        ({"law": "nowhere.py"}, ["law=nowhere.py"]),
    ],
)
def test_what_is_wrong_is_said_as_on_the_command_line(changes: dict[str, Any], arguments: list[str]) -> None:
    words = [word for text in arguments for word in ("--set", text)]
    printed = invoke("run", "case.yaml", *words)
    assert printed.exit_code == 2
    for work in (nhtrack.run, nhtrack.feasibility, nhtrack.tune, nhtrack.load):
        with pytest.raises(nhtrack.ScenarioError) as caught:
            work("case.yaml", **changes)
        assert str(caught.value) == printed.stderr.strip()
    assert arguments[-1] in printed.stderr


def test_other_errors_are_those_of_the_command_line(here: Path) -> None:
    def said(*arguments: object) -> str:
        return invoke(*arguments).stderr.strip().removeprefix("error: ").removeprefix("infeasible: ")

    def raised(work: Any, *arguments: object, **keywords: Any) -> str:
        with pytest.raises(nhtrack.NhtrackError) as caught:
            work(*arguments, **keywords)
        return str(caught.value)

    hopeless = {"set": {"physics.friction": 0, "similarity.time": "auto"}}
    assert raised(nhtrack.run, "case.yaml", **hopeless) == said(
        "run", "case.yaml", "--set", "physics.friction=0", "--set", "similarity.time=auto", *PLAIN
    )
    assert raised(nhtrack.inspect, "burgr") == said("inspect", "burgr")
    assert raised(nhtrack.run, "case.yaml", out=".") == said("run", "case.yaml", "--out", ".")
    assert raised(nhtrack.tune, "case.yaml", out="case.yaml") == said("tune", "case.yaml", "--out", "case.yaml")
    told = said("tune", "case.yaml", "--set", "law=samson", "--out", "a.yaml")
    assert raised(nhtrack.tune, "case.yaml", law="samson", out="a.yaml") == told
    assert raised(nhtrack.plot, "none.nc") == said("plot", "none.nc") == "none.nc: no such recording"
    assert "did you mean 'errors'" in raised(nhtrack.plot, "none.nc", "error")
    assert "did you mean 'late'" in raised(nhtrack.tune, "case.yaml", objective="lat")
    assert "add --tune N" in raised(nhtrack.compare, "case.yaml", "samson", objective="late")
    assert "at least 8" in raised(nhtrack.compare, "case.yaml", "samson", tune=4)
    assert "nothing to compare" in raised(nhtrack.compare, "case.yaml", "published")
    assert "into a copy of a file" in raised(nhtrack.tune, CASE, out="a.yaml")
    (fault,) = nhtrack.validate(here / "case.yaml") or nhtrack.validate("nowhere.yaml")
    assert fault.message.startswith("no such file")
    with pytest.raises(TypeError, match="'lawn'"):
        nhtrack.run("case.yaml", lawn="samson")  # type: ignore[call-arg]
    assert list(here.iterdir()) == [here / "case.yaml"]


@pytest.mark.slow
def test_a_run_that_diverges_raises_and_holds_what_it_recorded() -> None:
    with pytest.raises(DivergedError) as caught:
        nhtrack.run(DIVERGING, law=WILD)
    error = caught.value
    assert isinstance(error, nhtrack.SimulationDiverged)
    assert 0 < error.outcome.recording.time[-1] < error.outcome.recording.scenario.duration
    assert str(error) == str(error.outcome.failure)
    assert "No pictures: the run diverged." in text_of(error.outcome)
    assert str(pickle.loads(pickle.dumps(error))) == str(error)


# -- what notebooks show ----------------------------------------------------------------------------


class Page(HTMLParser):
    """Reads a fragment: its text, its pictures, and that every element is closed where it ought to be."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.text, self.pictures, self.open = list[str](), list[str](), list[str]()
        self.tags = set[str]()
        self.feed(html)
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        given = dict(attrs)
        if tag == "img":
            assert given["alt"]
            self.pictures.append(str(given["src"]).split(",")[0])
        else:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if "style" not in self.open:
            self.text.append(data)


def page_of(result: Any) -> Page:
    return Page(result._repr_html_())


def text_of(result: Any) -> str:
    return " ".join(" ".join(page_of(result).text).split())


@pytest.fixture(scope="module")
def run() -> Outcome:
    return nhtrack.run(NASTY, backend="ideal")


@pytest.mark.slow
def test_a_run_and_its_recording_show_drawings_and_figures(run: Outcome, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("nhtrack.video.stills.FrameRenderer", _no_gl)
    shown = text_of(run)
    figures = run.summary["followers"]["follower"]
    assert f"{1e3 * figures['late_position_error']:.3g} mm" in shown
    assert "No pictures: no off-screen OpenGL." in shown
    assert page_of(run).pictures == 2 * ["data:image/svg+xml;base64"]
    assert text_of(run.recording) == shown.partition(" Warnings ")[0]  # what is told before a run is not in its rows


def _no_gl(*_: object) -> None:
    raise RenderError("no off-screen OpenGL")


@pytest.mark.render
@pytest.mark.slow
def test_a_run_shows_pictures_from_its_beginning_to_its_end(run: Outcome) -> None:
    page = page_of(run)
    assert page.pictures == 5 * ["data:image/jpeg;base64"] + 2 * ["data:image/svg+xml;base64"]
    assert re.search(r"0 s .*0\.5 s .*1 s", " ".join(page.text), re.DOTALL)
    film = nhtrack.render(run, "film.mp4", size=(160, 120), quality="draft", processes=1)
    assert "data:video/mp4;base64," in film._repr_html_()
    with pytest.raises(OutputError, match=r"film\.mp4 exists"):
        nhtrack.render(run, "film.mp4")


@pytest.mark.slow
def test_a_scenario_shows_robots_law_reference_and_physics() -> None:
    shown = text_of(nhtrack.load(CASE, set={"physics.slope.angle": 0.25}))
    for words in ("follower tracks leader", "-0.5, 0.1, 0", "kp 1 position gain", "0.2*cos(t)", "slope angle 0.25"):
        assert words in shown
    assert "who tracks whom" not in shown
    assert page_of(nhtrack.load("paper/example4")).pictures == ["data:image/svg+xml;base64"]
    assert "timed poses the leader's input until 34" in text_of(nhtrack.load("tour/trajectory"))  # not its 341 rows
    assert "input a path the leader's input duration" in text_of(nhtrack.load("tour/lemniscate"))


@pytest.mark.slow
def test_studies_show_their_tables() -> None:
    compared: Comparison = nhtrack.compare(CASE, "samson", backend="ideal", tune=8)
    shown = page_of(compared)
    assert shown.pictures == ["data:image/svg+xml;base64"]
    assert re.search(r"law\s+late.*published.*samson.*Tuned: samson", " ".join(shown.text), re.DOTALL)
    tuned = compared.tunings["samson"]
    for name, gain in tuned.gains.items():
        assert f"{name} {tuned.gains_before[name]:g} {gain:g}" in text_of(tuned)
    found = nhtrack.feasibility(CASE)
    assert found.verdict in text_of(found)
    assert page_of(nhtrack.inspect("burger")).pictures == ["data:image/svg+xml;base64", "data:image/png;base64"]


@pytest.mark.slow
def test_what_users_wrote_is_escaped(run: Outcome, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("nhtrack.video.stills.FrameRenderer", _no_gl)
    for result in (nhtrack.load(NASTY), nhtrack.compare(NASTY, "samson", backend="ideal"), run):
        assert "script" not in page_of(result).tags
    nasty = "<script>alert(1)</script>"
    table = ResultTable(nasty, (nasty,), (TableRow((nasty,), "fault", frozenset({0})),), notes=(nasty,))
    view = NotebookView(nasty, nasty, tiles=[(nasty, nasty)], tables=[table], notes=[nasty], folded=[(nasty, [nasty])])
    assert "<script" not in html_of(view)
    assert html_of(view).count("&lt;script&gt;") == 11


@pytest.mark.parametrize("kind", ["Outcome", "Comparison", "Tuning", "Feasibility", "Inspection"])
def test_results_are_frozen_and_say_what_they_are_in_a_line(kind: str, run: Outcome) -> None:
    results = {
        "Outcome": lambda: run,
        "Comparison": lambda: nhtrack.compare(CASE, "samson", backend="ideal"),
        "Tuning": lambda: nhtrack.tune(CASE, budget=8),
        "Feasibility": lambda: nhtrack.feasibility(CASE),
        "Inspection": lambda: nhtrack.inspect("pioneer"),
    }
    result: Any = results[kind]()
    assert repr(result).startswith(f"{kind}(")
    assert len(repr(result)) < 200
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(result, dataclasses.fields(result)[0].name, None)
