"""From a scenario, in its own units, to the objects that run it, in the robot's."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import inf

import numpy as np

from nhtrack.arrays import Array
from nhtrack.config.law_sections import LawSection
from nhtrack.config.robots import Start
from nhtrack.config.scenario import Scenario
from nhtrack.effects import effects_of
from nhtrack.errors import FeasibilityError, SimulationDiverged
from nhtrack.experiment.driven import patches_met
from nhtrack.experiment.followers import Tracking
from nhtrack.experiment.kernels import CompiledSimulation
from nhtrack.experiment.limits import motion_limits
from nhtrack.experiment.link import Link
from nhtrack.experiment.loop import Progress, Rollout, rollout, run_loop
from nhtrack.experiment.recorder import KeepingRecorder, Recorder
from nhtrack.laws import Law, Limits
from nhtrack.network import Network
from nhtrack.similarity import Similarity
from nhtrack.simulation.guard import read_sound_robot
from nhtrack.simulation.robot_models import RobotModels
from nhtrack.simulation.spec import SceneSpec
from nhtrack.simulation.state import State

# Speed of a place in a formation below which its direction is noise, for a law that has no such gain [m/s].
_DEAD_ZONE_SPEED = 1e-3


@dataclass(frozen=True)
class Experiment:
    """All that a rollout needs, in robot units.

    Attributes:
        network: who tracks whom.
        tracking: how what a follower tracks is made from its parents.
        law: what every follower obeys.
        start: the state to begin with, shape (n, 3).
        inputs: accelerations (u_x, u_theta) of the root for each control period, shape (periods, 2): those of signals
            at the middle of the period, which makes a held input follow a smooth one to second order and a piecewise
            constant one exactly; those of a path such that the ideal root is on it at the end of each period.
        dt: control period [s].
        similarity: scenario units to the robot's.
        scene: what to compose for MuJoCo.
        robot: what was read from the robots' MJCF, with the scene's effects.
        every: every so many control periods a row is kept.
        link: what lies between robots and their laws.
    """

    network: Network
    tracking: Tracking
    law: Law
    start: State
    inputs: np.ndarray
    dt: float
    similarity: Similarity
    scene: SceneSpec
    robot: RobotModels
    every: int = 1
    link: Link = field(default_factory=Link)

    @property
    def size(self) -> float:
        """The larger of the scenario's length unit and the farthest place in its formation [m]."""
        offsets = self.tracking.offsets
        farthest = 0.0 if offsets is None else float(np.hypot(*offsets.T).max())
        return max(self.similarity.length, farthest)

    def rollout(
        self,
        simulation: CompiledSimulation,
        progress: Progress | None = None,
        batch: tuple[int, ...] = (),
        recorder: KeepingRecorder | None = None,
    ) -> Rollout:
        """Returns the run of this experiment in a simulation; in a batch of them, all from the same start."""
        start = State(self.start.t, *(np.broadcast_to(x, (*batch, *x.shape)) for x in (self.start.g, self.start.xi)))
        return rollout(
            simulation, self.law, self.network, self.inputs, start, self.tracking, progress, recorder, self.every,
            self.link,
        )  # fmt: skip

    def record(self, simulation: CompiledSimulation, recorder: Recorder, threads: int = 1) -> SimulationDiverged | None:
        """Runs this experiment in a simulation and returns why it ended early, or None; see `run_loop`."""
        return run_loop(
            simulation, self.law, self.network, self.inputs, self.start, recorder, self.tracking, threads=threads,
            link=self.link,
        )  # fmt: skip


def build(scenario: Scenario, robot: RobotModels | None = None) -> Experiment:
    """Returns the experiment of a scenario.

    Args:
        scenario: with a number for its time scale.
        robot: see `robot_of`, where it has been read already.

    Raises:
        RobotError: the robot cannot be found, compiled or driven.
        ReferenceInputError: the leader's input has no finite value at some time.
        TypeError: `similarity.time` is still `auto`.
        FeasibilityError: the law is to keep limits, and ground or motors leave none.
        ValueError: what is known is of other robots.
    """
    similarity = Similarity(scenario.similarity.length, scenario.similarity.time_scale)
    network = Network.from_parents(scenario.parents, scenario.weights)
    dt = 1.0 / scenario.control_rate
    scene = make_scene_spec(scenario)
    robot = robot or read_sound_robot(scene)
    robot.require(scene)
    return Experiment(
        network=network,
        tracking=_tracking(scenario, network, similarity),
        law=make_law(scenario.law, similarity, make_limits(scenario, robot)),
        start=start_of(scenario, similarity),
        inputs=similarity.inputs_to_robot(scenario.leader.input.reference().held(instants_of(scenario))),
        dt=dt,
        similarity=similarity,
        scene=scene,
        robot=robot,
        every=scenario.record.every,
        link=_link(scenario, similarity),
    )


