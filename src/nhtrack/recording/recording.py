"""What a run leaves behind: an xarray Dataset with units, saved as one netCDF-4 file.

All quantities are in robot units (SI, radians). Attributes carry the similarity factors that map them back to
the scenario's own units, the resolved scenario, seed, versions and the hash of the compiled model.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from nhtrack.errors import RecordingError, printable
from nhtrack.files.atomic import atomic_path
from nhtrack.files.checksums import with_checksums
from nhtrack.recording.attributes import read_scene
from nhtrack.recording.reading import read_dataset, reopened
from nhtrack.simulation.spec import SceneSpec
from nhtrack.views import drawn_by

if TYPE_CHECKING:
    import xarray as xr

    from nhtrack.config.scenario import Scenario
    from nhtrack.recording.scenario import LawText

_SHARE = 2_000_000  # rows of all robots together that are looked at in memory at once
_LARGE = 10**9  # bytes of a recording that is not saved by way of memory


class RobotFigures(NamedTuple):
    """Dimensions and motor limits of robots of one kind.

    Attributes:
        wheel_radius: [m].
        half_separation: half of the distance between the wheels [m].
        torque_limit: of each motor [N m].
        no_load_speed: of each wheel [rad/s].
        trusted_friction: up to which loads of wheels that slide are to be trusted (docs/fidelity.md).
    """

    wheel_radius: float
    half_separation: float
    torque_limit: float
    no_load_speed: float
    trusted_friction: float


class Divergence(NamedTuple):
    """What ended a run early.

    Attributes:
        robot: name of the first robot it happened to.
        time: on the robot's clock [s].
        reason: what happened, in words.
    """

    robot: str
    time: float
    reason: str


class Recording:
    """A finished (or interrupted) run.

    Attributes:
        dataset: xarray Dataset with dims `time`, `robot` and named components (`VARIABLES`), plus `qpos`
            (time, nq) where MuJoCo ran. Variables carry `units` and `long_name`.
    """

    def __init__(self, dataset: xr.Dataset, own: Path | None = None) -> None:
        """Takes a dataset.

        Args:
            dataset: see above; of a large one the variables may be read from a file, anew whenever they are asked for.
            own: the file that it is read from, where that has no name yet and becomes the recording's when it is saved.
        """
        self.dataset, self._own = dataset, own

    def __getitem__(self, name: str) -> xr.DataArray:
        """Returns one recorded variable, with its coordinates and units.

        Raises:
            RecordingError: the recording has no such variable; the message lists those it has.
        """
        if name not in self.dataset:
            held = ", ".join(str(held) for held in self.dataset.data_vars)
            raise RecordingError(f"no variable {name!r} in this recording; it has {held}")
        return self.dataset[name]

    def __repr__(self) -> str:
        """Returns a one-line account of the run."""
        last = float(self.time[-1]) if self.time.size else 0.0
        return f"Recording({self.name!r}, {len(self.robots)} robots, {last:.4g} s, backend={self.backend!r})"

    def _repr_html_(self) -> str:
        """Returns what a notebook shows of the run."""
        return drawn_by("nhtrack.studies.run.view.recording_html", self)

    @property
    def time(self) -> np.ndarray:
        """Times on the robot's clock [s], shape (time,)."""
        return np.asarray(self.dataset["time"].values)

    @property
    def rows(self) -> int:
        """How many rows the run has: as many as this recording, unless it was thinned to be drawn."""
        return int(self.dataset.attrs.get("rows", self.dataset.sizes["time"]))

    def shares(self) -> Iterator[Recording]:
        """Yields the recording of some of the robots at a time: as many as may be looked at in memory at once."""
        count = max(1, _SHARE // max(self.dataset.sizes["time"], 1))
        if count >= len(self.robots):
            yield self
            return
        for first in range(0, len(self.robots), count):
            yield Recording(self.dataset.isel(robot=slice(first, first + count)))

    @property
    def robots(self) -> tuple[str, ...]:
        """Names of the robots, root first."""
        return tuple(str(name) for name in self.dataset["robot"].values)

    @property
    def parents(self) -> dict[str, tuple[str, ...]]:
        """Parents of every robot by name; the root has none."""
        return {name: tuple(parents) for name, parents in json.loads(self.dataset.attrs["parents"]).items()}

    @property
    def followers(self) -> tuple[str, ...]:
        """Names of the robots that have parents."""
        parents = self.parents
        return tuple(name for name in self.robots if parents[name])

    @property
    def name(self) -> str:
        """Name of the scenario."""
        return str(self.dataset.attrs["name"])

    @property
    def backend(self) -> str:
        """What moved the robots: `mujoco` or `ideal`."""
        return str(self.dataset.attrs["backend"])

    @property
    def groups(self) -> dict[str, list[str]]:
        """Followers of each run by its label, in a recording of several; empty in one of a single run."""
        return dict(json.loads(self.dataset.attrs.get("groups", "{}")))

    @property
    def has_twin(self) -> bool:
        """Whether the run is held against an ideal twin: one on the ideal integrator is its own."""
        return self.backend != "ideal" and "ideal_pose" in self.dataset

    @property
    def length_scale(self) -> float:
        """Robot metres per scenario length unit."""
        return float(self.dataset.attrs["length_scale"])

    @property
    def time_scale(self) -> float:
        """Robot seconds per scenario time unit."""
        return float(self.dataset.attrs["time_scale"])

    @property
    def outcome(self) -> str:
        """`completed`, `interrupted`, or `diverged: <why>`."""
        return printable(str(self.dataset.attrs["outcome"]))

    @property
    def divergence(self) -> Divergence | None:
        """What ended the run early, or None."""
        known = self.dataset.attrs
        if "diverged_reason" not in known:
            return None
        return Divergence(known["diverged_robot"], float(known["diverged_time"]), known["diverged_reason"])

    @cached_property
    def scenario(self) -> Scenario:
        """The resolved scenario, for reading: a law that is not the package's own is there as its keys only.

        Raises:
            RecordingError: it is not one that this version reads, or the recording does not say.
        """
        from nhtrack.recording.scenario import read_scenario  # what shows no scenario need not import all laws

        return read_scenario(self._told("scenario"))

    @property
    def law(self) -> LawText | None:
        """The law that moved the followers, or None where it is the package's own."""
        from nhtrack.recording.scenario import LawText

        text = self.dataset.attrs.get("law")
        return None if text is None else LawText(**json.loads(text))

    @property
    def seed(self) -> int | None:
        """Seed of the noise, or None where the recording does not say."""
        seed = self.dataset.attrs.get("seed")
        return None if seed is None else int(seed)

    @property
    def model_hash(self) -> str:
        """SHA-256 of the compiled model; empty on the ideal integrator."""
        return str(self.dataset.attrs.get("model_hash", ""))

    @property
    def has_scene(self) -> bool:
        """Whether the recording says which scene it was made in."""
        return "scene" in self.dataset.attrs

    @property
    def scene(self) -> SceneSpec:
        """The scene it was made in, or would have been made in on wheels.

        Raises:
            RecordingError: the recording does not say.
        """
        return read_scene(self._told("scene"))

    @property
    def robot(self) -> RobotFigures:
        """What is known of the robots' dimensions and motors; NaN where the recording does not say."""
        return RobotFigures(*(float(self.dataset.attrs.get(name, math.nan)) for name in RobotFigures._fields))

    def _told(self, name: str) -> str:
        """Returns an attribute that recordings of parts of a run go without."""
        if name not in self.dataset.attrs:
            raise RecordingError(f"this recording does not say which {name} it was made in")
        return str(self.dataset.attrs[name])

    @property
    def versions(self) -> dict[str, str]:
        """Versions of the package, of Python and of the libraries that moved the numbers."""
        return dict(json.loads(self.dataset.attrs["versions"]))

    def save(self, path: str | Path) -> Path:
        """Writes the recording as netCDF-4, with checksums; the file appears under its name only once it is whole."""
        target = Path(path)
        if self._own is not None:
            os.replace(self._own, target)
            self.dataset, self._own = reopened(target), None
            return target
        dataset = with_checksums(self.dataset)
        with atomic_path(target) as temporary:
            data = dataset.data_vars
            encoding = {name: {"zlib": True, "complevel": 4} for name in data if data[name].size}
            if dataset.nbytes > _LARGE:  # there was room for it when the run began
                dataset.to_netcdf(temporary, engine="h5netcdf", encoding=encoding)
            else:  # by way of memory: HDF5 does not survive a disk that fills up while it writes
                temporary.write_bytes(dataset.to_netcdf(engine="h5netcdf", encoding=encoding))
        return target

    @classmethod
    def load(cls, path: str | Path) -> Recording:
        """Reads a recording.

        Raises:
            RecordingError: no such file, of another version of the format, or not as it was saved.
        """
        return cls(read_dataset(Path(path)))
