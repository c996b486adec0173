"""The leader's input as what a robot of another run did."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from pydantic import Field, ValidationError

from nhtrack.errors import did_you_mean
from nhtrack.files.carried import read_at
from nhtrack.files.checksums import CHECKSUMS, checked
from nhtrack.files.netcdf import opened
from nhtrack.files.text import exists
from nhtrack.references.columns import FileFaults
from nhtrack.references.contract import Commands, InputSection
from nhtrack.section import Section


class RecordingSection(Section):
    """A robot of a recorded run."""

    file: str = Field(min_length=1, description="its recording.nc, found relative to the scenario")
    robot: str = Field(min_length=1, description="which of its robots, by name")


class RecordingInput(InputSection):
    """The leader's input from a recording; loading turns it into timed poses, in the units of the recorded scenario."""

    key: ClassVar[str] = "recording"
    words: ClassVar[str] = "a recording"
    recording: RecordingSection = Field(description="which robot of which run is to be driven after")

    @classmethod
    def resolved(cls, given: Mapping[str, Any], directory: Path) -> Mapping[str, Any]:
        """Returns a raw section with the robot's poses."""
        try:
            wanted = cls.model_validate(given).recording
        except ValidationError:
            return given  # the section's own fault, told by its model
        t, poses = read_poses(directory / wanted.file, wanted.robot)
        columns = zip(("x", "y", "theta"), poses.T.tolist(), strict=True)
        return {"poses": {"t": t.tolist(), **dict(columns)}}

    def reference(self) -> Commands:
        """Raises TypeError: loading makes poses of it."""
        raise TypeError("a recording becomes poses when the scenario is loaded; load it with nhtrack.load")


def read_poses(path: Path, robot: str) -> tuple[np.ndarray, np.ndarray]:
    """Returns times and poses of a recorded robot in the units of its scenario, shape (T,) and (T, 3).

    Args:
        path: a netCDF file with the variable `pose` of the dimensions time, robot, and three components in metres and
            radians, and with the attributes `length_scale` and `time_scale`.
        robot: its name.

    Raises:
        FileFaults: no such file, no recording, or no such robot in it; or it was lost.
    """
    at = read_at(path)
    if not exists(at) or not at.is_file():
        raise FileFaults([f"no file {str(path)!r}"])
    try:
        with opened(at) as data:
            if CHECKSUMS in data.attrs:
                checked(data[["pose"]])
            names = [str(name) for name in data["robot"].values]
            if robot not in names:
                raise FileFaults([f"{path.name}: no robot {robot!r}; {did_you_mean(robot, names)}"])
            poses = data["pose"].values[:, names.index(robot)]
            t = data["time"].values / data.attrs["time_scale"]
            poses = poses / [data.attrs["length_scale"], data.attrs["length_scale"], 1.0]
    except FileFaults:
        raise
    except Exception as error:  # what HDF5 says of damage has no type of its own
        raise FileFaults([f"{path.name}: not a recording ({error or type(error).__name__})"]) from None
    if len(t) < 2 or not np.isfinite(poses).all():
        raise FileFaults([f"{path.name}: robot {robot!r} was lost in this run"])
    return np.asarray(t), np.asarray(poses)
