"""A URDF as MuJoCo reads it: the files of its meshes found, and what MuJoCo cannot read left out."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path

__all__ = ["urdf_text"]

_XACRO = "{http://"  # elements of a namespace, of which a URDF has xacro's alone
_READABLE = (".stl", ".obj", ".msh")


def urdf_text(root: ET.Element, file: Path) -> tuple[str, tuple[str, ...]]:
    """Returns the text of a URDF with full paths of its meshes, and what was left out of it, a sentence each.

    Args:
        root: its root; changed.
        file: where it stands; `package://name/...` is looked for beside and above it.
    """
    notes = list[str]()
    _fill_in(root)
    for link in root.findall("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            mesh = shape.find("geometry/mesh")
            if mesh is None:
                continue
            found = _found(mesh.get("filename", ""), file)
            if found.suffix.lower() not in _READABLE:
                link.remove(shape)
                notes.append(
                    f"the {shape.tag} {found.name} of link {link.get('name')!r} is left out: MuJoCo reads "
                    f"{', '.join(_READABLE)}"
                )
            else:
                mesh.set("filename", str(found))
    for own in root.findall("mujoco"):
        root.remove(own)
    settings = ET.SubElement(root, "mujoco")
    ET.SubElement(settings, "compiler", strippath="false", discardvisual="false", fusestatic="false")
    return ET.tostring(root, encoding="unicode"), tuple(notes)


def _fill_in(root: ET.Element) -> None:
    """Writes the defaults of xacro's arguments and properties where a URDF still asks for them."""
    known = dict[str, str]()
    for element in [each for each in root if each.tag.startswith(_XACRO)]:
        value = element.get("default") or element.get("value") or ""
        known[element.get("name", "")] = _filled(value, known)
        root.remove(element)
    for element in root.iter():
        for name, value in element.items():
            element.set(name, _filled(value, known))


def _filled(value: str, known: Mapping[str, str]) -> str:
    return re.sub(r"\$\{(\w+)\}|\$\(arg (\w+)\)", lambda at: known.get(at[1] or at[2], at[0]), value)


def _found(name: str, file: Path) -> Path:
    """Returns the full path of a mesh."""
    folder = file.absolute().parent
    if name.startswith("file://"):
        return Path(name.removeprefix("file://"))
    if not name.startswith("package://"):
        return folder / name
    package, _, inside = name.removeprefix("package://").partition("/")
    for above in (folder, *folder.parents):
        if above.name == package and (above / inside).is_file():
            return above / inside
        if (above / package / inside).is_file():
            return above / package / inside
    beside = [above / inside for above in (folder, *folder.parents) if (above / inside).is_file()]
    return beside[0] if beside else folder / package / inside
