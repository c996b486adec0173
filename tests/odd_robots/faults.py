"""Faults: the smallest changes of a plain robot that make it none that can be driven, and whom to blame for it."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import dataclass

from odd_robots.plain import SIDES, add, part, section, turn

Change = Callable[[ET.Element], None]

#: Every fault by its name.
FAULTS: dict[str, Fault] = {}


@dataclass(frozen=True)
class Fault:
    """A fault of a robot.

    Attributes:
        change: makes a plain robot have it.
        blames: elements that its messages must name with their lines, (kind, name); none where there is none to blame.
        words: what its messages must say.
    """

    change: Change
    blames: tuple[tuple[str, str], ...]
    words: tuple[str, ...]


def fault(blames: str = "", *words: str) -> Callable[[Change], Change]:
    """Returns a decorator that makes a change a fault; `blames` is `kind name, kind name`."""

    def keep(change: Change) -> Change:
        named = [each.split(" ", 1) for each in blames.split(", ") if each]
        FAULTS[change.__name__] = Fault(change, tuple((kind, name) for kind, name in named), words)
        return change

    return keep


def _set(robot: ET.Element, name: str, **attributes: str) -> None:
    for key, value in attributes.items():
        part(robot, name).set(key, value)


@fault("joint left_axle, joint right_axle", "stiffness")
def springs_on_wheels(robot: ET.Element) -> None:
    for side in SIDES:
        _set(robot, f"{side}_axle", stiffness="0.01", springref="0.2")


@fault("joint left_axle", "range")
def a_limited_wheel(robot: ET.Element) -> None:
    _set(robot, "left_axle", limited="true", range="-400 400")


@fault("joint right_axle", "frictionloss", "motor")
def a_wheel_held_by_dry_friction(robot: ET.Element) -> None:
    _set(robot, "right_axle", frictionloss="50")


@fault("", "no driven wheel", "actuator")
def no_actuators(robot: ET.Element) -> None:
    section(robot, "actuator").clear()


@fault("joint left_axle", "only one driven wheel")
def one_driven_wheel(robot: ET.Element) -> None:
    actuators = section(robot, "actuator")
    actuators.remove(part(robot, "right_motor"))


@fault("actuator left_motor, actuator right_motor", "filter")
def delayed_motors(robot: ET.Element) -> None:
    actuators = section(robot, "actuator")
    for side in SIDES:
        actuators.remove(part(robot, f"{side}_motor"))
        add(
            actuators,
            f'<general name="{side}_motor" joint="{side}_axle" dyntype="filter" dynprm="0.05" ctrlrange="-1 1"/>',
        )


@fault("actuator left_motor", "position")
def position_servos(robot: ET.Element) -> None:
    actuators = section(robot, "actuator")
    for side in SIDES:
        actuators.remove(part(robot, f"{side}_motor"))
        add(actuators, f'<position name="{side}_motor" joint="{side}_axle" kp="5"/>')


@fault("actuator left_motor", "one way")
def motors_that_only_drive_ahead(robot: ET.Element) -> None:
    for side in SIDES:
        _set(robot, f"{side}_motor", ctrlrange="0 1")


@fault("", "skid")
def four_driven_wheels(robot: ET.Element) -> None:
    chassis = part(robot, "chassis")
    chassis.remove(part(robot, "caster"))
    for side, y in zip(SIDES, (0.1, -0.1), strict=True):
        _wheel(chassis, f"rear_{side}", f"-0.16 {y} 0")
        add(section(robot, "actuator"), f'<motor name="rear_{side}_motor" joint="rear_{side}_axle" ctrlrange="-1 1"/>')


def _wheel(holder: ET.Element, name: str, pos: str) -> ET.Element:
    """Returns a wheel as large as the plain robot's."""
    wheel = add(holder, f'<body name="{name}_wheel" pos="{pos}"/>')
    add(wheel, '<inertial mass="0.3" pos="0 0 0" diaginertia="2e-4 4e-4 2e-4"/>')
    add(wheel, f'<joint name="{name}_axle" axis="0 1 0"/>')
    add(wheel, f'<geom name="{name}_tyre" type="ellipsoid" size="0.05 0.01 0.05"/>')
    return wheel


