"""What `nhtrack inspect` says of a robot's file, its picture, and the scenario it starts."""

from __future__ import annotations

import json
from itertools import combinations
from pathlib import Path

import mujoco
import numpy as np
import pytest
from matplotlib.figure import Figure

import nhtrack
from commands import invoke
from nhtrack import assets
from nhtrack.errors import RefusedError, RenderError, RobotError
from nhtrack.robots.contract import RefusedRobot
from nhtrack.robots.reading.shapes import outline
from nhtrack.simulation.robot_models import load_robot
from nhtrack.studies.inspect.figure import robot_figure
from nhtrack.studies.inspect.silhouette import ABOVE, SIDE, silhouettes
from odd_robots.plain import HALF_SEPARATION, RADIUS, part, plain_robot, section, text_of

COUPLED = {"joint1": "left_axle", "joint2": "right_axle", "name": "shaft"}


@pytest.fixture
def robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The file of the plain robot, in the folder one is in."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "plain.xml").write_text(text_of(plain_robot()), encoding="utf-8")
    return Path("plain.xml")


@pytest.fixture
def refused(tmp_path: Path) -> Path:
    """The file of a robot that has two faults."""
    tree = plain_robot()
    part(tree, "left_axle").attrib.update(stiffness="1")
    section(tree, "equality").append(plain_robot().makeelement("joint", COUPLED))
    file = tmp_path / "refused.xml"
    file.write_text(text_of(tree), encoding="utf-8")
    return file


# -- what is said -----------------------------------------------------------------------------------


def test_elements_are_told_with_their_lines(robot: Path) -> None:
    found = nhtrack.inspect(robot)
    line = 1 + next(n for n, text in enumerate(robot.read_text().splitlines()) if '"left_tyre"' in text)
    assert found.reading.sources["left tyre"] == f"geom 'left_tyre' (line {line})"
    shown = invoke("inspect", robot).stdout
    assert f"geom 'left_tyre' (line {line})" in shown
    assert "Guard" in shown
    assert not found.faults


def test_what_has_no_limit_is_said_to_have_none(robot: Path) -> None:
    assert invoke("inspect", robot).stdout.count("no limit") >= 1
    told = json.loads(invoke("inspect", robot, "--json").stdout)
    values = {each["name"]: each["value"] for each in told["properties"]}
    assert values["speed without load"] is None
    assert values["largest wheel torque"] == 1.0
    assert [each["holds"] for each in told["guard"]] == [True] * len(told["guard"])
    assert any("no speed without load is stated" in note for note in told["notes"])


@pytest.mark.parametrize("options", [(), ("--json",)])
def test_every_reason_against_a_robot_is_told(refused: Path, options: tuple[str, ...]) -> None:
    printed = invoke("inspect", refused, *options)
    assert printed.exit_code == 2
    assert printed.stdout == ""
    assert "joint 'left_axle' (line" in printed.stderr
    assert "equality 'shaft' (line" in printed.stderr
    assert "Traceback" not in printed.stderr
    with pytest.raises(RefusedRobot, match="shaft"):
        nhtrack.inspect(refused)


def test_what_the_guard_objects_to_ends_the_command(robot: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from dataclasses import replace

    from nhtrack.robots.diff_drive import reading

    identify = reading.identify
    monkeypatch.setattr(reading, "identify", lambda *given: replace(identify(*given), mass=3.0))
    printed = invoke("inspect", robot)
    assert printed.exit_code == 2
    assert "mass is 2.6 kg in the scene, and 3 kg by the reduced model" in printed.stderr
    assert "Guard" in printed.stdout


def test_options_are_what_a_scenario_says(robot: Path) -> None:
    back = nhtrack.inspect(robot, forward="-x")
    assert back.drive.casters[0][0] == pytest.approx(0.08)
    assert nhtrack.inspect(robot).drive.casters[0][0] == pytest.approx(-0.08)
    printed = invoke("inspect", robot, "--forward=-x", "--wheels", "left_axle,right_axle", "--json")
    assert json.loads(printed.stdout)["properties"][2]["value"] == pytest.approx(0.08)
    for wrong, said in ((("--forward", "up"), "expected one of x, -x, y, -y, got 'up'"), (("--wheels", "a,b"), "'a'")):
        printed = invoke("inspect", robot, *wrong)
        assert printed.exit_code == 2
        assert said in printed.stderr


# -- the picture ------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["sphere", "ellipsoid", "capsule", "cylinder", "box"])
def test_an_outline_is_that_of_its_points(kind: str) -> None:
    """No point of the geom lies outside, and every corner is touched by one."""
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody><geom type='{kind}' size='0.3 0.2 0.1'/></worldbody></mujoco>"
    )
    size, random = model.geom_size[0], np.random.default_rng(7)
    ball = random.normal(size=(20_000, 3))
    ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    if kind == "box":
        points = np.sign(ball) * size
    elif kind == "cylinder":
        rim = ball / np.hypot(ball[:, 0], ball[:, 1])[:, None] * [size[0], size[0], 0]
        points = rim + np.sign(ball) * [0, 0, size[1]]
    elif kind == "capsule":
        points = ball * size[0] + np.sign(ball) * [0, 0, size[1]]
    else:
        points = ball * (size if kind == "ellipsoid" else size[0])
    frame = np.linalg.qr(random.normal(size=(3, 3)))[0]
    seen, corners = points @ frame[:2].T, outline(model, 0, frame[0], frame[1])
    edges = np.roll(corners, -1, axis=0) - corners
    long = np.linalg.norm(edges, axis=1) > 1e-12
    normals = np.stack([edges[:, 1], -edges[:, 0]], axis=-1)[long] / np.linalg.norm(edges[long], axis=1)[:, None]
    beyond = (seen @ normals.T - (corners[long] * normals).sum(axis=1)).max(axis=0)
    assert beyond.max() < 1e-12
    assert beyond.min() > -5e-3


