"""Writes a robot in the standard form: an MJCF of few bodies with nothing in it but what moves, touches and is seen.

A *link* is all that moves as one: the chassis, and what hangs below each joint that moves. Its frame is level and looks
ahead while the robot rests. Numbers are those that MuJoCo compiled, so that defaults, frames, inertias from geoms and
units of angles are resolved.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from nhtrack.arrays import Array
from nhtrack.robots.reading.looks import copy_assets
from nhtrack.robots.reading.shapes import SOLID
from nhtrack.robots.reading.source import Source

__all__ = ["Link", "Names", "bare", "inertia_of", "pairs_apart", "text", "write_document", "write_link"]

_ROUNDING = 1e-14  # of a sum of moments of inertia
_HIDDEN = 3  # the first group of geoms that is not drawn

_GEOM = mujoco.mjtGeom
_DEFAULT_COLOUR = (0.5, 0.5, 0.5, 1.0)


class Names:
    """Names that are each given once, without the slash that MJCF has for robots in scenes."""

    def __init__(self, taken: Sequence[str] = ()) -> None:
        self._taken = set(taken)

    def new(self, wanted: str) -> str:
        """Returns a name that nothing else has, as near as can be to the one wanted."""
        name = wanted.replace("/", "_").replace("__robot__", "robot") or "part"
        while name in self._taken:
            name += "_"
        self._taken.add(name)
        return name


@dataclass(frozen=True)
class Link:
    """What moves as one.

    Attributes:
        name: of its body.
        bodies: of the file that it is made of.
        origin: of its frame, world frame of the file [m], shape (3,).
        frame: its axes as rows in the world frame of the file, shape (3, 3).
    """

    name: str
    bodies: tuple[int, ...]
    origin: Array
    frame: Array

    def point(self, place: Array) -> Array:
        """Returns a point of the file's world in the link's frame."""
        return np.asarray(self.frame @ (place - self.origin))


def text(values: Any) -> str:
    """Returns numbers as MJCF that is read back to the last bit."""
    return " ".join(f"{float(value):.17g}" for value in np.atleast_1d(values))


def inertia_of(source: Source, link: Link) -> tuple[float, Array, Array]:
    """Returns mass [kg], centre of mass [m], shape (3,), and inertia about it [kg m^2], shape (3, 3), of a link."""
    mass, centre = source.mass_of(link.bodies)
    inertia = link.frame @ source.inertia_about(link.bodies, centre) @ link.frame.T
    return mass, link.point(centre), inertia + _rounded_off(inertia) * np.eye(3)


def _rounded_off(inertia: Array) -> float:
    """Returns what a disc's inertia lacks after rounding: its largest moment is the sum of the others, and no more."""
    trace = float(np.trace(inertia))
    excess = 2 * float(np.linalg.eigvalsh(inertia)[-1]) - trace
    return max(excess, 0.0) + _ROUNDING * trace if abs(excess) < 1e-6 * trace else 0.0


def write_link(
    source: Source, link: Link, parent: ET.Element, place: Array, names: Names, touches: Callable[[int], bool]
) -> tuple[ET.Element, dict[int, str]]:
    """Writes the body of a link with its inertia, cameras and geoms; returns it, and the geoms' names by their ids.

    Args:
        source: the file.
        link: the link.
        parent: what its body hangs in.
        place: of its frame in its parent's [m], shape (3,).
        names: of geoms and cameras given so far.
        touches: whether a geom can touch anything in the standard form; all others are only seen.
    """
    body = ET.SubElement(parent, "body", name=link.name, pos=text(place))
    mass, centre, inertia = inertia_of(source, link)
    six = [inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2], inertia[1, 2]]
    ET.SubElement(body, "inertial", pos=text(centre), mass=text(mass), fullinertia=text(six))
    for camera in range(source.model.ncam):
        if int(source.model.cam_bodyid[camera]) in link.bodies:
            _write_camera(source, link, body, camera, names)
    written = dict[int, str]()
    for geom in range(source.model.ngeom):
        seen = touches(geom) or source.model.geom_group[geom] < _HIDDEN
        if int(source.model.geom_bodyid[geom]) in link.bodies and seen and _is_drawn(source, geom):
            written[geom] = _write_geom(source, link, body, geom, names, touches=touches(geom))
    return body, written


