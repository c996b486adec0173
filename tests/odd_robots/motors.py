"""Habits of actuators and of wheel joints' losses."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from odd_robots.habit import habit
from odd_robots.plain import SIDES, add, part, section


def _motors(robot: ET.Element, tag: str, **attributes: str) -> None:
    """Puts actuators of a kind in the place of the motors."""
    actuators = section(robot, "actuator")
    for side in SIDES:
        old = part(robot, f"{side}_motor")
        new = ET.Element(tag, {"name": f"{side}_motor", "joint": f"{side}_axle", **attributes})
        actuators.insert(list(actuators).index(old), new)
        actuators.remove(old)


@habit("motors", no_load_speed=20.0)
def velocity_servos(robot: ET.Element) -> None:
    _motors(robot, "velocity", kv="0.5", ctrlrange="-20 20", forcerange="-1 1")


@habit("motors", no_load_speed=20.0)
def velocity_servos_limited_by_their_control(robot: ET.Element) -> None:
    _motors(robot, "velocity", kv="0.05", ctrllimited="true", ctrlrange="-20 20")


@habit("motors", no_load_speed=20.0)
def general_servos(robot: ET.Element) -> None:
    _motors(robot, "general", biastype="affine", gainprm="40", biasprm="0 0 -40", ctrlrange="-20 20", forcerange="-1 1")


@habit("motors", no_load_speed=20.0)
def geared_servos(robot: ET.Element) -> None:
    # The servo sees four times the wheel's speed, and a quarter of its torque.
    _motors(robot, "velocity", kv="0.5", gear="4", ctrlrange="-80 80", forcerange="-0.25 0.25")


@habit("motors")
def geared_motors(robot: ET.Element) -> None:
    _motors(robot, "motor", gear="50", ctrlrange="-0.02 0.02")


@habit("motors")
def motors_limited_by_force(robot: ET.Element) -> None:
    _motors(robot, "motor", gear="2", ctrlrange="-3 3", forcerange="-0.5 0.5")


@habit("motors")
def motors_limited_by_their_joint(robot: ET.Element) -> None:
    _motors(robot, "motor", ctrlrange="-3 3")
    for side in SIDES:
        part(robot, f"{side}_axle").set("actuatorfrcrange", "-1 1")


@habit("motors")
def motors_with_a_lower_end(robot: ET.Element) -> None:
    _motors(robot, "motor", ctrlrange="-1 4")


@habit("motors")
def motors_of_unequal_strength(robot: ET.Element) -> None:
    part(robot, "left_motor").set("ctrlrange", "-7 7")


@habit("motors")
def motors_in_the_parent(robot: ET.Element) -> None:
    for side in SIDES:
        motor = part(robot, f"{side}_motor")
        motor.set("jointinparent", motor.attrib.pop("joint"))


@habit("motors", torque_limit=float("inf"))
def motors_without_limits(robot: ET.Element) -> None:
    for side in SIDES:
        for name in ("ctrllimited", "ctrlrange"):
            part(robot, f"{side}_motor").attrib.pop(name)


@habit("motors", no_load_speed=30.0)
def motors_with_a_datasheet(robot: ET.Element) -> None:
    add(section(robot, "custom"), '<numeric name="motor_stall_torque" data="2"/>')
    add(section(robot, "custom"), '<numeric name="motor_no_load_speed" data="30"/>')


@habit("motors")
def motors_backwards(robot: ET.Element) -> None:
    for side in SIDES:
        part(robot, f"{side}_motor").set("gear", "-1")


@habit("motors", torque_limit=0.5)
def motors_on_tendons(robot: ET.Element) -> None:
    # |t_l + t_r| <= 1 and |t_r - t_l| <= 1: half a newton metre each, whatever the other has.
    actuators = section(robot, "actuator")
    actuators.clear()
    tendons = ET.Element("tendon")
    robot.append(tendons)
    for name, left in (("forward", 0.5), ("turn", -0.5)):
        fixed = add(tendons, f'<fixed name="{name}"/>')
        add(fixed, f'<joint joint="left_axle" coef="{left}"/>')
        add(fixed, '<joint joint="right_axle" coef="0.5"/>')
        add(actuators, f'<motor name="{name}" tendon="{name}" ctrlrange="-1 1"/>')


@habit("order")
def right_motor_first(robot: ET.Element) -> None:
    actuators = section(robot, "actuator")
    actuators[:] = list(actuators)[::-1]


@habit("order")
def right_wheel_first(robot: ET.Element) -> None:
    holder = next(each for each in robot.iter() if part(robot, "left_wheel") in each)
    left = part(robot, "left_wheel")
    holder.remove(left)
    holder.append(left)


@habit("losses", damping=(0.02, 0.02))
def damped_wheels(robot: ET.Element) -> None:
    for side in SIDES:
        part(robot, f"{side}_axle").set("damping", "0.02")


@habit("losses", damping=(0.01, 0.03))
def wheels_damped_differently(robot: ET.Element) -> None:
    for side, value in zip(SIDES, ("0.01", "0.03"), strict=True):
        part(robot, f"{side}_axle").set("damping", value)


@habit("losses", frictionloss=(0.01, 0.01))
def wheels_with_dry_friction(robot: ET.Element) -> None:
    for side in SIDES:
        part(robot, f"{side}_axle").set("frictionloss", "0.01")


@habit("losses", wheel_inertia=14e-4)
def wheels_with_rotors(robot: ET.Element) -> None:
    for side in SIDES:
        part(robot, f"{side}_axle").set("armature", "0.001")
