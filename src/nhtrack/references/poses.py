"""The leader's input as timed poses: where it is to be, and when."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, Tag
from scipy.interpolate import CubicSpline

from nhtrack.references.columns import Columns, FileFaults, read_csv, read_words
from nhtrack.references.motion import Motion, MotionInput
from nhtrack.references.pose_checks import pose_faults
from nhtrack.references.samples import Numbers, RowFault, column_faults, file_or_columns, number_columns, require_rows
from nhtrack.section import Finding, Section

_NAMES = ("t", "x", "y", "theta")
_TUM = ("t", "tx", "ty", "tz", "qx", "qy", "qz", "qw")
_UNIT = 0.01  # how far the norm of a quaternion may be from 1, as written with few digits
_LEAN = math.radians(30)  # of a robot's vertical axis


class Poses(Section):
    """Poses over time, columns of equal length; the first row is where the run begins."""

    t: Numbers = Field(description="increasing times, counted from the first [scenario time]")
    x: Numbers = Field(description="[scenario length]")
    y: Numbers = Field(description="[scenario length]")
    theta: Numbers = Field(description="headings, wrapped or not [rad]")


class PoseInput(MotionInput):
    """The leader's input as timed poses, joined by cubic splines in x, y and theta with continuous accelerations."""

    key: ClassVar[str] = "poses"
    words: ClassVar[str] = "timed poses"
    poses: Annotated[
        Annotated[str, Field(min_length=1), Tag("<file>")] | Annotated[Poses, Tag("<columns>")], file_or_columns
    ] = Field(
        description="file with the poses, found relative to the scenario; or the columns themselves, as loading writes "
        "them"
    )
    format: Literal["csv", "tum"] | None = Field(
        default=None,
        description="`csv`: columns t, x, y, theta named in the first line; `tum`: t tx ty tz qx qy qz qw with blanks "
        "between them, of a frame with x ahead and z up; null: `tum` where the name ends in .tum",
    )

    @classmethod
    def resolved(cls, given: Mapping[str, Any], directory: Path) -> Mapping[str, Any]:
        """Returns a raw section with the file's poses as columns."""
        file = given["poses"]
        if not isinstance(file, str) or not file:
            return given
        tum = (given.get("format") or ("tum" if file.endswith(".tum") else "csv")) == "tum"
        columns = _read_tum(directory / file) if tum else read_csv(directory / file, _NAMES)
        if faults := [columns.fault(*fault) for fault in _faults(columns.values)]:
            raise FileFaults(faults)
        return {**given, "poses": {name: list(columns.values[name]) for name in _NAMES}}

    @classmethod
    def findings(cls, given: Mapping[str, Any], times: np.ndarray | None) -> Iterator[Finding]:
        """Yields rows that no unicycle drives to, and what `MotionInput.findings` does."""
        columns = number_columns(given["poses"], _NAMES)
        if columns is None:
            return  # the section's own fault, told by its model
        faults = [(("poses", name, row), message) for row, name, message in _faults(columns)]
        yield from faults or super().findings(given, times)

    def reference(self) -> Motion:
        """Returns the motion, in scenario units."""
        if isinstance(self.poses, str):
            raise TypeError("poses of a file are read when the scenario is loaded; load it with nhtrack.load")
        rows = self.poses
        require_rows(rows.model_dump())
        return pose_motion(np.array(rows.t) - rows.t[0], np.stack([rows.x, rows.y, rows.theta], axis=-1))


def pose_motion(t: np.ndarray, poses: np.ndarray) -> Motion:
    """Returns the motion through poses; what a spline moves sideways is left out of its velocities.

    Args:
        t: increasing times from 0, shape (T,).
        poses: x, y, theta, shape (T, 3); theta may be wrapped.
    """
    spline = CubicSpline(t, np.stack([*poses[:, :2].T, np.unwrap(poses[:, 2])], axis=-1))
    rate = spline.derivative()
    end = float(t[-1])

    def along(times: np.ndarray) -> np.ndarray:
        return np.asarray(spline(np.minimum(times, end)))

    def speeds(times: np.ndarray) -> np.ndarray:
        heading, velocity = along(times)[:, 2], rate(times)
        v = velocity[:, 0] * np.cos(heading) + velocity[:, 1] * np.sin(heading)
        return np.where((times <= end)[:, None], np.stack([v, velocity[:, 2]], axis=-1), 0.0)

    return Motion(along, speeds, end)


def _faults(columns: Mapping[str, list[float]]) -> list[RowFault]:
    faults = list(column_faults({name: columns[name] for name in _NAMES}))
    if faults:
        return faults
    poses = np.stack([columns[name] for name in _NAMES[1:]], axis=-1)
    return list(pose_faults(np.array(columns["t"]), poses))


def _read_tum(path: Path) -> Columns:
    """Returns the columns t, x, y, theta of a file in the format of the TUM RGB-D benchmark.

    Raises:
        FileFaults: see `read_words`; a quaternion that is none, or a robot that leans.
    """
    columns = read_words(path, _TUM)
    x, y, z, w = (np.array(columns.values[name]) for name in _TUM[4:])
    norm = np.sqrt(x * x + y * y + z * z + w * w)
    faults = [
        columns.fault(int(row), "qx", f"a quaternion has norm 1, this has {norm[row]:.3g}")
        for row in np.flatnonzero(abs(norm - 1) > _UNIT)
    ]
    upright = 1 - 2 * (x * x + y * y) / np.maximum(norm, _UNIT) ** 2
    faults += [
        columns.fault(int(row), "qx", f"leans by {math.degrees(math.acos(np.clip(upright[row], -1, 1))):.0f} degrees")
        for row in np.flatnonzero((upright < math.cos(_LEAN)) & (abs(norm - 1) <= _UNIT))
    ]
    if faults:
        raise FileFaults(faults)
    theta = np.arctan2(2 * (w * z + x * y), w * w + x * x - y * y - z * z).tolist()
    names = dict(zip(_NAMES, ("t", "tx", "ty", "qx"), strict=True))
    values = {name: columns.values[own] for name, own in names.items()} | {"theta": theta}
    return Columns(columns.file, values, {name: columns.places[own] for name, own in names.items()})
