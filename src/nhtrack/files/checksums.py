"""Checksums of what a dataset holds, kept with it, so that whoever reads it notices a changed byte."""

from __future__ import annotations

import json
import zlib
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["CHECKSUMS", "checked", "with_checksums"]

CHECKSUMS = "checksums"  # the attribute that has them
_ATTRIBUTES = "the attributes"  # what stands for all others
_ROWS = 2**16  # that are looked at at a time: a dataset may be larger than memory


def with_checksums(dataset: xr.Dataset) -> xr.Dataset:
    """Returns a dataset with a checksum for each variable and one for the attributes, in one more attribute."""
    return dataset.assign_attrs({CHECKSUMS: json.dumps(_checksums(dataset))})


def checked(dataset: xr.Dataset) -> xr.Dataset:
    """Returns a dataset, or a part of one, that is as it was saved; without the checksums.

    Raises:
        ValueError: it has none, or something has changed, which the message names.
    """
    if CHECKSUMS not in dataset.attrs:
        raise ValueError(f"no {CHECKSUMS!r}")
    try:
        expected = dict(json.loads(dataset.attrs[CHECKSUMS]))
    except (ValueError, TypeError):
        raise ValueError(f"{CHECKSUMS!r} cannot be read") from None
    plain = dataset.drop_attrs(deep=False).assign_attrs({k: v for k, v in dataset.attrs.items() if k != CHECKSUMS})
    found = _checksums(plain)
    changed = [name for name, checksum in found.items() if checksum != expected.get(name)]
    if changed:
        raise ValueError(f"{', '.join(changed)}: not what was saved; the file is damaged")
    return plain


def _checksums(dataset: xr.Dataset) -> dict[str, int]:
    """Returns the checksums by the names of the variables: CRC-32, which notices every error within 32 bits."""
    found = {str(name): _of_variable(variable) for name, variable in dataset.variables.items()}
    return found | {_ATTRIBUTES: _of_attributes(dataset.attrs)}


def _of_variable(variable: xr.Variable) -> int:
    values = np.asarray(variable.values)
    checksum = _of_attributes({**variable.attrs, "dims": list(variable.dims), "shape": list(values.shape)})
    if values.dtype.kind not in "fiu":
        return zlib.crc32(json.dumps(values.tolist(), default=str).encode(), checksum)
    for first in range(0, len(values) if values.ndim else 0, _ROWS):
        block = np.ascontiguousarray(values[first : first + _ROWS], dtype=np.float64)
        checksum = zlib.crc32(np.where(np.isnan(block), np.nan, block).data, checksum)  # signs of NaN are lost in files
    return checksum


def _of_attributes(attributes: dict[Any, Any]) -> int:
    plain = {str(name): value.item() if hasattr(value, "item") else value for name, value in attributes.items()}
    return zlib.crc32(json.dumps(plain, sort_keys=True, default=str).encode())
