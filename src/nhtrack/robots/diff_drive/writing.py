"""Writes a differential drive in the standard form: chassis, two wheels, casters, two motors.

The chassis' frame lies at the axle's middle, x ahead, y left, z up. Tyres are thin ellipsoids, which touch the floor in
one point and turn on it freely; fixed casters are spheres without friction; those on swivels are thin ellipsoids, too.
What the file draws them with stays, to be seen.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass

import mujoco
import numpy as np

from nhtrack.arrays import Array
from nhtrack.robots.contract import Parts
from nhtrack.robots.diff_drive.roles import Roles
from nhtrack.robots.diff_drive.stance import Stance, Support
from nhtrack.robots.diff_drive.tyres import Axle, Tyre
from nhtrack.robots.reading.source import Source
from nhtrack.robots.reading.standard import Link, Names, pairs_apart, text, write_document, write_link

__all__ = ["Found", "write_robot"]

_THIN = 0.125  # half width of a tyre over its radius, where the file's is no ellipsoid
_BALL = 0.25  # radius of a caster over that of the wheels, where the file's is no sphere
_SIDES = ("left", "right")
_CHASSIS = -1  # the link that no joint moves


@dataclass(frozen=True)
class Found:
    """What was found in a file, of which the standard form is made."""

    source: Source
    roles: Roles
    axle: Axle
    stance: Stance

    @property
    def tyres(self) -> dict[int, tuple[str, Tyre]]:
        """Side and tyre by the joint that turns it."""
        return {t.joint: (side, t) for side, t in zip(_SIDES, (self.axle.left, self.axle.right), strict=True)}

    def link_of(self, geom: int) -> int:
        """Returns the joint that a geom moves with."""
        return self.roles.link_of(self.source, int(self.source.model.geom_bodyid[geom]))


def write_robot(found: Found) -> tuple[str, Parts, dict[str, str]]:
    """Returns the standard form of a robot, the names of its parts, and the elements that each was read from."""
    links, supports = _links(found), found.stance.supports
    casters = {s.geom: "caster" if len(supports) == 1 else f"caster_{k}" for k, s in enumerate(supports, start=1)}
    tyres = tuple(f"{side}_tyre" for side in _SIDES)
    names, solid = Names((*tyres, *casters.values())), list[str]()

    def touches(geom: int) -> bool:
        return found.source.collides(geom) and found.link_of(geom) not in found.tyres and geom not in casters

    def fill(root: ET.Element) -> None:
        bodies = dict[int, ET.Element]()
        for joint, link in links.items():
            above = _above(found, joint)
            parent, origin = (root, link.origin) if above is None else (bodies[above], links[above].origin)
            bodies[joint], written = write_link(
                found.source, link, parent, link.frame @ (link.origin - origin), names, touches
            )
            solid.extend(name for geom, name in written.items() if touches(geom))
            _write_joint(found, joint, bodies[joint])
        for joint, (side, tyre) in found.tyres.items():
            size = (found.axle.radius, _half_width(found, tyre), found.axle.radius)
            _write_contact(bodies[joint], f"{side}_tyre", "ellipsoid", size)
        for support in supports:
            _write_support(found, support, links[support.link], bodies[support.link], casters[support.geom])

    mjcf = write_document(found.source, fill, _motors(), _apart(found, links))
    parts = Parts(
        chassis="chassis",
        wheel_joints=("left_wheel", "right_wheel"),
        motors=("left_motor", "right_motor"),
        tyres=(tyres[0], tyres[1]),
        casters=tuple(casters.values()),
        collision_geoms=(*solid, *casters.values(), *tyres),
        rolling_casters=tuple(casters[s.geom] for s in supports if _rolls(found, s)),
    )
    return mjcf, parts, _sources(found, casters)


def _links(found: Found) -> dict[int, Link]:
    """Returns the links by the joint that moves them, those that others hang on first."""
    source, axle, names = found.source, found.axle, Names(("chassis", "left_wheel", "right_wheel"))
    bodies: dict[int, list[int]] = {_CHASSIS: []}
    for body in source.subtree(found.roles.root):
        bodies.setdefault(found.roles.link_of(source, body), []).append(body)
    links = dict[int, Link]()
    for joint, its in bodies.items():
        if joint == _CHASSIS:
            name, origin = "chassis", axle.centre
        elif joint in found.tyres:
            side, tyre = found.tyres[joint]
            name = f"{side}_wheel"
            origin = axle.centre + (tyre.centre - axle.centre) @ axle.frame[1] * axle.frame[1]
        else:
            name, origin = names.new(source.name("body", int(source.model.jnt_bodyid[joint]))), source.anchor(joint)
        links[joint] = Link(name, tuple(its), origin, found.stance.frame)
    return links


def _above(found: Found, joint: int) -> int | None:
    """Returns the link that a link hangs on, by its joint; None for the chassis, which hangs on nothing."""
    if joint == _CHASSIS:
        return None
    source = found.source
    body = int(source.model.jnt_bodyid[joint])
    before = [j for j in source.joints_of(body) if j < joint and j in found.roles.swivels]
    return before[-1] if before else found.roles.link_of(source, int(source.model.body_parentid[body]))


def _write_joint(found: Found, joint: int, body: ET.Element) -> None:
    """Writes the joint of a link as its first element."""
    if joint == _CHASSIS:
        body.insert(0, ET.Element("freejoint", name="root"))
        return
    source, model = found.source, found.source.model
    dof = int(model.jnt_dofadr[joint])
    driven = joint in found.tyres
    name = f"{found.tyres[joint][0]}_wheel" if driven else f"{body.get('name')}_turn"
    axis = np.array([0.0, 1.0, 0.0]) if driven else found.stance.frame @ source.axis(joint)
    element = ET.Element("joint", name=name, type="hinge", axis=text(axis))
    element.set("armature", text(model.dof_armature[dof] + _of_actuators(found, joint, "armature")))
    element.set("damping", text(model.dof_damping[dof] + _of_actuators(found, joint, "damping")))
    element.set("frictionloss", text(model.dof_frictionloss[dof]))
    if model.jnt_stiffness[joint]:
        element.set("stiffness", text(model.jnt_stiffness[joint]))
    body.insert(0, element)


def _of_actuators(found: Found, joint: int, name: str) -> float:
    """Returns what actuators add to the armature or damping of a joint."""
    values = getattr(found.source.model, f"actuator_{name}")
    return float(sum(values[p.actuator] * p.ratio**2 for p in found.roles.pulls if p.joint == joint))


def _half_width(found: Found, tyre: Tyre) -> float:
    """Returns the half width of a tyre: the file's where that is an ellipsoid about the axle [m]."""
    source, model = found.source, found.source.model
    for geom in tyre.geoms:
        if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_ELLIPSOID:
            return float(source.reach(geom, tyre.axis, tyre.centre))
    return _THIN * tyre.radius