def _is_drawn(source: Source, geom: int) -> bool:
    return _GEOM(int(source.model.geom_type[geom])) in SOLID


def quaternion(rotation: Array) -> Array:
    """Returns the unit quaternion (w, x, y, z) of a rotation matrix, shape (4,)."""
    found = np.zeros(4)
    mujoco.mju_mat2Quat(found, np.ascontiguousarray(rotation).ravel())
    return found


def _write_geom(source: Source, link: Link, body: ET.Element, geom: int, names: Names, *, touches: bool) -> str:
    """Writes a geom of the file, and returns its name."""
    model = source.model
    centre, rotation = source.place(geom)
    name = names.new(source.name("geom", geom))
    kind = _GEOM(int(model.geom_type[geom]))
    element = ET.SubElement(body, "geom", name=name, type=kind.name.removeprefix("mjGEOM_").lower())
    if kind == _GEOM.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        own = np.zeros(9)
        mujoco.mju_quat2Mat(own, model.mesh_quat[mesh])
        rotation = rotation @ own.reshape(3, 3).T
        centre = centre - rotation @ model.mesh_pos[mesh]
        element.set("mesh", model.mesh(mesh).name)
    else:
        element.set("size", text(model.geom_size[geom]))
    element.set("pos", text(link.point(centre)))
    element.set("quat", text(quaternion(link.frame @ rotation)))
    if model.geom_matid[geom] >= 0:
        element.set("material", model.mat(int(model.geom_matid[geom])).name)
    if model.geom_matid[geom] < 0 or not np.allclose(model.geom_rgba[geom], _DEFAULT_COLOUR):
        element.set("rgba", text(np.round(model.geom_rgba[geom].astype(float), 6)))
    element.set("group", str(int(model.geom_group[geom])))
    if touches:
        element.set("friction", text(model.geom_friction[geom]))
        element.set("condim", str(int(model.geom_condim[geom])))
    else:
        element.set("contype", "0")
        element.set("conaffinity", "0")
    return name


def _write_camera(source: Source, link: Link, body: ET.Element, camera: int, names: Names) -> None:
    model = source.model
    if model.cam_mode[camera] != mujoco.mjtCamLight.mjCAMLIGHT_FIXED:
        return
    rotation = np.array(source.data.cam_xmat[camera]).reshape(3, 3)
    ET.SubElement(
        body, "camera", name=names.new(model.camera(camera).name), pos=text(link.point(source.data.cam_xpos[camera])),
        quat=text(quaternion(link.frame @ rotation)), fovy=text(model.cam_fovy[camera]),
    )  # fmt: skip


def write_document(source: Source, fill: Callable[[ET.Element], None], *sections: ET.Element | None) -> str:
    """Returns the text of a standard form.

    Args:
        source: the file that it is made of.
        fill: writes the robot into the element `worldbody` that it is given.
        sections: what stands after it.
    """
    root = ET.Element("mujoco", model="robot")
    ET.SubElement(root, "compiler", angle="radian", autolimits="false")
    fill(ET.SubElement(root, "worldbody"))
    root.extend(each for each in sections if each is not None)
    copy_assets(source, root)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode")


def pairs_apart(links: Sequence[str], joined: Sequence[tuple[str, str]]) -> Iterator[tuple[str, str]]:
    """Yields the pairs of links that do not hang on each other."""
    together = {frozenset(pair) for pair in joined}
    for i, one in enumerate(links):
        for two in links[i + 1 :]:
            if frozenset((one, two)) not in together:
                yield one, two


def bare(mjcf: str) -> str:
    """Returns a standard form without what is only seen, which compiles in no time whatever its meshes are."""
    root = ET.fromstring(mjcf)
    for body in root.iter("body"):
        for geom in body.findall("geom"):
            if geom.get("contype") == "0" and geom.get("conaffinity") == "0":
                body.remove(geom)
            else:
                geom.attrib.pop("material", None)
    used = {geom.get("mesh") for geom in root.iter("geom")}
    for assets in root.findall("asset"):
        for each in list(assets):
            if each.tag != "mesh" or each.get("name") not in used:
                assets.remove(each)
    return ET.tostring(root, encoding="unicode")
