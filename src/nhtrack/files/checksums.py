"""Checksums of what a dataset holds, kept with it, so that whoever reads it notices a changed byte."""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from nhtrack.arrays import row_blocks

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "CHECKSUMS", "checked", "checksum_of", "checksum_of_attributes", "checksum_of_meaning", "checksum_of_rows",
    "noted", "unchecked", "with_checksums",
]  # fmt: skip

CHECKSUMS = "checksums"  # the attribute that has them
_ATTRIBUTES = "the attributes"  # what stands for all others


def with_checksums(dataset: xr.Dataset) -> xr.Dataset:
    """Returns a dataset with a checksum for each variable and one for the attributes, in one more attribute."""
    found = {str(name): checksum_of(variable) for name, variable in dataset.variables.items()}
    return dataset.assign_attrs({CHECKSUMS: noted(found, dataset.attrs)})


def noted(variables: Mapping[str, int], attributes: Mapping[Any, Any]) -> str:
    """Returns the text of the attribute `CHECKSUMS` from checksums of variables, and from the other attributes."""
    return json.dumps({**variables, _ATTRIBUTES: checksum_of_attributes(attributes)})


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
    plain = unchecked(dataset)
    changed = [
        str(name)
        for name, variable in plain.variables.items()
        if checksum_of(variable, str(name)) != expected.get(name)
    ]
    changed += [] if checksum_of_attributes(plain.attrs) == expected.get(_ATTRIBUTES) else [_ATTRIBUTES]
    if changed:
        raise ValueError(f"{', '.join(changed)}: not what was saved; the file is damaged")
    return plain


def unchecked(dataset: xr.Dataset) -> xr.Dataset:
    """Returns a dataset without the checksums."""
    return dataset.drop_attrs(deep=False).assign_attrs({k: v for k, v in dataset.attrs.items() if k != CHECKSUMS})


def checksum_of_rows(values: np.ndarray, before: int = 0) -> int:
    """Returns the checksum of rows of numbers that follow on others: CRC-32, which notices every error within 32 bits.

    Args:
        values: numbers, shape (k, ...).
        before: the checksum of all rows before them.
    """
    block = np.ascontiguousarray(values, dtype=np.float64)
    return zlib.crc32(np.where(np.isnan(block), np.nan, block).data, before)  # signs of NaN are lost in files


def checksum_of_meaning(
    attributes: Mapping[Any, Any], dims: Sequence[Any], shape: Sequence[int], rows: int
) -> int:
    """Returns the checksum of a variable from that of its rows: its attributes and its form follow on them."""
    return checksum_of_attributes({**attributes, "dims": list(dims), "shape": list(shape)}, rows)


def checksum_of_attributes(attributes: Mapping[Any, Any], before: int = 0) -> int:
    """Returns the checksum of attributes, in whatever order, that follow on something."""
    plain = {str(name): value.item() if hasattr(value, "item") else value for name, value in attributes.items()}
    return zlib.crc32(json.dumps(plain, sort_keys=True, default=str).encode(), before)


def checksum_of(variable: xr.Variable, name: str = "") -> int:
    """Returns the checksum of a variable, read a block of rows at a time: it may be larger than memory.

    Raises:
        ValueError: what a file holds of it cannot be read.
    """
    rows = 0
    try:
        if variable.dtype.kind not in "fiu":
            rows = zlib.crc32(json.dumps(variable.values.tolist(), default=str).encode())
        elif not variable.ndim:
            rows = checksum_of_rows(variable.values)
        else:
            for part in row_blocks(variable.shape[0], variable.nbytes):
                rows = checksum_of_rows(variable[part].values, rows)
    except (OSError, RuntimeError) as error:  # what HDF5 says of damage
        raise ValueError(f"{name}: {error}") from error
    return checksum_of_meaning(variable.attrs, variable.dims, variable.shape, rows)
