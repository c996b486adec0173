"""Habits of wheels: shapes of tyres, frames and axes of wheel bodies, where a chassis has its origin and points."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Callable

from nhtrack.robots.contract import Hints
from odd_robots.habit import habit
from odd_robots.plain import SIDES, add, part, reframe, section, turn

_ROLLED = "0.7071067811865476 0.7071067811865476 0 0"  # a cylinder's axis from z to y


def _tyres(**attributes: str) -> Callable[[ET.Element], None]:
    def change(robot: ET.Element) -> None:
        for side in SIDES:
            tyre = part(robot, f"{side}_tyre")
            for name, value in attributes.items():
                tyre.set(name, value)

    return change


@habit("tyres")
def cylinder_tyres(robot: ET.Element) -> None:
    _tyres(type="cylinder", size="0.05 0.01", quat=_ROLLED)(robot)


@habit("tyres")
def sphere_tyres(robot: ET.Element) -> None:
    _tyres(type="sphere", size="0.05")(robot)


@habit("tyres")
def capsule_tyres(robot: ET.Element) -> None:
    _tyres(type="capsule", size="0.05 0.004", quat=_ROLLED)(robot)


@habit("tyres")
def ellipsoid_tyres_in_another_order(robot: ET.Element) -> None:
    _tyres(size="0.05 0.05 0.01", quat=_ROLLED)(robot)


@habit("tyres")
def mesh_tyres(robot: ET.Element) -> None:
    # The polygon has a corner straight below: its radius is that of its corners.
    rim = [(0.05 * math.sin(math.tau * k / 48), 0.05 * math.cos(math.tau * k / 48)) for k in range(48)]
    points = " ".join(f"{x!r} {y} {z!r}" for y in (-0.008, 0.008) for x, z in rim)
    add(section(robot, "asset"), f'<mesh name="tyre" vertex="{points}"/>')
    for side in SIDES:
        tyre = part(robot, f"{side}_tyre")
        tyre.attrib.pop("size")
        tyre.set("type", "mesh")
        tyre.set("mesh", "tyre")


@habit("tyres", half_separation=0.1125)
def tyres_beside_their_bodies(robot: ET.Element) -> None:
    for side, place in zip(SIDES, ("0 0.0125 0", "0 -0.0125 0"), strict=True):
        part(robot, f"{side}_tyre").set("pos", place)


@habit("tyres")
def tyres_of_two_parts(robot: ET.Element) -> None:
    for side in SIDES:
        add(
            part(robot, f"{side}_wheel"),
            f'<geom name="{side}_hub" type="cylinder" size="0.03 0.012" quat="{_ROLLED}"/>',
        )


@habit("tyres")
def tyres_that_are_only_touched(robot: ET.Element) -> None:
    _tyres(contype="0", conaffinity="1", condim="6", friction="0.8 0.02 0.01", priority="2")(robot)


@habit("tyres")
def drawn_rims(robot: ET.Element) -> None:
    # Larger than the tyres, as drawings may be, and touching nothing.
    for side in SIDES:
        add(
            part(robot, f"{side}_wheel"),
            f'<geom name="{side}_rim" type="cylinder" size="0.051 0.012" quat="{_ROLLED}" '
            'contype="0" conaffinity="0" mass="0"/>',
        )


@habit("axes")
def rolled_wheels(robot: ET.Element) -> None:
    for side in SIDES:
        reframe(part(robot, f"{side}_wheel"), rotation=turn("x", -90))


@habit("axes")
def wheels_rolled_by_157_hundredths(robot: ET.Element) -> None:
    # Files that write 1.57 for pi/2 tilt their axles by 0.8 mrad.
    for side in SIDES:
        wheel = part(robot, f"{side}_wheel")
        reframe(wheel, rotation=turn("x", -90))
        wheel.set("quat", "0.7073882691671998 -0.706825181105366 0 0")


@habit("axes")
def axes_to_the_right(robot: ET.Element) -> None:
    for side in SIDES:
        part(robot, f"{side}_axle").set("axis", "0 -1 0")


@habit("axes")
def mirrored_axes(robot: ET.Element) -> None:
    part(robot, "right_axle").set("axis", "0 -1 0")


def _on_its_head(robot: ET.Element, side: str) -> None:
    """Turns a wheel's body by half a turn about x, and so the sense of its axis."""
    axis = part(robot, f"{side}_axle").get("axis", "")
    reframe(part(robot, f"{side}_wheel"), rotation=turn("x", 180))
    part(robot, f"{side}_axle").set("axis", axis)


@habit("axes")
def wheels_on_their_heads(robot: ET.Element) -> None:
    for side in SIDES:
        _on_its_head(robot, side)


@habit("axes")
def one_wheel_on_its_head(robot: ET.Element) -> None:
    _on_its_head(robot, "left")


@habit("axes")
def long_axes(robot: ET.Element) -> None:
    for side in SIDES:
        part(robot, f"{side}_axle").set("axis", "0 3 0")


@habit("axes")
def turned_to_begin_with(robot: ET.Element) -> None:
    for side in SIDES:
        part(robot, f"{side}_axle").attrib |= {"ref": "0.3", "springref": "0.2"}


@habit("axes")
def hinges_beside_their_bodies(robot: ET.Element) -> None:
    for side in SIDES:
        reframe(part(robot, f"{side}_wheel"), pos=(0.02, 0.01, -0.03))


@habit("origin")
def origin_on_the_floor(robot: ET.Element) -> None:
    reframe(part(robot, "chassis"), pos=(0, 0, -0.05))


@habit("origin")
def origin_at_the_centre(robot: ET.Element) -> None:
    reframe(part(robot, "chassis"), pos=(-0.03, 0.004, 0.03))


@habit("origin")
def origin_on_the_floor_of_a_base_within(robot: ET.Element) -> None:
    chassis = part(robot, "chassis")
    reframe(chassis, pos=(0, 0, -0.05))
    inner = ET.Element("body", {"name": "inner", "pos": "0 0 0.01"})
    for child in [each for each in chassis if each.get("name") != "root"]:
        chassis.remove(child)
        inner.append(child)
    reframe(inner, pos=(0, 0, 0.01))
    inner.set("pos", "0 0 0.01")
    chassis.append(inner)


@habit("heading", hints=Hints(forward="-x"), forward="-x")
def tail_first(robot: ET.Element) -> None:
    reframe(part(robot, "chassis"), rotation=turn("z", 180))


@habit("heading", forward="y")
def ahead_is_y(robot: ET.Element) -> None:
    reframe(part(robot, "chassis"), rotation=turn("z", -90))


@habit("heading", forward="-y")
def ahead_is_minus_y(robot: ET.Element) -> None:
    reframe(part(robot, "chassis"), rotation=turn("z", 90))


@habit("heading")
def placed_elsewhere(robot: ET.Element) -> None:
    chassis = part(robot, "chassis")
    chassis.set("pos", "3 -2 1")
    chassis.set("euler", "0 0 140")