def _write_contact(body: ET.Element, name: str, kind: str, size: tuple[float, ...], place: Array | None = None) -> None:
    """Writes a geom that touches the floor and is not seen."""
    at = np.zeros(3) if place is None else place
    ET.SubElement(
        body, "geom", name=name, type=kind, size=text(size), pos=text(at), group="3", rgba="0.25 0.65 0.95 0.3",
        friction="1 0.005 0.0001",
    )  # fmt: skip


def _rolls(found: Found, support: Support) -> bool:
    """Whether a caster is a wheel that a swivel carries: it moves with a hinge that is not upright."""
    return support.link != _CHASSIS and abs(float(found.source.axis(support.link)[2])) < 0.5


def _write_support(found: Found, support: Support, link: Link, body: ET.Element, name: str) -> None:
    """Writes a caster: the wheel of a swivel, or a sphere that slides."""
    model, touch = found.source.model, support.place - (link.frame @ (link.origin - found.axle.centre))
    if _rolls(found, support):
        axis = link.frame @ found.source.axis(support.link)
        radius = float(-touch[2])
        along = float(touch @ axis)
        element = ET.SubElement(body, "geom", name=name, type="ellipsoid", group="3", rgba="0.25 0.65 0.95 0.3")
        element.set("size", text((radius, _THIN * radius, radius)))
        element.set("pos", text(along * axis))
        element.set("zaxis", text(np.cross(axis, [0.0, 0.0, 1.0])))
        return
    sphere = model.geom_type[support.geom] == mujoco.mjtGeom.mjGEOM_SPHERE
    radius = float(model.geom_size[support.geom, 0]) if sphere else _BALL * found.axle.radius
    _write_contact(body, name, "sphere", (radius,), touch + np.array([0.0, 0.0, radius]))


def _motors() -> ET.Element:
    actuators = ET.Element("actuator")
    for side in _SIDES:
        ET.SubElement(actuators, "motor", name=f"{side}_motor", joint=f"{side}_wheel", gear="1")
    return actuators


def _apart(found: Found, links: dict[int, Link]) -> ET.Element | None:
    """Returns that parts of one robot do not touch each other, where MuJoCo would let them: beyond neighbours."""
    if not found.roles.swivels:
        return None
    joined = [(link.name, links[above].name) for j, link in links.items() if (above := _above(found, j)) is not None]
    contact = ET.Element("contact")
    for one, two in pairs_apart([link.name for link in links.values()], joined):
        ET.SubElement(contact, "exclude", body1=one, body2=two)
    return contact


def _sources(found: Found, casters: dict[int, str]) -> dict[str, str]:
    """Returns the elements of the file that parts were read from."""
    source, said = found.source, {"chassis": found.source.element("body", found.roles.root)}
    for joint, (side, tyre) in found.tyres.items():
        said[f"{side} wheel"] = source.element("joint", joint)
        said[f"{side} tyre"] = ", ".join(source.element("geom", g) for g in tyre.geoms)
    return said | {name.replace("_", " "): source.element("geom", geom) for geom, name in casters.items()}
