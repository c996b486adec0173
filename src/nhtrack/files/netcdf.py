"""netCDF files that are somebody else's: opened where what they claim to hold is in them, and nowhere else.

An HDF5 file may take its numbers from other files, by links, by external storage, by views of other datasets; and a few
bytes of it may stand for any number of them.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import h5py
    import xarray as xr

__all__ = ["opened"]

_MOST_ITEMS = 1000  # variables of a file, or attributes of one of them
_MOST_TEXTS = 32  # in one attribute, each of which may be the same large one
_LONGEST = 10**7  # along one dimension: a scenario has at most 2e6 control periods
_MOST_CHUNK = 2**28  # bytes that are read together
_DEFLATED = 1100  # bytes that deflate makes one of, at most, with something to spare
_MOST_NAMES = 50_000
_SPARE = 2**16  # bytes that need not be in a file, where it says what it is filled with
_FILTERS = (1, 2, 3)  # deflate, shuffle, fletcher32
_NO_VARIABLE = b"This is a netCDF dimension but not a netCDF variable"


def opened(source: Path) -> xr.Dataset:
    """Returns the dataset of a file, which is read when it is asked for, anew each time.

    Raises:
        ValueError: it takes its numbers from elsewhere, or claims more than there is in it; the message says where.
        Exception: whatever HDF5 and those that read it say of damage.
    """
    import h5py  # takes long to import, as xarray does
    import xarray as xr

    with h5py.File(source) as file:  # where this fails h5netcdf leaves half an object, which prints a traceback
        _require_plain(file, source.stat().st_size)
    return xr.open_dataset(source, engine="h5netcdf", cache=False)


def _require_plain(file: h5py.File, size: int) -> None:
    import h5py

    _require_few_attributes(file, "")
    if len(file) > _MOST_ITEMS:
        raise ValueError(f"{len(file)} variables, more than {_MOST_ITEMS}")
    stored = 0
    for name in file:
        if not isinstance(file.get(name, getlink=True), h5py.HardLink):
            raise ValueError(f"{name}: a link to elsewhere")
        kind = file.get(name, getclass=True)
        if kind is h5py.Group:
            continue  # nobody reads it
        if kind is not h5py.Dataset:
            raise ValueError(f"{name}: no variable")
        _require_few_attributes(file[name], f"{name}: ")
        if not bytes(file[name].attrs.get("NAME", b"")).startswith(_NO_VARIABLE):
            stored += _stored(file[name], size)
    if stored > size:
        raise ValueError(f"its variables have {stored} bytes of a file of {size}")


def _require_few_attributes(owner: Any, at: str) -> None:
    """Raises ValueError where attributes would be more than the file when they are read."""
    import h5py

    if len(owner.attrs) > _MOST_ITEMS:
        raise ValueError(f"{at}{len(owner.attrs)} attributes, more than {_MOST_ITEMS}")
    for name in owner.attrs:
        kept = owner.attrs.get_id(name)
        if h5py.check_vlen_dtype(kept.dtype) or h5py.check_string_dtype(kept.dtype):
            if math.prod(kept.shape) > _MOST_TEXTS:
                raise ValueError(f"{at}attribute {name!r} has more than {_MOST_TEXTS} parts")


def _stored(variable: h5py.Dataset, size: int) -> int:
    """Returns how many bytes of the file a variable has.

    Raises:
        ValueError: its numbers are elsewhere, or it is no array of plain numbers or texts, or of more than there is.
    """
    import h5py

    name, properties = str(variable.name).removeprefix("/"), variable.id.get_create_plist()
    if variable.external or variable.is_virtual:
        raise ValueError(f"{name}: lies in other files")
    filters = {properties.get_filter(i)[0] for i in range(properties.get_nfilters())}
    if not filters <= set(_FILTERS):
        raise ValueError(f"{name}: is compressed by what is none of deflate, shuffle, fletcher32")
    text = h5py.check_string_dtype(variable.dtype)
    if text is None and (variable.dtype.kind not in "fiu" or variable.dtype.itemsize > 8):
        raise ValueError(f"{name}: neither numbers nor text")
    if variable.shape is None or max(variable.shape, default=0) > _LONGEST:
        raise ValueError(f"{name}: is longer than {_LONGEST:g}, or of no length")
    claimed, stored = variable.size * variable.dtype.itemsize, int(variable.id.get_storage_size())
    if claimed > _DEFLATED * stored + _SPARE:
        raise ValueError(f"{name}: claims {claimed} bytes, of which there are {stored}")
    if math.prod(variable.chunks or ()) * variable.dtype.itemsize > _MOST_CHUNK:
        raise ValueError(f"{name}: is to be read by more than {_MOST_CHUNK} bytes at once")
    if text is not None and text.length is None:
        _require_short(variable, name, size)
    return stored


def _require_short(variable: h5py.Dataset, name: str, size: int) -> None:
    """Raises ValueError where texts, many of which may be the same place of the file, are longer than the file."""
    length, count = 0, variable.size
    if count > _MOST_NAMES:
        raise ValueError(f"{name}: {count} texts, more than {_MOST_NAMES}")
    for place in np.ndindex(variable.shape):
        length += len(variable[place])
        if length > size:
            raise ValueError(f"{name}: its texts are longer than the file")
