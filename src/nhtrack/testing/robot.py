"""What every robot keeps that can be driven, as tests that its author inherits.

In a file `test_my_robot.py` beside the robot:

    from pathlib import Path
    from nhtrack.testing import RobotContract

    class TestMine(RobotContract):
        robot = Path(__file__).with_name("my_robot.xml")

and then `pytest test_my_robot.py`.
"""

from __future__ import annotations

from functools import lru_cache
from math import pi
from pathlib import Path
from typing import ClassVar
from unittest import SkipTest

import numpy as np

from nhtrack.arrays import Array
from nhtrack.config.load import Loader
from nhtrack.config.robot_section import RobotSection
from nhtrack.config.starter import Pace, pace_within, starter_with
from nhtrack.errors import RenderError, RobotError
from nhtrack.experiment.build import build
from nhtrack.experiment.limits import agile_limits
from nhtrack.ground import Ground
from nhtrack.robots.contract import Hints
from nhtrack.simulation.guard import examine
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.robot_models import RobotModels, read_robot
from nhtrack.simulation.scene import make_scene
from nhtrack.simulation.spec import SceneSpec
from nhtrack.simulation.state import State
from nhtrack.testing.picture import covered

__all__ = ["RobotContract"]

_PERIOD = 0.01  # [s] control period
_STANDING, _PUSHING, _WEAVING = 2.0, 1.0, 10.0  # [s]
_SLOW, _QUICK = 2 * pi / 5, 2 * pi / 4  # [1/s] of waves of speed and of turning
_USED = 0.5  # of the friction
_SEEN = 0.002  # of a picture, which a robot before the camera covers


