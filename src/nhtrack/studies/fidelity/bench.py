"""What every measurement starts from, and what it ends in."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from typing import Any, Literal

from nhtrack.analysis.sources import fingerprint
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.robot_models import full_name
from nhtrack.simulation.scene import Scene, SceneSpec, make_scene


@dataclass(frozen=True)
class Bench:
    """A robot to be measured, and the simulations of it.

    Attributes:
        robot: folder in models/ or path to an MJCF file.
        change: what is done to every scene before it is simulated; a fault put in on purpose, to see a budget break.
        tamper: the same for every simulation.
    """

    robot: str
    change: Callable[[Scene], Scene] | None = None
    tamper: Callable[[MujocoSimulation], None] | None = None

    def spec(self, **fields: Any) -> SceneSpec:
        """Returns the spec of one robot alone, at 1 ms on a floor of friction 1 unless told otherwise."""
        return SceneSpec(**{"robots": ("robot",), "robot": self.robot} | fields)

    def scene(self, **fields: Any) -> Scene:
        """Returns the scene of `spec`, the caller's to change."""
        return _made(self.spec(**fields), self.change)

    def simulation(
        self, dt: float | None = None, batch: tuple[int, ...] = (), scene: Scene | None = None, **fields: Any
    ) -> MujocoSimulation:
        """Returns a simulation of `scene`, its control period dt [s] one physics step unless told otherwise."""
        spec = self.spec(**fields) if scene is None else scene.spec
        # The rate correction is the simulation's: scenes with and without are one.
        scene = _kept(replace(spec, rate_correction=True), self.change) if scene is None else scene
        simulation = MujocoSimulation(scene, dt or spec.timestep, batch, spec=spec)
        if self.tamper is not None:
            self.tamper(simulation)
        return simulation

    @property
    def drive(self) -> DiffDrive:
        """The robot's reduced model."""
        return _kept(self.spec(), self.change).drive

    @property
    def swivels(self) -> bool:
        """Whether casters of the robot swivel, of which the reduced model does not know."""
        return bool(_kept(self.spec(), self.change).addresses.casters.size)

    def find(self, check: str, value: float, unit: str, budget: float, cause: str, **rest: Any) -> Finding:
        """Returns a finding about this robot."""
        return Finding(self.robot, check, float(value), unit, budget, cause, **rest)


def _made(spec: SceneSpec, change: Callable[[Scene], Scene] | None) -> Scene:
    scene = make_scene(spec)
    return scene if change is None else change(scene)


def _kept(spec: SceneSpec, change: Callable[[Scene], Scene] | None) -> Scene:
    """Returns a scene, kept while the robot's files are the same: to make one takes longer than most drives in it."""
    return _made_of(spec, change, fingerprint(full_name(spec.robot)))


@lru_cache(maxsize=4)
def _made_of(spec: SceneSpec, change: Callable[[Scene], Scene] | None, files: str) -> Scene:
    return _made(spec, change)


@dataclass(frozen=True)
class Finding:
    """One measured figure and its budget.

    Attributes:
        robot: its name.
        check: what was measured.
        value: the figure.
        unit: of value and budget; `1` for a share.
        budget: what the figure has to keep to.
        cause: what the figure is made of.
        sense: whether it may be `at most` or must be `at least` the budget.
        explained: whether docs/fidelity.md says why the budget is not kept.
        group: what it is told together with.
    """

    robot: str
    check: str
    value: float
    unit: str
    budget: float
    cause: str
    sense: Literal["at most", "at least"] = "at most"
    explained: bool = False
    group: str = ""

    @property
    def ok(self) -> bool:
        """Whether the figure keeps to its budget; one that is not finite does not."""
        kept = self.value <= self.budget if self.sense == "at most" else self.value >= self.budget
        return math.isfinite(self.value) and kept

    @property
    def row(self) -> dict[str, Any]:
        """The finding as plain values for JSON; a figure that is not finite is None."""
        value = self.value if math.isfinite(self.value) else None
        return asdict(self) | {"value": value, "ok": self.ok}
