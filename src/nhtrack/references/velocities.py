"""The leader's input as velocities over time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field, Tag

from nhtrack.references.columns import FileFaults, read_csv
from nhtrack.references.motion import Motion, MotionInput
from nhtrack.references.samples import Numbers, column_faults, file_or_columns, number_columns, require_rows
from nhtrack.section import Finding, Section


class Velocities(Section):
    """Velocities over time, columns of equal length; the first row is where the run begins."""

    t: Numbers = Field(description="increasing times, counted from the first [scenario time]")
    v: Numbers = Field(description="forward velocities [scenario length/time]")
    omega: Numbers = Field(description="yaw rates [rad/scenario time]")


class VelocityInput(MotionInput):
    """The leader's input as its velocities, joined by lines: its accelerations are constant between rows."""

    key: ClassVar[str] = "velocities"
    words: ClassVar[str] = "velocities"
    velocities: Annotated[
        Annotated[str, Field(min_length=1), Tag("<file>")] | Annotated[Velocities, Tag("<columns>")], file_or_columns
    ] = Field(
        description="CSV file with the columns t, v, omega named in its first line, found relative to the scenario; or "
        "the columns themselves, as loading writes them"
    )

    @classmethod
    def resolved(cls, given: Mapping[str, Any], directory: Path) -> Mapping[str, Any]:
        """Returns a raw section with the file's columns."""
        file = given["velocities"]
        if not isinstance(file, str) or not file:
            return given
        columns = read_csv(directory / file, ("t", "v", "omega"))
        if faults := [columns.fault(*fault) for fault in column_faults(columns.values)]:
            raise FileFaults(faults)
        return {**given, "velocities": dict(columns.values)}

    @classmethod
    def findings(cls, given: Mapping[str, Any], times: np.ndarray | None) -> Iterator[Finding]:
        """Yields columns of unlike length, times out of order, and what `MotionInput.findings` does."""
        columns = number_columns(given["velocities"], ("t", "v", "omega"))
        if columns is None:
            return  # the section's own fault, told by its model
        faults = [(("velocities", name, row), message) for row, name, message in column_faults(columns)]
        yield from faults or super().findings(given, times)

    def reference(self) -> Motion:
        """Returns the motion, in scenario units."""
        if isinstance(self.velocities, str):
            raise TypeError("velocities of a file are read when the scenario is loaded; load it with nhtrack.load")
        rows = self.velocities
        require_rows(rows.model_dump())
        t, speeds = np.array(rows.t) - rows.t[0], np.stack([rows.v, rows.omega], axis=-1)

        def joined(times: np.ndarray) -> np.ndarray:
            inside = np.stack([np.interp(times, t, column) for column in speeds.T], axis=-1)
            return np.where((times <= t[-1])[:, None], inside, 0.0)

        return Motion(lambda times: np.zeros((len(times), 3)), joined, float(t[-1]), tracked=False)
