"""The dataset of a recording's file, found whole and sound: what it lacks is told here, and nowhere later."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nhtrack.arrays import row_blocks
from nhtrack.errors import RecordingError, printable
from nhtrack.files.checksums import checked, unchecked
from nhtrack.files.netcdf import opened
from nhtrack.files.text import exists
from nhtrack.network import network_faults
from nhtrack.recording.attributes import REQUIRED, attribute_faults, read_scene, section
from nhtrack.recording.variables import COMPONENTS, FORMAT_VERSION, VARIABLES

if TYPE_CHECKING:
    import xarray as xr

_SHOWN = 20  # names of a message
LARGE = 2**27  # bytes of a dataset that is read a part at a time


def read_dataset(source: Path) -> xr.Dataset:
    """Returns the dataset of a recording.

    Raises:
        RecordingError: no such file, of another version of the format, or not as it was saved; with each fault.
    """
    if not exists(source) or not source.is_file():
        raise RecordingError(f"{source}: no such recording")
    dataset = _loaded(source)
    faults = list(_format_faults(dataset))
    if faults:
        raise RecordingError(f"{source}: {faults[0]}")
    try:
        dataset = checked(dataset)
    except Exception as error:  # nor what it says where it is read
        raise RecordingError(printable(f"{source}: not a recording: {error}")) from error
    faults = [*attribute_faults(dataset.attrs), *_variable_faults(dataset)]
    faults = faults or [*_robot_faults(dataset.attrs, [str(name) for name in dataset["robot"].values])]
    if faults:
        raise RecordingError(printable(f"{source}: not a recording: {'; '.join(faults)}"))
    return dataset


def reopened(source: Path) -> xr.Dataset:
    """Returns the dataset of a file that was just written: nothing is kept of what is read of its variables."""
    return unchecked(opened(source))


def _loaded(source: Path) -> xr.Dataset:
    """Returns the dataset of a file, in memory where it is not large."""
    at = ""
    try:
        dataset = opened(source)
        if dataset.nbytes > LARGE:
            return dataset
        with dataset:
            for name in dataset.variables:
                at = f"{name}: "
                dataset[name].load()
            return dataset
    except Exception as error:  # what HDF5 says of damage has no type of its own
        said = printable(f"{source}: not a recording ({at}{error or type(error).__name__})")
        raise RecordingError(said) from error


def _format_faults(dataset: xr.Dataset) -> Iterator[str]:
    given = dataset.attrs.get("format_version")
    if given is None:
        yield f"not a recording: no {next(name for name in REQUIRED if name not in dataset.attrs)!r}"
    elif not isinstance(given, (int, np.integer)):
        yield "not a recording: 'format_version' cannot be read"
    elif given != FORMAT_VERSION:
        remedy = "; run its scenario again" if 0 < given < FORMAT_VERSION else ""
        yield f"recording format {given}; this version reads {FORMAT_VERSION}{remedy}"


def _variable_faults(dataset: xr.Dataset) -> Iterator[str]:
    """Yields variables that are missing, of another shape, or without numbers."""
    dims = {"time": ("time",), "robot": ("robot",), "pose": ("time", "robot", "pose_component")}
    faulty = [name for name, own in dims.items() if name not in dataset or dataset[name].dims != own]
    yield from (f"no {name!r} of the dimensions {', '.join(dims[name])}" for name in faulty)
    if faulty:
        return
    names = [str(name) for name in dataset["robot"].values]
    time, pose = np.asarray(dataset["time"].values), dataset["pose"]
    if time.dtype.kind != "f" or pose.dtype.kind != "f" or pose.shape[-1] != 3:
        yield "'time' and 'pose' are no numbers of one, and three, components"
        return
    if not np.isfinite(time).all() or (np.diff(time) <= 0).any():
        yield "'time' does not increase"
    yield from _other_faults(dataset)
    lost = np.zeros(len(names), dtype=bool)
    for part in row_blocks(len(time), pose.nbytes):
        lost |= ~np.isfinite(pose[part].values).all(axis=(0, 2))
    if str(dataset.attrs.get("outcome")).startswith("diverged"):
        return
    for name in (name for name, gone in zip(names, lost, strict=True) if gone):
        yield f"'pose' of robot {name!r} is no number somewhere"


def _robot_faults(attributes: Mapping[str, Any], names: list[str]) -> Iterator[str]:
    """Yields what attributes say of other robots than there are, or of robots that track each other in no order."""
    parents = section(attributes["parents"])
    robots = list(read_scene(attributes["scene"]).robots) if "scene" in attributes else names
    for said, known in (("parents", list(parents)), ("scene", robots)):
        if sorted(known) != sorted(names):
            yield f"{said!r} speaks of {', '.join(known[:_SHOWN])}, 'robot' of {', '.join(names[:_SHOWN])}"
            return
    yield from (f"'parents': {fault.robot}: {fault.message}" for fault in network_faults(parents))
    if not all(name.isprintable() for name in names):
        yield "'robot' has names that cannot be shown"


def _other_faults(dataset: xr.Dataset) -> Iterator[str]:
    """Yields variables that the format knows, but not as they are."""
    for name, known in VARIABLES.items():
        if name in dataset:
            dims = ("time", "robot", *known.dims)
            found = dataset[name]
            whole = all(len(COMPONENTS[dim]) == found.sizes.get(dim) for dim in known.dims if dim in COMPONENTS)
            if found.dims != dims or not whole or found.dtype.kind not in "fiu":
                yield f"{name!r} is no array of numbers of the dimensions {', '.join(dims)}"