@fault("joint left_steer, joint right_steer", "steers")
def steered_front_wheels(robot: ET.Element) -> None:
    chassis = part(robot, "chassis")
    for side, y in zip(SIDES, (0.1, -0.1), strict=True):
        knuckle = add(chassis, f'<body name="{side}_knuckle" pos="0.16 {y} 0"/>')
        add(knuckle, '<inertial mass="0.05" pos="0 0 0" diaginertia="1e-5 1e-5 1e-5"/>')
        add(knuckle, f'<joint name="{side}_steer" axis="0 0 1" limited="true" range="-30 30"/>')
        _wheel(knuckle, f"front_{side}", "0 0 0")
        add(section(robot, "actuator"), f'<position name="{side}_steering" joint="{side}_steer" kp="10"/>')


@fault("joint left_swerve, joint right_swerve", "steers")
def swerve_drive(robot: ET.Element) -> None:
    chassis = part(robot, "chassis")
    for side, y in zip(SIDES, (0.1, -0.1), strict=True):
        wheel = part(robot, f"{side}_wheel")
        chassis.remove(wheel)
        wheel.set("pos", "0 0 0")
        module = add(chassis, f'<body name="{side}_module" pos="0 {y} 0"/>')
        add(module, '<inertial mass="0.05" pos="0 0 0" diaginertia="1e-5 1e-5 1e-5"/>')
        add(module, f'<joint name="{side}_swerve" axis="0 0 1"/>')
        module.append(wheel)
        add(section(robot, "actuator"), f'<position name="{side}_turner" joint="{side}_swerve" kp="10"/>')


@fault("", "omni")
def three_omni_wheels(robot: ET.Element) -> None:
    chassis = part(robot, "chassis")
    chassis.remove(part(robot, "caster"))
    for side, angle in zip(SIDES, (30, -30), strict=True):
        part(robot, f"{side}_wheel").set("euler", f"0 0 {angle}")
    rear = _wheel(chassis, "rear", "-0.12 0 0")
    rear.set("euler", "0 0 90")
    add(section(robot, "actuator"), '<motor name="rear_motor" joint="rear_axle" ctrlrange="-1 1"/>')


@fault("joint slide_x, joint slide_y, joint yaw", "leads the base")
def planar_slides(robot: ET.Element) -> None:
    chassis = part(robot, "chassis")
    chassis.remove(part(robot, "root"))
    for name, kind, axis in (("slide_x", "slide", "1 0 0"), ("slide_y", "slide", "0 1 0"), ("yaw", "hinge", "0 0 1")):
        chassis.insert(0, ET.fromstring(f'<joint name="{name}" type="{kind}" axis="{axis}"/>'))


@fault("joint slide_x, joint slide_y, joint yaw", "leads the base")
def planar_slides_in_bodies_of_their_own(robot: ET.Element) -> None:
    chassis, world = part(robot, "chassis"), section(robot, "worldbody")
    chassis.remove(part(robot, "root"))
    chassis.insert(0, ET.fromstring('<joint name="yaw" type="hinge" axis="0 0 1"/>'))
    world.remove(chassis)
    holder = world
    for name, axis in (("slide_x", "1 0 0"), ("slide_y", "0 1 0")):
        holder = add(holder, f'<body name="{name}_body"/>')
        add(holder, '<inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>')
        add(holder, f'<joint name="{name}" type="slide" axis="{axis}"/>')
    holder.append(chassis)


@fault("joint rear_axle", "not driven")
def a_passive_wheel(robot: ET.Element) -> None:
    chassis = part(robot, "chassis")
    chassis.remove(part(robot, "caster"))
    _wheel(chassis, "rear", "-0.12 0 0")


@fault("geom hull", "floor")
def a_hull_on_the_floor(robot: ET.Element) -> None:
    _set(robot, "hull", size="0.09 0.07 0.08")


@fault("geom hull", "floor")
def a_hull_below_the_tyres(robot: ET.Element) -> None:
    _set(robot, "hull", size="0.09 0.07 0.09")


@fault("equality belt", "couples")
def coupled_wheels(robot: ET.Element) -> None:
    robot.append(ET.fromstring('<equality><joint name="belt" joint1="left_axle" joint2="right_axle"/></equality>'))


@fault("equality tie", "ties a wheel")
def a_wheel_tied_to_the_chassis(robot: ET.Element) -> None:
    robot.append(ET.fromstring('<equality><weld name="tie" body1="left_wheel" body2="chassis"/></equality>'))