def instants_of(scenario: Scenario) -> np.ndarray:
    """Returns the times between control periods and at both ends [scenario time], shape (periods + 1,)."""
    return np.arange(scenario.periods + 1) / (scenario.control_rate * scenario.similarity.time_scale)


def make_scene_spec(scenario: Scenario) -> SceneSpec:
    """Returns what to compose for MuJoCo; needs no time scale."""
    physics, length = scenario.physics, scenario.similarity.length
    return SceneSpec(
        robots=tuple(scenario.parents),
        robot=scenario.robot.file,
        hints=scenario.robot.hints,
        timestep=physics.timestep,
        friction=physics.friction,
        contact=physics.contact.model,
        rate_correction=physics.contact.rate_correction,
        robot_contact=physics.robot_contact,
        virtual_root=scenario.leader.virtual,
        effects=effects_of(physics, length),
        compensation=physics.compensation,
    )


def robot_of(scenario: Scenario) -> RobotModels:
    """Returns what is read from the MJCF of a scenario's robot, under its effects; needs no time scale.

    Raises:
        RobotError: the robot cannot be found, compiled or driven.
    """
    return read_sound_robot(make_scene_spec(scenario))


def make_limits(scenario: Scenario, robot: RobotModels | None = None) -> Limits | None:
    """Returns the limits that a scenario's law keeps, in robot units, or None; needs no time scale.

    Args:
        scenario: whose law.
        robot: see `robot_of`, where it has been read already.

    Raises:
        FeasibilityError: ground or motors leave none.
    """
    wanted = getattr(scenario.law, "limits", None)
    if wanted is None:
        return None
    plant, ground = (robot or robot_of(scenario)).plant, make_scene_spec(scenario).ground
    everywhere = wanted.everywhere or not ground.patches
    met = range(len(ground.patches)) if everywhere else patches_met(scenario, ground, 2 * plant.half_separation)
    counted = replace(ground, patches=tuple(ground.patches[i] for i in met))
    try:
        return motion_limits(plant, counted, wanted.utilisation, wanted.speed)
    except FeasibilityError as error:
        keys = {"physics.friction": ground.friction}
        keys |= {f"physics.patches[{i}].friction": ground.patches[i].friction for i in met}
        least = min(keys, key=lambda key: keys[key])
        raise FeasibilityError(f"law.limits: {error}; the least friction is {least}") from error


def make_law(law: LawSection, similarity: Similarity, limits: Limits | None = None) -> Law:
    """Returns the law of a scenario with its gains in robot units; limits are in robot units already."""
    return law.kind(limits=limits, delay_periods=law.delay_periods, **law.gains(similarity))


def _tracking(scenario: Scenario, network: Network, similarity: Similarity) -> Tracking:
    places = {follower.name: follower.offset for follower in scenario.followers}
    offsets = np.array([places.get(name, (0.0, 0.0)) for name in network.names])
    return Tracking(
        offsets=similarity.length * offsets,
        virtual_leader=scenario.virtual_leader,
        formation=scenario.formation,
        dead_zone_speed=scenario.law.robot_gain("dead_zone_speed", similarity, _DEAD_ZONE_SPEED),
        rate_limit=scenario.law.robot_gain("turn_rate", similarity, inf),
    )


def _link(scenario: Scenario, similarity: Similarity) -> Link:
    """Returns what lies between robots and their laws."""
    noise, scale = scenario.noise, similarity.scale
    deviations = (
        scale(noise.position, 1, 0), noise.heading, scale(noise.speed, 1, -1), scale(noise.turning, 0, -1),
    )  # fmt: skip
    return Link(scenario.delay, deviations, seeds_of(scenario.seed))


def seeds_of(*seeds: int) -> Array:
    """Returns seeds as compiled code takes them, shape (b,): the last 64 bits of each."""
    return np.array([seed % 2**64 for seed in seeds], dtype=np.uint64)


def start_poses(scenario: Scenario) -> np.ndarray:
    """Returns the poses that robots begin with, root first, in robot units, shape (n, 3); needs no time scale."""
    pose = np.array([start.pose for start in _starts(scenario)])
    return np.asarray(Similarity(scenario.similarity.length, 1.0).poses_to_robot(pose))


def start_of(scenario: Scenario, similarity: Similarity) -> State:
    """Returns the state that robots begin with, root first, in robot units, shape (n, 3)."""
    twist = np.array([(start.twist[0], 0.0, start.twist[1]) for start in _starts(scenario)])
    return State(0.0, start_poses(scenario), similarity.twists_to_robot(twist))


def _starts(scenario: Scenario) -> tuple[Start, ...]:
    return scenario.leader.start, *(follower.start for follower in scenario.followers)
