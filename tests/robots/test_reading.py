"""Robots of other people's habits read as what they are, and their faults refused by name and line."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import mujoco
import pytest

from nhtrack.robots.contract import RefusedRobot
from nhtrack.robots.kind import Reading
from nhtrack.robots.registry import read_file
from odd_robots.faults import FAULTS
from odd_robots.habits import HABITS, expected
from odd_robots.plain import MASS, line_of, plain_robot, text_of
from odd_robots.variants import variants
from tolerances import HAND

# Meshes are kept in single precision, and files write angles with a few digits.
READ = 1e-6
# The axle of a file that writes 1.57 for pi/2 is tilted by 0.8 mrad: the second order of it.
TILTED = 1e-6


def read(robot: ET.Element, folder: Path, **hints: Any) -> Reading:
    """Returns a robot as it is read from a file."""
    file = folder / "robot.xml"
    file.write_text(text_of(robot), encoding="utf-8")
    return read_file(file, **hints)


def numbers(reading: Reading) -> dict[str, Any]:
    """Returns what is read of a robot, by the names of `odd_robots.habit.PLAIN`."""
    drive = reading.model
    return {
        "wheel_radius": drive.wheel_radius,
        "half_separation": drive.half_separation,
        "mass": drive.mass,
        "torque_limit": drive.motor.torque_limit,
        "no_load_speed": drive.motor.no_load_speed,
        "com": drive.com,
        "casters": drive.casters,
        "damping": drive.losses.damping,
        "frictionloss": drive.losses.dry_friction,
        "wheel_inertia": drive.wheel_inertia,
    }


def require(found: dict[str, Any], wanted: dict[str, Any]) -> None:
    """Requires that what is read is what was to be read."""
    for quantity, value in found.items():
        if quantity == "casters":
            assert len(value) == len(wanted[quantity])
            for a, b in zip(sorted(value), sorted(wanted[quantity]), strict=True):
                assert a == pytest.approx(b, abs=READ), quantity
        else:
            assert value == pytest.approx(wanted[quantity], rel=READ, abs=READ), quantity


class TestPlain:
    def test_every_number(self, tmp_path: Path) -> None:
        reading = read(plain_robot(), tmp_path)
        drive = reading.model
        require(numbers(reading), expected())
        # Chassis 2 kg, 0.02 m behind the axle, and wheels of 0.3 kg, 0.1 m from the middle.
        assert drive.axle_inertia == pytest.approx(0.012 + 2 * 0.02**2 + 2 * (2e-4 + 0.3 * 0.1**2), rel=HAND)
        assert drive.reflected_inertia == 0
        assert drive.products == pytest.approx((2 * 0.02 * 0.01 - 0.04 * 0.02 / MASS, 0.0), abs=READ)

    def test_its_parts_and_where_they_were_read(self, tmp_path: Path) -> None:
        robot = plain_robot()
        reading = read(robot, tmp_path)
        text = text_of(robot)
        for what, kind, name in (
            ("chassis", "body", "chassis"),
            ("left wheel", "joint", "left_axle"),
            ("right wheel", "joint", "right_axle"),
            ("left tyre", "geom", "left_tyre"),
            ("right tyre", "geom", "right_tyre"),
            ("caster", "geom", "caster"),
        ):
            assert reading.sources[what] == f"{kind} {name!r} (line {line_of(text, kind, name)})"
        model = mujoco.MjModel.from_xml_string(reading.mjcf)
        assert model.body(reading.parts.chassis).jntnum[0] == 1
        for joint, motor, tyre in zip(
            reading.parts.wheel_joints, reading.parts.motors, reading.parts.tyres, strict=True
        ):
            assert model.actuator(motor).trnid[0] == model.joint(joint).id
            assert model.geom(tyre).bodyid[0] == model.joint(joint).bodyid[0]


@pytest.mark.parametrize("name", HABITS)
def test_a_habit_changes_what_is_read_no_more_than_it_says(name: str, tmp_path: Path) -> None:
    habit, robot = HABITS[name], plain_robot()
    habit.change(robot)
    reading = read(robot, tmp_path, hints=habit.hints)
    require(numbers(reading), expected(habit))
    # A slash in a name parts robots from scenes.
    assert [each.get("name") for each in ET.fromstring(reading.mjcf).iter() if "/" in each.get("name", "")] == []


@pytest.mark.parametrize(
    ("name", "told"),
    {
        "floor_light_and_goal": ("1 geom of the world", "1 light"),
        "walls_and_crates": ("crate, ball, marker",),
        "under_water": ("air or water", "gravity", "damping and armature", "thruster"),
        "arm": ("shoulder_yaw, elbow_pitch", "shoulder_yaw_servo"),
        "lift_at_a_key": ("'home'", "lift_slide", "lift_motor"),
        "spinning_lidar": ("1 sensor", "lidar_spin"),
        "caster_that_is_only_seen": ("touch nothing",),
        "caster_a_millimetre_high": ("leans back by 0.7",),
        "swivel_caster": ("swivel, caster_axle",),
        "ahead_is_y": ("+y",),
        "tail_first": ("-x",),
        "motors_without_limits": ("no limit of torque",),
        "motors_of_unequal_strength": ("the least",),
        "wheels_rolled_by_157_hundredths": ("0.046 degrees",),
    }.items(),
)
def test_what_is_left_out_or_assumed_is_told(name: str, told: tuple[str, ...], tmp_path: Path) -> None:
    robot = plain_robot()
    HABITS[name].change(robot)
    notes = " ".join(read(robot, tmp_path, hints=HABITS[name].hints).notes)
    assert [words for words in told if words not in notes] == []


@pytest.mark.slow
def test_habits_together_are_read_as_each_alone(tmp_path: Path) -> None:
    for variant in variants(60, seed=14):
        if not variant.fault:
            found = numbers(read(variant.robot, tmp_path, hints=variant.hints))
            try:
                require(found, expected(*(HABITS[name] for name in variant.made_of)))
            except AssertionError as error:
                raise AssertionError(" ".join(variant.made_of)) from error


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_refused_by_element_and_line(name: str, tmp_path: Path) -> None:
    fault, robot = FAULTS[name], plain_robot()
    fault.change(robot)
    with pytest.raises(RefusedRobot) as caught:
        read(robot, tmp_path)
    told, text = str(caught.value), text_of(robot)
    for kind, element in fault.blames:
        assert f"{kind} {element!r} (line {line_of(text, kind, element)})" in told
    for word in fault.words:
        assert word in told


@pytest.mark.parametrize(
    "together",
    [
        ("springs_on_wheels", "delayed_motors", "coupled_wheels", "a_weightless_chassis"),
        ("a_limited_wheel", "oval_tyres", "a_hull_on_the_floor"),
        ("a_passive_wheel", "steered_front_wheels"),
    ],
)
def test_all_reasons_are_told_at_once(together: tuple[str, ...], tmp_path: Path) -> None:
    robot = plain_robot()
    for name in together:
        FAULTS[name].change(robot)
    with pytest.raises(RefusedRobot) as caught:
        read(robot, tmp_path)
    told = str(caught.value)
    assert [
        name for name in together for kind, element in FAULTS[name].blames if f"{kind} {element!r}" not in told
    ] == []