@pytest.mark.parametrize("name", assets.robots())
def test_a_silhouette_stands_on_the_floor_between_its_wheels(name: str) -> None:
    reading = load_robot(name)
    above, side = (np.vstack([piece.corners for piece in seen]) for seen in silhouettes(reading, ABOVE, SIDE))
    drive = reading.model
    assert np.abs(above[:, 0]).max() == pytest.approx(np.abs(side[:, 0]).max(), rel=1e-9)
    assert -0.02 * drive.wheel_radius < side[:, 1].min() < 0.05 * drive.wheel_radius
    assert above[:, 1].max() > drive.half_separation
    assert above[:, 1].min() < -drive.half_separation


def drawn_texts(figure: Figure) -> list[str]:
    return [text.get_text() for axes in figure.axes for text in axes.texts if text.get_text()]


@pytest.mark.parametrize("name", assets.robots())
def test_a_picture_is_to_scale_and_nothing_in_it_overlaps(name: str) -> None:
    figure = robot_figure(load_robot(name))
    figure.draw_without_rendering()
    scales = []
    for axes in figure.axes:
        box = axes.get_window_extent()
        scales += [box.width / np.ptp(axes.get_xlim()), box.height / np.ptp(axes.get_ylim())]
        ticks = [
            label
            for axis in (axes.xaxis, axes.yaxis)
            for place, label in zip(axis.get_majorticklocs(), axis.get_ticklabels(), strict=True)
            if axis.get_view_interval()[0] <= place <= axis.get_view_interval()[1]
        ]
        written = [text for text in (*axes.texts, *ticks) if text.get_text()]
        for one, two in combinations(written, 2):
            assert not one.get_window_extent().overlaps(two.get_window_extent()), (one, two)
        for text in (text.get_window_extent() for text in axes.texts if text.get_text()):
            assert box.x0 < text.x0 < text.x1 < box.x1
            assert box.y0 < text.y0 < text.y1 < box.y1
    assert np.allclose(scales, scales[0], rtol=1e-6)


def test_a_picture_has_the_dimensions_of_the_robot(robot: Path) -> None:
    texts = drawn_texts(nhtrack.inspect(robot).figure)
    assert texts == [f"{2000 * HALF_SEPARATION:g} mm", "80 mm", f"{1000 * RADIUS:g} mm", "57.7 mm"]


@pytest.mark.slow
def test_a_picture_is_written_as_it_is_asked_for(robot: Path) -> None:
    printed = invoke("inspect", robot, "--figure", "a/look.png", "--json")
    assert printed.stderr == "wrote a/look.png\n"
    assert json.loads(printed.stdout)["robot"] == "plain"
    assert invoke("inspect", robot, "--figure", "b.pdf").stdout.endswith("wrote b.png\nwrote b.pdf\n")
    assert all(Path(name).stat().st_size > 5000 for name in ("a/look.png", "b.png", "b.pdf"))
    with pytest.raises(RenderError, match=r"expected a file \.png or \.pdf"):
        nhtrack.inspect(robot).save_figure("look.gif")


# -- the scenario -----------------------------------------------------------------------------------


@pytest.mark.parametrize("options", [(), ("--forward=-x", "--wheels", "left_axle,right_axle")])
@pytest.mark.slow
def test_a_scenario_is_started_with_the_robot(robot: Path, options: tuple[str, ...]) -> None:
    Path("there").mkdir()
    printed = invoke("inspect", robot, *options, "--write", "there/my_robot.yaml")
    assert "wrote there/my_robot.yaml; run it with: nhtrack run there/my_robot.yaml" in printed.stdout
    text = Path("there/my_robot.yaml").read_text()
    assert text.count("#") > 15
    section = "{file: ../plain.xml, wheels: [left_axle, right_axle], forward: -x}" if options else "../plain.xml"
    assert f"\nrobot: {section}\n" in text
    assert invoke("validate", "there/my_robot.yaml").exit_code == 0
    scenario = nhtrack.load("there/my_robot.yaml")
    assert scenario.robot.forward == ("-x" if options else "")
    found = nhtrack.inspect(robot)
    assert found.limits is not None
    run = nhtrack.run(scenario, backend="ideal")
    speed = run["twist"].sel(robot="leader")[:, 0]
    assert 0.2 * found.limits.speed < float(speed.max()) < 0.5 * found.limits.speed
    assert float(abs(run["error"].sel(robot="follower")[-1, :2]).max()) < 0.01
    assert "exists; choose another name" in invoke("inspect", robot, "--write", "there/my_robot.yaml").stderr


def test_a_bundled_robot_is_called_by_its_name(robot: Path) -> None:
    nhtrack.inspect("burger").write_scenario("mine.yaml")
    assert nhtrack.load("mine.yaml").robot.file == "burger"


def test_where_nothing_can_move_there_is_nothing_to_start(robot: Path) -> None:
    with pytest.raises(RefusedError, match="no limits of motion"):
        nhtrack.inspect(robot, friction=0.0).write_scenario("mine.yaml")
    assert not Path("mine.yaml").exists()


def test_a_robot_that_is_not_there_is_the_command_line_at_fault(robot: Path) -> None:
    assert invoke("inspect", "plane.xml").exit_code == 2
    with pytest.raises(RobotError, match=r"plane\.xml"):
        nhtrack.inspect("plane.xml")
