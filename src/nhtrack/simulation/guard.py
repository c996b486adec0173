"""Compares a robot in its composed scene with its reduced model, for what nobody thought of when it was read.

Mass, what touches the floor at rest, and two short pulses on the wheels: both ahead, then one ahead and one back. What
differs is an error that names the quantity.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from math import inf
from pathlib import Path

import mujoco
import numpy as np

from nhtrack import assets
from nhtrack.arrays import Array
from nhtrack.errors import RobotError, SimulationDiverged
from nhtrack.robots.contract import Hints, Parts
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.robots.kind import Reading
from nhtrack.robots.reading.standard import bare
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.robot_models import RobotModels, read_robot
from nhtrack.simulation.scene import Scene, make_scene
from nhtrack.simulation.spec import SceneSpec
from nhtrack.simulation.state import State

__all__ = ["GuardFigure", "examine", "read_sound_robot"]

_PERIOD, _PERIODS, _SETTLING = 0.01, 20, 30  # [s], periods of a pulse, and of a robot that stands
_GRIP, _TORQUE = 0.1, 0.3  # shares of friction and of the motors' torque that a pulse takes
_MASS, _LOAD, _MOVED = 1e-9, 0.02, 0.01  # how far each may be from what is expected, over what is expected
_SWIVELLING = 1.0  # the same of a pulse where casters swivel, of which the reduced model does not know: its direction


@dataclass(frozen=True)
class GuardFigure:
    """One thing that a robot's scene was asked.

    Attributes:
        quantity: what was compared.
        expected: by the reduced model.
        found: in the scene.
        unit: of both; `1` for none.
        tolerance: by how much they may differ.
        cause: what may lie behind a difference.
    """

    quantity: str
    expected: float
    found: float
    unit: str
    tolerance: float
    cause: str

    @property
    def holds(self) -> bool:
        """Whether they agree."""
        return bool(abs(self.found - self.expected) <= self.tolerance)

    def __str__(self) -> str:
        """Returns it as one sentence."""
        unit = "" if self.unit == "1" else f" {self.unit}"
        found, expected = f"{self.found:.6g}{unit} in the scene", f"{self.expected:.6g}{unit} by the reduced model"
        return f"{self.quantity} is {found}, and {expected}: {self.cause}"


def examine(reading: Reading) -> tuple[GuardFigure, ...]:
    """Returns what was compared between a robot, alone on a level floor of friction 1, and its reduced model.

    Raises:
        RobotError: the scene does not compile.
    """
    return _examined(bare(reading.mjcf), reading.parts, reading.model)


@lru_cache(maxsize=16)
def _examined(mjcf: str, parts: Parts, model: DiffDrive) -> tuple[GuardFigure, ...]:
    spec = SceneSpec(("robot",))
    robot = RobotModels(spec, Reading(Path(), "", mjcf, parts, model, {}, ()), model, model)
    scene = make_scene(spec, robot)
    return (*_mass(scene), *_at_rest(scene, robot), *_pulses(scene, robot))


def read_sound_robot(spec: SceneSpec) -> RobotModels:
    """Returns what is known of the robots of a spec, those of the user's own held against their scene.

    Bundled robots are held against theirs by tests.

    Raises:
        RobotError: as `read_robot`; or what differs between scene and reduced model.
    """
    robot = read_robot(spec)
    if spec.robot in assets.robots() and spec.hints == Hints():
        return robot
    wrong = [each for each in examine(robot.reading) if not each.holds]
    if wrong:
        raise RobotError("\n".join(f"{robot.reading.file}: {each}" for each in wrong))
    return robot


def _mass(scene: Scene) -> Iterator[GuardFigure]:
    body = int(scene.model.jnt_bodyid[scene.model.joint("robot/root/").id])
    found, expected = float(scene.model.body_subtreemass[body]), scene.drive.mass
    yield GuardFigure("mass", expected, found, "kg", _MASS * expected, "something else was welded to it")


def _at_rest(scene: Scene, robot: RobotModels) -> Iterator[GuardFigure]:
    """Yields what touches the floor besides wheels and casters, and the wheels' loads, of a robot that stands."""
    simulation = MujocoSimulation(scene, _PERIOD)
    simulation.reset(_still())
    simulation.drive_by(np.zeros((_SETTLING, 1, 2)))
    data = mujoco.MjData(scene.model)
    data.qpos[:] = simulation.qpos
    mujoco.mj_forward(scene.model, data)
    expected = {f"robot/{name}" for name in (*robot.parts.tyres, *robot.parts.casters)}
    names = {scene.model.geom(int(g)).name for pair in data.contact.geom for g in pair}
    others = {name.removeprefix("robot/") for name in names if name.startswith("robot/")} - {
        name.removeprefix("robot/") for name in expected
    }
    cause = f"{', '.join(sorted(others))} touches the floor" if others else "something else touches the floor"
    yield GuardFigure("parts on the floor besides wheels and casters", 0, len(others), "1", 0, cause)
    if len(robot.parts.casters) == 1:
        loads = robot.plant.support_loads()
        for side, force in zip(("left", "right"), simulation.contact_force[0], strict=True):
            load = float(loads[f"{side} wheel"])
            yield GuardFigure(
                f"load of the {side} wheel at rest",
                load,
                float(force[2]),
                "N",
                _LOAD * load,
                "it rests on something else",
            )


