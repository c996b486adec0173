"""Habits of casters, of arms and sensors with joints, and of what stands around a robot in its file."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET

import mujoco

from odd_robots.habit import habit
from odd_robots.plain import add, part, section, text_of

_INERTIAL = '<inertial mass="{}" pos="0 0 0" diaginertia="{} {} {}"/>'


def _without_caster(robot: ET.Element) -> ET.Element:
    """Returns the body of the caster after that is removed."""
    holder = next(each for each in robot.iter() if any(child.get("name") == "caster" for child in each))
    holder.remove(part(robot, "caster"))
    return holder


@habit("casters", casters=((-0.08, 0.04), (-0.08, -0.04)))
def two_casters(robot: ET.Element) -> None:
    chassis = _without_caster(robot)
    for name, y in (("caster_left", 0.04), ("caster_right", -0.04)):
        add(chassis, f'<geom name="{name}" type="sphere" size="0.005" pos="-0.08 {y} -0.045" condim="1" priority="1"/>')


@habit("casters")
def ellipsoid_caster(robot: ET.Element) -> None:
    part(robot, "caster").set("type", "ellipsoid")
    part(robot, "caster").set("size", "0.01 0.015 0.02")


@habit("casters")
def caster_that_is_only_seen(robot: ET.Element) -> None:
    part(robot, "caster").set("contype", "0")
    part(robot, "caster").set("conaffinity", "0")


@habit("casters")
def caster_in_a_body(robot: ET.Element) -> None:
    chassis = _without_caster(robot)
    body = add(chassis, '<body name="caster_body" pos="-0.08 0 -0.03"/>')
    add(body, '<geom name="caster" type="sphere" size="0.02" mass="0"/>')


@habit("casters", adds=((0.05, (-0.08, 0, -0.03)),))
def caster_on_a_ball_joint(robot: ET.Element) -> None:
    chassis = _without_caster(robot)
    body = add(chassis, '<body name="caster_body" pos="-0.08 0 -0.03"/>')
    add(body, _INERTIAL.format(0.05, 8e-6, 8e-6, 8e-6))
    add(body, '<joint name="socket" type="ball" damping="0.0005"/>')
    add(body, '<geom name="caster" type="sphere" size="0.02" friction="0 0 0"/>')


@habit("casters", adds=((0.05, (-0.08, 0, -0.03)),))
def caster_on_three_hinges(robot: ET.Element) -> None:
    chassis = _without_caster(robot)
    body = add(chassis, '<body name="caster_body" pos="-0.08 0 -0.03"/>')
    add(body, _INERTIAL.format(0.05, 8e-6, 8e-6, 8e-6))
    for axis in ("1 0 0", "0 1 0", "0 0 1"):
        add(body, f'<joint name="socket_{axis.replace(" ", "")}" axis="{axis}"/>')
    add(body, '<geom name="caster" type="sphere" size="0.02"/>')


@habit("casters", adds=((0.002, (-0.07, 0, -0.02)), (0.003, (-0.082, 0, -0.038))), casters=((-0.082, 0.0),))
def swivel_caster(robot: ET.Element) -> None:
    # Light beside its robot: what it adds to a robot's inertia, and how it swings, the reduced model does not know.
    chassis = _without_caster(robot)
    fork = add(chassis, '<body name="fork" pos="-0.07 0 -0.02"/>')
    add(fork, _INERTIAL.format(0.002, 1e-7, 1e-7, 1e-7))
    add(fork, '<joint name="swivel" axis="0 0 1" damping="1e-7"/>')
    wheel = add(fork, '<body name="caster_wheel" pos="-0.012 0 -0.018"/>')
    add(wheel, _INERTIAL.format(0.003, 1.2e-7, 2.2e-7, 1.2e-7))
    add(wheel, '<joint name="caster_axle" axis="0 1 0"/>')
    tyre = add(wheel, '<geom name="caster" type="cylinder" size="0.012 0.004"/>')
    tyre.set("quat", "0.7071067811865476 0.7071067811865476 0 0")


def _lean(rise: float) -> float:
    """Returns how far the plain robot turns about its axle, nose up, until a caster that is too high touches [rad]."""
    # Turned by phi, the sphere's centre (x, z) is at the height z cos(phi) + x sin(phi), which is 0.02 - 0.05 then.
    x, z = -0.08, -0.03 + rise
    return math.asin(0.03 / math.hypot(x, z)) - math.atan2(-z, -x)


@habit("casters", lean=_lean(0.001), casters=((-0.08 * math.cos(_lean(0.001)) + 0.029 * math.sin(_lean(0.001)), 0.0),))
def caster_a_millimetre_high(robot: ET.Element) -> None:
    part(robot, "caster").set("pos", "-0.08 0 -0.029")


@habit("arms", adds=((0.2, (0.02, 0, 0.1)), (0.1, (0.02, 0.06, 0.1))))
def arm(robot: ET.Element) -> None:
    shoulder = add(part(robot, "chassis"), '<body name="shoulder" pos="0.02 0 0.1"/>')
    add(shoulder, _INERTIAL.format(0.2, 1e-4, 1e-4, 1e-4))
    add(shoulder, '<joint name="shoulder_yaw" axis="0 0 1" range="-100 100" limited="true" damping="0.1"/>')
    elbow = add(shoulder, '<body name="elbow" pos="0 0.06 0" gravcomp="1"/>')
    add(elbow, _INERTIAL.format(0.1, 1e-4, 1e-4, 1e-4))
    add(elbow, '<joint name="elbow_pitch" axis="0 1 0" stiffness="1"/>')
    add(elbow, '<geom name="hand" type="capsule" size="0.01 0.02"/>')
    for joint in ("shoulder_yaw", "elbow_pitch"):
        add(section(robot, "actuator"), f'<position name="{joint}_servo" joint="{joint}" kp="10"/>')


@habit("arms", adds=((0.3, (-0.02, 0, 0.12)),))
def lift_at_a_key(robot: ET.Element) -> None:
    lift = add(part(robot, "chassis"), '<body name="lift" pos="-0.02 0 0.08"/>')
    add(lift, _INERTIAL.format(0.3, 1e-4, 1e-4, 1e-4))
    add(lift, '<joint name="lift_slide" type="slide" axis="0 0 1" range="0 0.1" limited="true"/>')
    add(lift, '<geom name="fork_plate" type="box" size="0.03 0.03 0.005"/>')
    add(section(robot, "actuator"), '<motor name="lift_motor" joint="lift_slide" gear="100"/>')
    # Its base's quaternion is zero, as in a file that was never reset to it.
    keys = ET.Element("keyframe")
    model = mujoco.MjModel.from_xml_string(text_of(robot))
    qpos = ["0"] * model.nq
    qpos[model.joint("lift_slide").qposadr[0]] = "0.04"
    add(keys, f'<key name="home" qpos="{" ".join(qpos)}"/>')
    robot.append(keys)


@habit("arms", adds=((0.1, (0, 0, 0.09)),))
def spinning_lidar(robot: ET.Element) -> None:
    head = add(part(robot, "chassis"), '<body name="lidar" pos="0 0 0.09"/>')
    add(head, _INERTIAL.format(0.1, 1e-5, 1e-5, 2e-5))
    add(head, '<joint name="lidar_spin" axis="0 0 1" damping="1e-4"/>')
    add(head, '<geom name="lidar_head" type="cylinder" size="0.02 0.01"/>')
    add(head, '<site name="beam" pos="0.02 0 0"/>')
    sensors = ET.Element("sensor")
    add(sensors, '<rangefinder name="hull" site="beam"/>')
    robot.append(sensors)
    add(section(robot, "actuator"), '<velocity name="lidar_motor" joint="lidar_spin" kv="0.01"/>')


@habit("world")
def floor_light_and_goal(robot: ET.Element) -> None:
    world = section(robot, "worldbody")
    add(world, '<geom name="floor" type="plane" size="5 5 0.1" condim="6"/>')
    add(world, '<light name="sun" pos="0 0 3" dir="0 0 -1"/>')
    add(world, '<camera name="above" pos="0 0 4"/>')
    add(world, '<site name="goal" pos="2 0 0" size="0.1"/>')
    robot.insert(0, ET.fromstring('<option timestep="0.005" gravity="0 0 -9" density="1.2" integrator="RK4"/>'))


@habit("world")
def under_water(robot: ET.Element) -> None:
    robot.insert(0, ET.fromstring('<option density="1000" viscosity="0.001"><flag gravity="disable"/></option>'))
    chassis = part(robot, "chassis")
    chassis.remove(part(robot, "root", "freejoint"))
    chassis.insert(0, ET.fromstring('<joint name="root" type="free" damping="2" armature="0.1"/>'))
    add(chassis, '<site name="jet" pos="-0.1 0 0"/>')
    add(section(robot, "actuator"), '<motor name="thruster" site="jet" gear="1 0 0 0 0 0"/>')


@habit("world")
def walls_and_crates(robot: ET.Element) -> None:
    world = section(robot, "worldbody")
    add(world, '<geom name="wall" type="box" size="0.1 2 0.5" pos="0.15 0 0.5" mass="100"/>')
    crate = add(world, '<body name="crate" pos="1 0 0.1"/>')
    add(crate, '<geom name="crate_box" type="box" size="0.1 0.1 0.1" mass="40"/>')
    loose = add(world, '<body name="ball" pos="1 1 0.1"/>')
    add(loose, '<freejoint name="ball_joint"/>')
    add(loose, '<geom name="ball_geom" type="sphere" size="0.1" mass="5"/>')
    marker = add(world, '<body name="marker" mocap="true" pos="0 0 1"/>')
    add(marker, '<geom name="marker_geom" type="sphere" size="0.05" contype="0" conaffinity="0"/>')


@habit("world")
def a_lamp_on_top(robot: ET.Element) -> None:
    add(part(robot, "chassis"), '<light name="lamp" pos="0.1 0 0.05" dir="1 0 -0.2"/>')
    add(part(robot, "chassis"), '<camera name="view" pos="0.1 0 0.05" quat="0.5 0.5 -0.5 -0.5"/>')


@habit("contacts")
def exclusions(robot: ET.Element) -> None:
    contact = ET.Element("contact")
    for side in ("left", "right"):
        add(contact, f'<exclude name="apart_{side}" body1="chassis" body2="{side}_wheel"/>')
    robot.append(contact)


@habit("contacts")
def pairs_with_a_floor_elsewhere(robot: ET.Element) -> None:
    contact = ET.Element("contact")
    for side in ("left", "right"):
        add(contact, f'<pair name="grip_{side}" geom1="{side}_tyre" geom2="floor" condim="3"/>')
    robot.append(contact)
