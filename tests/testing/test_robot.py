"""The contract of robots: bundled ones and others keep it, and broken ones do not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import pytest

from nhtrack.robots.contract import Hints
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.robots.diff_drive import reading as diff_drive_reading
from nhtrack.testing import RobotContract
from odd_robots.plain import part, plain_robot, text_of

pytestmark = pytest.mark.slow

TESTS = tuple(name for name in dir(RobotContract) if name.startswith("test_"))


@pytest.mark.render
class TestBurger(RobotContract):
    """A bundled robot, in closer budgets."""

    robot: ClassVar[str | Path] = "burger"
    rest, symmetry, pushed, open_loop, closed_loop = 1e-7, 1e-6, 1e-6, 1e-6, 1e-6


@pytest.mark.render
class TestOnASwivelCaster(RobotContract):
    """A caster that trails and steers a little, of which the reduced model does not know."""

    robot: ClassVar[str | Path] = "mp500"
    pushed, open_loop, closed_loop = 0.05, 0.25, 0.05


def contract(file: str | Path, hints: Hints | None = None) -> RobotContract:
    """Returns the contract of a robot, for one test at a time."""
    return type("Contract", (RobotContract,), {"robot": file, "hints": hints or Hints()})()


def failures(file: Path) -> dict[str, str]:
    """Returns what the tests of a robot object to, by their names, without the picture."""
    found = {}
    for name in TESTS:
        if name != "test_it_can_be_seen":
            try:
                getattr(contract(file), name)()
            except AssertionError as error:
                found[name] = str(error)
    return found


@pytest.fixture
def plain(tmp_path: Path) -> Callable[..., Path]:
    """Returns a function that writes the plain robot, with attributes of some parts changed."""

    def write(**changes: dict[str, str]) -> Path:
        robot = plain_robot()
        for name, attributes in changes.items():
            element = part(robot, name)
            (element.find("inertial") if "mass" in attributes else element).attrib.update(attributes)  # type: ignore[union-attr]
        file = tmp_path / "plain.xml"
        file.write_text(text_of(robot), encoding="utf-8")
        return file

    return write


def test_a_robot_of_ones_own_keeps_it(plain: Callable[..., Path]) -> None:
    assert failures(plain()) == {}


def test_one_that_is_refused_is_told_with_its_reason(plain: Callable[..., Path]) -> None:
    file = plain(left_axle={"limited": "true", "range": "-1 1"})
    with pytest.raises(AssertionError, match=r"joint 'left_axle' \(line \d+\): its range .* stops the wheel"):
        contract(file).test_it_is_read()


def test_one_with_a_wheel_out_of_balance_creeps(plain: Callable[..., Path]) -> None:
    """So little that it is read: 0.4 mm."""
    found = failures(plain(left_wheel={"mass": "0.3", "pos": "0.0004 0 0"}))
    assert "creeps where it stands" in found["test_it_stands"]


@pytest.mark.parametrize(
    ("change", "broken"),
    [
        ({"mass": 2.6 * 1.001}, {"test_its_scene_is_what_the_reduced_model_says"}),
        ({"half_separation": 0.101}, {"test_ahead_is_as_back_and_left_as_right", "test_one_follows_another"}),
        ({"wheel_inertia": 8e-4}, {"test_ahead_is_as_back_and_left_as_right", "test_one_follows_another"}),
        ({"com": (-0.02, 0.01, 0.06)}, {"test_open_loop_it_goes_where_the_ideal_goes"}),
    ],
)
def test_one_whose_reduced_model_is_wrong_fails(
    change: dict[str, Any], broken: set[str], plain: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    identify = diff_drive_reading.identify

    def misread(*arguments: Any) -> DiffDrive:
        return replace(identify(*arguments), **change)

    monkeypatch.setattr(diff_drive_reading, "identify", misread)
    assert broken | {"test_open_loop_it_goes_where_the_ideal_goes"} <= set(failures(plain()))


@pytest.mark.render
def test_one_of_which_nothing_is_drawn_is_not_seen(plain: Callable[..., Path]) -> None:
    contract(plain()).test_it_can_be_seen()
    hidden = {"rgba": "1 1 1 0"}
    with pytest.raises(AssertionError, match="it covers"):
        contract(plain(hull=hidden, caster=hidden, left_tyre=hidden, right_tyre=hidden)).test_it_can_be_seen()