def _pulses(scene: Scene, robot: RobotModels) -> Iterator[GuardFigure]:
    """Yields how far two pulses move a robot that stands, ahead and about its axle."""
    share = _SWIVELLING if robot.parts.rolling_casters else _MOVED
    for name, place, unit, u in (
        ("way", 0, "m", _pulse(robot.plant, 1.0, 0.0)),
        ("turn", 2, "rad", _pulse(robot.plant, 0.0, 1.0)),
    ):
        held = np.broadcast_to(np.asarray(u), (_PERIODS, 1, 2))
        wheels, ideal = MujocoSimulation(scene, _PERIOD), IdealSimulation(("robot",), None, _PERIOD)
        ends = list[Array]()
        for simulation in (wheels, ideal):
            simulation.reset(_still())
            try:
                ends.append(simulation.drive_by(np.ascontiguousarray(held)).g[-1, 0])
            except SimulationDiverged:
                ends.append(np.full(3, np.nan))
        found, expected = ends
        size = abs(float(expected[place]))
        pushed = "both wheels push ahead" if place == 0 else "one wheel pushes ahead and one back"
        cause = "inertia, sense of rotation, or something that drags or holds"
        yield GuardFigure(f"{name} made where {pushed}", size, float(found[place]), unit, share * size, cause)
        aside = float(np.hypot(*(found - expected)[:2])) if place == 2 else float(abs(found[1]))
        scale = size if place == 0 else size * robot.plant.half_separation
        yield GuardFigure(f"way aside where {pushed}", 0.0, aside, "m", share * scale, "its two sides are not alike")


def _pulse(drive: DiffDrive, u_x: float, u_theta: float) -> tuple[float, float]:
    """Returns accelerations in a direction that take a small share of friction and motors."""
    asked = np.zeros(1), np.zeros(1), np.full(1, u_x), np.full(1, u_theta)
    used = float(np.max(drive.friction_demand(*asked) / np.maximum(drive.wheel_loads(*(np.zeros(1),) * 4), 1e-300)))
    torque = float(np.abs(drive.wheel_torques(*asked)).max())
    limit = drive.motor.torque_limit
    most = min(_GRIP / used, _TORQUE * limit / torque if limit < inf else inf)
    return most * u_x, most * u_theta


def _still() -> State:
    return State(0.0, np.zeros((1, 3)), np.zeros((1, 3)))