@fault("equality tie", "outside")
def a_robot_tied_to_the_world(robot: ET.Element) -> None:
    robot.append(ET.fromstring('<equality><connect name="tie" body1="chassis" anchor="0 0 0"/></equality>'))


@fault("tendon rope", "springs")
def a_rope_to_a_wheel(robot: ET.Element) -> None:
    add(part(robot, "left_wheel"), '<site name="spoke" pos="0.02 0 0"/>')
    add(part(robot, "chassis"), '<site name="hook" pos="0.02 0 0.1"/>')
    rope = '<tendon><spatial name="rope" stiffness="10"><site site="spoke"/><site site="hook"/></spatial></tendon>'
    robot.append(ET.fromstring(rope))


@fault("joint left_axle, joint right_axle", "toe")
def toed_in_wheels(robot: ET.Element) -> None:
    for side, angle in zip(SIDES, (-3, 3), strict=True):
        _set(robot, f"{side}_wheel", euler=f"0 0 {angle}")


@fault("geom left_tyre", "eccentric")
def an_eccentric_tyre(robot: ET.Element) -> None:
    _set(robot, "left_tyre", pos="0.004 0 0")


@fault("geom left_tyre, geom right_tyre", "not round")
def oval_tyres(robot: ET.Element) -> None:
    for side in SIDES:
        _set(robot, f"{side}_tyre", size="0.04 0.01 0.05")


@fault("geom left_tyre, geom right_tyre", "radi")
def tyres_of_two_sizes(robot: ET.Element) -> None:
    _set(robot, "left_tyre", size="0.045 0.01 0.045")


@fault("", "one axle")
def wheels_one_behind_the_other(robot: ET.Element) -> None:
    _set(robot, "left_wheel", pos="0.03 0.1 0")
    _set(robot, "right_wheel", pos="-0.03 -0.1 0")


@fault("joint left_axle, joint right_axle", "inertia")
def wheels_of_unequal_spin(robot: ET.Element) -> None:
    _set(robot, "left_axle", armature="1e-4")


@fault("", "tip")
def it_tips_over(robot: ET.Element) -> None:
    inertial = part(robot, "chassis").find("inertial")
    assert inertial is not None
    inertial.set("pos", "0.05 0 0.01")


@fault("", "caster")
def no_caster(robot: ET.Element) -> None:
    chassis = part(robot, "chassis")
    chassis.remove(part(robot, "caster"))
    chassis.remove(part(robot, "hull"))


@fault("body chassis", "gravcomp")
def a_weightless_chassis(robot: ET.Element) -> None:
    part(robot, "chassis").set("gravcomp", "0.5")


@fault("joint left_spring, joint right_spring", "springs")
def sprung_wheels(robot: ET.Element) -> None:
    chassis = part(robot, "chassis")
    for side, y in zip(SIDES, (0.1, -0.1), strict=True):
        wheel = part(robot, f"{side}_wheel")
        chassis.remove(wheel)
        wheel.set("pos", "0 0 0")
        strut = add(chassis, f'<body name="{side}_strut" pos="0 {y} 0"/>')
        add(strut, '<inertial mass="0.05" pos="0 0 0" diaginertia="1e-5 1e-5 1e-5"/>')
        add(strut, f'<joint name="{side}_spring" type="slide" axis="0 0 1" stiffness="5000" damping="20"/>')
        strut.append(wheel)


@fault("joint left_axle, joint right_axle", "roll")
def wheels_with_rollers(robot: ET.Element) -> None:
    for side in SIDES:
        wheel = part(robot, f"{side}_wheel")
        for k in range(3):
            roller = add(wheel, f'<body name="{side}_roller_{k}" quat="{_quat(120 * k)}"/>')
            add(roller, '<inertial mass="0.01" pos="0 0 0.045" diaginertia="1e-6 1e-6 1e-6"/>')
            add(roller, f'<joint name="{side}_roll_{k}" axis="1 1 0" pos="0 0 0.045"/>')
            add(roller, f'<geom name="{side}_roller_geom_{k}" type="sphere" size="0.005" pos="0 0 0.045"/>')


def _quat(angle: float) -> str:
    return " ".join(repr(float(value)) for value in turn("y", angle).as_quat(scalar_first=True))
