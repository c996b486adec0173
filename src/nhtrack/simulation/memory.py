"""Where MuJoCo's library and the members of its structures are in memory, for compiled code that steps it directly."""

from __future__ import annotations

import ctypes
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np

_SCALARS: dict[str, Any] = {
    "double": ctypes.c_double, "mjtNum": ctypes.c_double, "int": ctypes.c_int, "float": ctypes.c_float,
    "mjtSize": ctypes.c_int64, "mjtBool": ctypes.c_bool, "size_t": ctypes.c_size_t, "uintptr_t": ctypes.c_size_t,
    "mjtByte": ctypes.c_ubyte,
}  # fmt: skip


class Layout(NamedTuple):
    """Distances in bytes: of members from the beginning of mjData or of an mjContact, and from contact to contact.

    What `efc_spare` points to has room for a number of each constraint, which `mj_step2` writes before it reads them.
    """

    ncon: int
    contact: int
    efc_force: int
    warning: int
    warning_size: int
    warning_number: int
    contact_size: int
    frame: int
    geom: int
    efc_address: int
    distance: int
    efc_velocity: int
    efc_reference: int
    efc_spare: int
    time: int


@cache
def address_in_library(function: str) -> int:
    """Returns the address of one of MuJoCo's functions.

    Raises:
        OSError: the library of the mujoco package cannot be found.
        AttributeError: it has no such function.
    """
    return int(ctypes.cast(getattr(library(), function), ctypes.c_void_p).value or 0)


@cache
def library() -> ctypes.CDLL:
    """Returns the MuJoCo library that the package has loaded."""
    folder = Path(mujoco.__file__).parent
    for pattern in ("libmujoco.so*", "libmujoco*.dylib", "mujoco.dll"):
        for file in sorted(folder.glob(pattern)):
            return ctypes.CDLL(str(file))
    raise OSError(f"no MuJoCo library in {folder}")


@cache
def layout() -> Layout:
    """Returns where the members of MuJoCo's structures are, from its own description of them.

    Raises:
        RuntimeError: a step does not find there what the package says of the same members.
    """
    data, contact, warning = _structure("mjData"), _structure("mjContact"), _structure("mjWarningStat")
    found = Layout(
        ncon=data.ncon.offset,
        contact=data.contact.offset,
        efc_force=data.efc_force.offset,
        warning=data.warning.offset,
        warning_size=ctypes.sizeof(warning),
        warning_number=warning.number.offset,
        contact_size=ctypes.sizeof(contact),
        frame=contact.frame.offset,
        geom=contact.geom.offset,
        efc_address=contact.efc_address.offset,
        distance=contact.dist.offset,
        efc_velocity=data.efc_vel.offset,
        efc_reference=data.efc_aref.offset,
        efc_spare=data.efc_b.offset,
        time=data.time.offset,
    )
    _verify(found)
    return found


@cache
def _structure(name: str) -> Any:
    """Returns a structure of MuJoCo's headers as ctypes lays it out."""
    from mujoco.introspect import ast_nodes, structs  # only here: it is large

    def ctype(kind: Any) -> Any:
        if isinstance(kind, ast_nodes.PointerType):
            return ctypes.c_void_p
        if isinstance(kind, ast_nodes.ArrayType):
            inner = ctype(kind.inner_type)
            for extent in reversed(kind.extents):
                inner = inner * extent
            return inner
        if isinstance(kind, ast_nodes.ValueType):
            return _SCALARS[kind.name] if kind.name in _SCALARS else _enum_or_structure(kind.name)
        raise TypeError(f"{name}: no layout for {kind}")

    def _enum_or_structure(inner: str) -> Any:
        return _structure(inner) if inner in structs.STRUCTS else ctypes.c_int

    fields = [(field.name, ctype(field.type)) for field in structs.STRUCTS[name].fields]
    return type(name, (ctypes.Structure,), {"_fields_": fields})


def _verify(found: Layout) -> None:
    """Compares what is read by address with what the package says, on a ball that lies on a plane."""
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><geom type='plane' size='1 1 1'/><body pos='0 0 .099'><freejoint/>"
        "<geom name='ball' size='.1'/></body></worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    data.warning[2].number = 7
    contacts = _read(ctypes.c_void_p, data._address + found.contact)
    seen = {
        "ncon": (_read(ctypes.c_int, data._address + found.ncon), data.ncon),
        "efc_force": (_read(ctypes.c_void_p, data._address + found.efc_force), data.efc_force.ctypes.data),
        "contact.frame": (contacts + found.frame, data.contact.frame.ctypes.data),
        "contact.geom": (contacts + found.geom, data.contact.geom.ctypes.data),
        "contact.efc_address": (contacts + found.efc_address, data.contact.efc_address.ctypes.data),
        "contact.dist": (contacts + found.distance, data.contact.dist.ctypes.data),
        "efc_vel": (_read(ctypes.c_void_p, data._address + found.efc_velocity), data.efc_vel.ctypes.data),
        "efc_aref": (_read(ctypes.c_void_p, data._address + found.efc_reference), data.efc_aref.ctypes.data),
        "efc_b": (_read(ctypes.c_void_p, data._address + found.efc_spare), data.efc_b.ctypes.data),
        "time": (_read(ctypes.c_double, data._address + found.time), data.time),
        "mjContact": (found.contact_size, data.contact.frame.strides[0]),
        "warning": (
            _read(ctypes.c_int, data._address + found.warning + 2 * found.warning_size + found.warning_number), 7
        ),
    }  # fmt: skip
    wrong = [name for name, (here, there) in seen.items() if here != there]
    if wrong:
        raise RuntimeError(f"MuJoCo {mujoco.__version__} keeps {', '.join(wrong)} elsewhere than its description says")


def _read(kind: Any, address: int) -> Any:
    return kind.from_address(address).value


def address_of(array: np.ndarray) -> int:
    """Returns where the values of an array begin."""
    return int(array.ctypes.data)
