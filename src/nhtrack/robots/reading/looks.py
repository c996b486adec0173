"""Meshes, materials and textures of a robot's file, written into its standard form."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from nhtrack.robots.reading.source import Source

__all__ = ["copy_assets"]


def copy_assets(source: Source, root: ET.Element) -> None:
    """Writes into a document all assets that its geoms speak of, and what these speak of."""
    assets = ET.Element("asset")
    meshes = {each.get("mesh") for each in root.iter("geom")} - {None}
    materials = {each.get("material") for each in root.iter("geom")} - {None}
    textures = set[str]()
    for each in source.spec.materials:
        if each.name in materials:
            textures |= _write_material(each, assets)
    for each in source.spec.textures:
        if each.name in textures:
            _write_texture(source, each, assets)
    for each in source.spec.meshes:
        name = each.name or Path(each.file).stem
        if name in meshes:
            _write_mesh(source, each, name, assets)
    if len(assets):
        root.insert(1, assets)
        _without_slashes(root, assets)


def _without_slashes(root: ET.Element, assets: ET.Element) -> None:
    """Gives assets other names where theirs have a slash, which MJCF has for robots in scenes."""
    for kind in ("mesh", "material", "texture"):
        taken = {each.get("name", "") for each in assets.findall(kind)}
        for asset in assets.findall(kind):
            old = asset.get("name", "")
            new = old.replace("/", "_")
            while new != old and new in taken:
                new += "_"
            taken.add(new)
            asset.set("name", new)
            for user in root.iter():
                if user.get(kind) == old:
                    user.set(kind, new)


def _numbers(values: Any) -> str:
    return " ".join(f"{float(value):.9g}" for value in np.atleast_1d(values))


def _write_material(material: Any, assets: ET.Element) -> set[str]:
    """Writes a material, and returns the textures that it has."""
    element = ET.SubElement(assets, "material", name=material.name, rgba=_numbers(material.rgba))
    for name in ("emission", "specular", "shininess", "reflectance", "metallic", "roughness"):
        if getattr(material, name) >= 0:  # below 0 for none
            element.set(name, _numbers(getattr(material, name)))
    used = [each for each in material.textures if each]
    if used:
        element.set("texture", used[0])
        element.set("texrepeat", _numbers(material.texrepeat))
        element.set("texuniform", "true" if material.texuniform else "false")
    return set(used[:1])


def _write_texture(source: Source, texture: Any, assets: ET.Element) -> None:
    kind = mujoco.mjtTexture(int(texture.type)).name.removeprefix("mjTEXTURE_").lower()
    element = ET.SubElement(assets, "texture", name=texture.name, type=kind)
    folder = source.file.absolute().parent / source.spec.texturedir
    sides = ("fileright", "fileleft", "fileup", "filedown", "filefront", "fileback")
    if texture.file:
        element.set("file", str(folder / texture.file))
        rows, columns = (int(count) for count in texture.gridsize)
        if rows * columns > 1:
            layout = "".join(letter if isinstance(letter, str) else chr(letter) for letter in texture.gridlayout)
            element.set("gridsize", f"{rows} {columns}")
            element.set("gridlayout", layout[: rows * columns])
    elif any(texture.cubefiles):
        for side, name in zip(sides, texture.cubefiles, strict=True):
            if name:
                element.set(side, str(folder / name))
    else:
        built = mujoco.mjtBuiltin(int(texture.builtin)).name.removeprefix("mjBUILTIN_").lower()
        marked = mujoco.mjtMark(int(texture.mark)).name.removeprefix("mjMARK_").lower()
        element.set("builtin", built)
        element.set("mark", marked)
        for name in ("rgb1", "rgb2", "markrgb", "random", "width", "height"):
            element.set(name, _numbers(getattr(texture, name)))


def _write_mesh(source: Source, mesh: Any, name: str, assets: ET.Element) -> None:
    element = ET.SubElement(assets, "mesh", name=name)
    if mesh.file:
        element.set("file", str(source.file.absolute().parent / source.spec.meshdir / mesh.file))
    for attribute, values in (
        ("vertex", mesh.uservert), ("normal", mesh.usernormal), ("texcoord", mesh.usertexcoord),
        ("face", mesh.userface),
    ):  # fmt: skip
        if len(values):
            element.set(attribute, " ".join(f"{value:.9g}" for value in values))
    for attribute in ("scale", "refpos", "refquat"):
        element.set(attribute, _numbers(getattr(mesh, attribute)))
    if mesh.smoothnormal:
        element.set("smoothnormal", "true")
    element.set("inertia", "shell")  # masses are told; a volume, which not every mesh has, is not asked for
