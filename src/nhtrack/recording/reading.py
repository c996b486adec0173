"""The dataset of a recording's file, found whole and sound: what it lacks is told here, and nowhere later."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nhtrack.arrays import row_blocks
from nhtrack.errors import RecordingError
from nhtrack.files.checksums import checked, unchecked
from nhtrack.files.text import exists
from nhtrack.recording.variables import FORMAT_VERSION
from nhtrack.simulation.spec import SceneSpec

if TYPE_CHECKING:
    import xarray as xr

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
    except ValueError as error:
        raise RecordingError(f"{source}: not a recording: {error}") from None
    faults = [*_attribute_faults(dataset.attrs), *_variable_faults(dataset)]
    if faults:
        raise RecordingError(f"{source}: not a recording: {'; '.join(faults)}")
    return dataset


def reopened(source: Path) -> xr.Dataset:
    """Returns the dataset of a file that was just written: nothing is kept of what is read of its variables."""
    return unchecked(_opened(source))


def _opened(source: Path) -> xr.Dataset:
    import xarray as xr

    return xr.open_dataset(source, engine="h5netcdf", cache=False, phony_dims="access")


def _loaded(source: Path) -> xr.Dataset:
    """Returns the dataset of a file, in memory where it is not large."""
    import h5py  # takes long to import, as xarray does, and names of variables need none of it

    at = ""
    try:
        with h5py.File(source) as file:  # where these fail h5netcdf leaves half an object, which prints a traceback
            file.attrs.get("_nc3_strict")
        dataset = _opened(source)
        if dataset.nbytes > LARGE:
            return dataset
        with dataset:
            for name in dataset.variables:
                at = f"{name}: "
                dataset[name].load()
            return dataset
    except Exception as error:  # what HDF5 says of damage has no type of its own
        raise RecordingError(f"{source}: not a recording ({at}{error or type(error).__name__})") from error


def _format_faults(dataset: xr.Dataset) -> Iterator[str]:
    given = dataset.attrs.get("format_version")
    if given is None:
        yield f"not a recording: no {next(name for name in _REQUIRED if name not in dataset.attrs)!r}"
    elif not isinstance(given, (int, np.integer)):
        yield "not a recording: 'format_version' cannot be read"
    elif given != FORMAT_VERSION:
        remedy = "; run its scenario again" if 0 < given < FORMAT_VERSION else ""
        yield f"recording format {given}; this version reads {FORMAT_VERSION}{remedy}"


def _scale(value: Any) -> None:
    if not (math.isfinite(value) and value > 0):
        raise ValueError


def _section(text: Any) -> Mapping[str, Any]:
    tree = json.loads(text)
    if not isinstance(tree, dict):
        raise ValueError
    return tree


def _lists(text: Any) -> None:
    if not all(isinstance(names, list) and all(isinstance(n, str) for n in names) for names in _section(text).values()):
        raise ValueError


def _law(text: Any) -> None:
    from nhtrack.recording.scenario import LawText  # few recordings have one, and it imports all laws

    law = LawText(**_section(text))
    if not all(isinstance(part, str) for part in law[:-1]):
        raise ValueError


_REQUIRED: Mapping[str, Callable[[Any], Any]] = {
    "scenario": _section,
    "format_version": int,
    "name": str,
    "backend": str,
    "outcome": str,
    "parents": _lists,
    "length_scale": _scale,
    "time_scale": _scale,
    "versions": _section,
}
_OPTIONAL: Mapping[str, Callable[[Any], Any]] = {
    "scene": SceneSpec.from_json,
    "law": _law,
    "groups": _lists,
    "seed": int,
    "diverged_time": float,
    **dict.fromkeys(("friction", "torque_limit", "no_load_speed", "wheel_radius", "half_separation"), float),
}


def _attribute_faults(attributes: Mapping[str, Any]) -> Iterator[str]:
    """Yields attributes that are missing, or are not what they are read as."""
    yield from (f"no {name!r}" for name in _REQUIRED if name not in attributes)
    for name, read in {**_REQUIRED, **_OPTIONAL}.items():
        try:
            if name in attributes:
                read(attributes[name])
        except RecordingError as error:
            yield str(error)
        except (ValueError, TypeError, LookupError, AttributeError, OverflowError, RecursionError):
            yield f"{name!r} cannot be read"


def _variable_faults(dataset: xr.Dataset) -> Iterator[str]:
    """Yields variables that are missing, of another shape, or without numbers."""
    dims = {"time": ("time",), "robot": ("robot",), "pose": ("time", "robot", "pose_component")}
    faulty = [name for name, own in dims.items() if name not in dataset or dataset[name].dims != own]
    yield from (f"no {name!r} of the dimensions {', '.join(dims[name])}" for name in faulty)
    if faulty:
        return
    names = [str(name) for name in dataset["robot"].values]
    try:
        known = [str(name) for name in _section(dataset.attrs["parents"])]
    except (ValueError, TypeError, LookupError):
        return  # told above
    if sorted(known) != sorted(names):
        yield f"'parents' speaks of {', '.join(known)}, 'robot' of {', '.join(names)}"
    time, pose = np.asarray(dataset["time"].values), dataset["pose"]
    if time.dtype.kind != "f" or pose.dtype.kind != "f" or pose.shape[-1] != 3:
        yield "'time' and 'pose' are no numbers of one, and three, components"
        return
    if not np.isfinite(time).all() or (np.diff(time) <= 0).any():
        yield "'time' does not increase"
    lost = np.zeros(len(names), dtype=bool)
    for part in row_blocks(len(time), pose.nbytes):
        lost |= ~np.isfinite(pose[part].values).all(axis=(0, 2))
    if str(dataset.attrs.get("outcome")).startswith("diverged"):
        return
    for name in (name for name, gone in zip(names, lost, strict=True) if gone):
        yield f"'pose' of robot {name!r} is no number somewhere"