class RobotContract:
    """Tests of a robot: it is read, stands, moves alike both ways, and does on wheels what its reduced model says.

    Motions suit its limits: leaders take 40 % of its speed, and half of the friction is used at most.

    Attributes:
        robot: its file, a folder with one, or a bundled robot.
        hints: what its file cannot say itself: `Hints(wheels=("left", "right"))`.
        friction: of the level floor that it is tried on [1].
        rest: how far it may creep in two seconds of standing, over the radius of its wheels: contacts are soft.
        symmetry: how much the ways ahead and back, and the turns left and right, may differ, over the way or turn.
        pushed: how much they may be longer or shorter than what was asked for; swivel casters need more.
        open_loop: how far it may part from the ideal integrator in ten seconds without a law, over its path; swivel
            casters, which steer it a little, need much more.
        closed_loop: the same of two robots, one of which follows the other by the law `universal`.
    """

    robot: ClassVar[str | Path]
    hints: ClassVar[Hints] = Hints()
    friction: ClassVar[float] = 1.0
    rest: ClassVar[float] = 1e-6
    symmetry: ClassVar[float] = 1e-4
    pushed: ClassVar[float] = 1e-3
    open_loop: ClassVar[float] = 1e-5
    closed_loop: ClassVar[float] = 1e-3

    def test_it_is_read(self) -> None:
        """Its file says all there is to know; else every reason why not."""
        try:
            self._models()
        except RobotError as error:
            raise AssertionError(str(error)) from error

    def test_its_scene_is_what_the_reduced_model_says(self) -> None:
        """The guard finds its mass, nothing else of it on the floor, its loads, and that it moves as it is pushed."""
        wrong = [str(each) for each in examine(self._models().reading) if not each.holds]
        if wrong:
            raise AssertionError("\n".join(wrong))

    def test_it_stands(self) -> None:
        """Left alone it stays where it is."""
        g = self._driven(np.zeros((round(_STANDING / _PERIOD), 2)))
        crept = float(np.hypot(*g[-1, :2]) / self._models().plant.wheel_radius)
        self._require(crept, self.rest, "it creeps where it stands, over the radius of its wheels")

    def test_ahead_is_as_back_and_left_as_right(self) -> None:
        """Pushed one way and the other from rest it goes as far, and turns as far."""
        pace = self._pace()
        periods = round(_PUSHING / _PERIOD)
        for place, u, said in ((0, (pace.speed, 0.0), "ahead and back"), (2, (0.0, pace.yaw_rate), "left and right")):
            one, other = (self._driven(np.tile(sign * np.array(u), (periods, 1)))[-1, place] for sign in (1.0, -1.0))
            self._require(float(abs(one + other) / abs(one)), self.symmetry, f"{said} differ, over the way")
            expected = 0.5 * u[place // 2] * _PUSHING**2
            self._require(float(abs(one / expected - 1)), self.pushed, f"{said} are not what was asked for")

    def test_open_loop_it_goes_where_the_ideal_goes(self) -> None:
        """Speeding up and weaving for ten seconds, with no law to bring it back; no wheel turns back."""
        pace, t = self._pace(), (np.arange(round(_WEAVING / _PERIOD)) + 0.5) * _PERIOD
        turn = min(pace.yaw_rate, 0.5 * pace.speed / self._models().plant.half_separation)
        begun = np.clip(t / 2, 0, 1)  # what turns before it drives would turn a wheel back
        u_x = np.where(t < 2, pace.speed / 2, 0.2 * pace.speed * _SLOW * np.sin(_SLOW * (t - 2)))
        u = np.stack([u_x, begun * turn * _QUICK * np.cos(_QUICK * t)], axis=-1)
        ideal = IdealSimulation(("robot",), None, _PERIOD)
        ideal.reset(_at_rest(1))
        expected = ideal.drive_by(u[:, None]).g[:, 0]
        gap = _gap(self._driven(u), expected)
        self._require(gap, self.open_loop, "it parts from the ideal without a law, over its path")

    def test_one_follows_another(self) -> None:
        """A leader weaves for ten seconds, and a follower joins it from the side: both stay with their ideal twins."""
        text = starter_with("pair", self._section(), self._pace())
        experiment = build(Loader().load_text(text, overrides=["duration=10"]), self._models())
        wheels = MujocoSimulation(make_scene(experiment.scene, experiment.robot), experiment.dt, spec=experiment.scene)
        ideal = IdealSimulation(experiment.network.names, None, experiment.dt)
        runs = [experiment.rollout(simulation) for simulation in (wheels, ideal)]
        for run in runs:
            run.require_whole()
        poses, twins = (run.variables["pose"] for run in runs)
        for k, name in enumerate(experiment.network.names):
            gap = _gap(poses[:, k], twins[:, k])
            self._require(gap, self.closed_loop, f"the {name} parts from its ideal twin, over its path")

    def test_several_stand_beside_each_other(self) -> None:
        """Three that can touch each other make a scene, weigh three times as much, and stay where they are."""
        models, names = self._models(), ("one", "two", "three")
        scene = make_scene(self._spec(robots=names, robot_contact=True))
        weight = float(scene.model.body_subtreemass[0])
        self._require(abs(weight / (3 * models.plant.mass) - 1), 1e-9, "three of it do not weigh three times as much")
        start = _at_rest(3)
        start.g[:, 0] = 20 * models.plant.half_separation * np.arange(3)
        simulation = MujocoSimulation(scene, _PERIOD)
        simulation.reset(start)
        g = simulation.drive_by(np.zeros((round(_STANDING / _PERIOD), 3, 2))).g[-1]
        crept = float(np.abs(g - start.g)[:, :2].max() / models.plant.wheel_radius)
        self._require(crept, self.rest, "three of it creep where they stand, over the radius of their wheels")

    def test_it_can_be_seen(self) -> None:
        """A picture of its scene shows it; skipped where nothing draws."""
        try:
            share = covered(make_scene(self._spec()), _size(self._models()))
        except RenderError as error:
            raise SkipTest(str(error)) from error
        if not share >= _SEEN:
            raise AssertionError(
                f"it covers {share:.2g} of a picture of it, less than {_SEEN:g}: is it in a hidden group?"
            )

    def _section(self) -> RobotSection:
        robot = str(self.robot)
        file = str(Path(robot).resolve()) if isinstance(self.robot, Path) else robot
        hints = self.hints
        return RobotSection.model_validate({"file": file, **vars(hints)})

    def _spec(self, **fields: object) -> SceneSpec:
        section = self._section()
        spec = {"robots": ("robot",), "robot": section.file, "hints": section.hints, "friction": self.friction}
        return SceneSpec(**(spec | fields))  # type: ignore[arg-type]

    def _models(self) -> RobotModels:
        return _read(self._spec())

    def _pace(self) -> Pace:
        limits = agile_limits(self._models().plant, Ground(self.friction), _USED)
        return pace_within(limits, self.friction, _USED)

    def _driven(self, u: Array) -> Array:
        """Returns poses after each period of held accelerations, from rest, shapes (periods, 3) and (periods, 2)."""
        spec = self._spec()
        simulation = MujocoSimulation(make_scene(spec, _read(spec)), _PERIOD)
        simulation.reset(_at_rest(1))
        return np.asarray(simulation.drive_by(np.ascontiguousarray(u[:, None])).g[:, 0])

    @staticmethod
    def _require(found: float, budget: float, said: str) -> None:
        if not found <= budget:
            raise AssertionError(f"{said}: {found:.3g}, at most {budget:g}")


_read = lru_cache(maxsize=4)(read_robot)


def _at_rest(count: int) -> State:
    return State(0.0, np.zeros((count, 3)), np.zeros((count, 3)))


def _size(models: RobotModels) -> float:
    """Returns how far a robot's supports lie from the middle of its axle [m]."""
    places = [(0.0, models.plant.half_separation), *models.plant.casters]
    return float(np.hypot(*np.array(places).T).max())


def _gap(g: Array, twin: Array) -> float:
    """Returns how far two runs part at most, over the length of the first one's path; shapes (t, 3)."""
    path = float(np.hypot(*np.diff(twin[:, :2], axis=0).T).sum())
    return float(np.hypot(*(g - twin)[:, :2].T).max() / path)
