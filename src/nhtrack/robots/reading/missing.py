"""Files that a robot's file speaks of and that are not there: what is only drawn with them is left out."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from nhtrack.errors import RobotError

__all__ = ["leave_out_missing"]

_SHOWN = 3  # files that a message names


def leave_out_missing(spec: Any, file: Path) -> Iterator[str]:
    """Takes out of a spec what cannot be drawn without missing files; yields which, in a sentence.

    Args:
        spec: the elements of a file; changed.
        file: where it stands.

    Raises:
        RobotError: what touches or weighs is missing.
    """
    folder = file.absolute().parent
    lost = [each for each in spec.meshes if each.file and not (folder / spec.meshdir / each.file).is_file()]
    drawings, needed = list[str](), list[str]()
    for mesh in lost:
        users = [geom for geom in spec.geoms if geom.meshname == (mesh.name or Path(mesh.file).stem)]
        if all(_is_drawing(geom) for geom in users):
            drawings.append(mesh.file)
            for each in (*users, mesh):
                spec.delete(each)
        else:
            needed.append(f"mesh file {folder / spec.meshdir / mesh.file}")
    needed += [f"height field file {name}" for name in _of(spec.hfields, folder / spec.meshdir)]
    if needed:
        raise RobotError(f"{file}: cannot find {_listed(needed)}: put them there, or correct the file's paths")
    for texture in list(spec.textures):
        pictures = list(_of([texture], folder / spec.texturedir))
        if pictures:
            drawings += [picture.name for picture in pictures]
            _delete_texture(spec, texture)
    if drawings:
        yield f"not drawn, since their files cannot be found: {_listed(drawings)}"


def _is_drawing(geom: Any) -> bool:
    """Whether a geom neither touches nor weighs anything."""
    weighs = not geom.parent.explicitinertial and geom.mass != 0 and (geom.density > 0 or geom.mass > 0)
    return not (geom.contype or geom.conaffinity or weighs)


def _of(elements: Any, folder: Path) -> Iterator[Path]:
    """Yields the missing files of elements."""
    for each in elements:
        for name in (each.file, *getattr(each, "cubefiles", ())):
            if name and not (folder / name).is_file():
                yield folder / name


def _delete_texture(spec: Any, texture: Any) -> None:
    for material in spec.materials:
        material.textures = ["" if name == texture.name else name for name in material.textures]
    spec.delete(texture)


def _listed(names: list[str]) -> str:
    """Returns the first few of many names, and how many more there are."""
    found = list(dict.fromkeys(names))
    more = len(found) - _SHOWN
    return "; ".join(found[:_SHOWN]) + (f" and {more} more" if more > 0 else "")
