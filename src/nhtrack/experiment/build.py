"""From a scenario, in its own units, to the objects that run it, in the robot's."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np

from nhtrack.config import schema
from nhtrack.config.law_sections import LawSection
from nhtrack.errors import SimulationDiverged
from nhtrack.experiment.followers import Tracking
from nhtrack.experiment.limits import motion_limits
from nhtrack.experiment.loop import Progress, Rollout, Simulation, rollout, run
from nhtrack.experiment.recorder import FullRecorder, Recorder
from nhtrack.ground import Patch
from nhtrack.laws import Law, Limits
from nhtrack.network import Network
from nhtrack.references import Reference, Signal, make_segments, make_signal
from nhtrack.similarity import Similarity
from nhtrack.simulation.scene import Payload, SceneSpec, reduced_models
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
        inputs: accelerations (u_x, u_theta) of the root for each control period, shape (periods, 2): the
            reference at the middle of the period, which makes a held input follow a smooth one to second
            order and a piecewise constant one exactly.
        dt: control period [s].
        similarity: scenario units to the robot's.
        scene: what to compose for MuJoCo.
        every: every so many control periods a row is kept.
    """

    network: Network
    tracking: Tracking
    law: Law
    start: State
    inputs: np.ndarray
    dt: float
    similarity: Similarity
    scene: SceneSpec
    every: int = 1

    @property
    def size(self) -> float:
        """The larger of the scenario's length unit and the farthest place in its formation [m]."""
        offsets = self.tracking.offsets
        farthest = 0.0 if offsets is None else float(np.hypot(*offsets.T).max())
        return max(self.similarity.length, farthest)

    def rollout(
        self,
        simulation: Simulation,
        progress: Progress | None = None,
        batch: tuple[int, ...] = (),
        recorder: FullRecorder | None = None,
    ) -> Rollout:
        """Returns the run of this experiment in a simulation; in a batch of them, all from the same start."""
        start = State(self.start.t, *(np.broadcast_to(x, (*batch, *x.shape)) for x in (self.start.g, self.start.xi)))
        return rollout(
            simulation, self.law, self.network, self.inputs, start, self.tracking, progress, recorder, self.every
        )

    def record(self, simulation: Simulation, recorder: Recorder, threads: int = 1) -> SimulationDiverged | None:
        """Runs this experiment in a simulation and returns why it ended early, or None; see `run`."""
        return run(
            simulation, self.law, self.network, self.inputs, self.start, recorder, self.tracking, threads=threads
        )


def build(scenario: schema.Scenario) -> Experiment:
    """Returns the experiment of a scenario.

    Raises:
        ReferenceInputError: the leader's input has no finite value at some time.
        TypeError: `similarity.time` is still `auto`.
        FeasibilityError: the law is to keep limits, and ground or motors leave none.
    """
    similarity = Similarity(scenario.similarity.length, scenario.similarity.time_scale)
    network = Network.from_parents(scenario.parents, scenario.weights)
    dt = 1.0 / scenario.control_rate
    middles = similarity.times_to_scenario((np.arange(scenario.periods) + 0.5) * dt)
    return Experiment(
        network=network,
        tracking=_tracking(scenario, network, similarity),
        law=make_law(scenario.law, similarity, make_limits(scenario)),
        start=_start(scenario, network, similarity),
        inputs=similarity.inputs_to_robot(make_reference(scenario.leader.input).sample(middles)),
        dt=dt,
        similarity=similarity,
        scene=make_scene_spec(scenario),
        every=scenario.record.every,
    )


def make_scene_spec(scenario: schema.Scenario) -> SceneSpec:
    """Returns what to compose for MuJoCo; needs no time scale."""
    physics, length = scenario.physics, scenario.similarity.length
    return SceneSpec(
        robots=tuple(scenario.parents),
        robot=scenario.robot,
        timestep=physics.timestep,
        friction=physics.friction,
        contact=physics.contact.model,
        rate_correction=physics.contact.rate_correction,
        robot_contact=physics.robot_contact,
        virtual_root=scenario.leader.virtual,
        base=physics.base,
        patches=tuple(_patch(patch, length) for patch in physics.patches),
        slope=physics.slope.angle,
        uphill=physics.slope.uphill,
        payload=make_payload(physics.payload),
        wheel_mismatch=physics.wheel_mismatch,
        torque_limit=physics.motors.torque_limit,
        no_load_speed=physics.motors.no_load_speed,
        compensation=physics.compensation,
    )


def _patch(patch: schema.Patch, length: float) -> Patch:
    shapes = {name: getattr(patch, name) for name in ("disc", "rectangle")}
    scaled = {name: None if sides is None else tuple(length * side for side in sides) for name, sides in shapes.items()}
    return Patch(patch.friction, **scaled)


def make_payload(payload: schema.Payload | None) -> Payload | None:
    """Returns what robots carry; payloads are in robot units already."""
    return None if payload is None else Payload(payload.mass, (*payload.offset, payload.height), payload.size)


def make_limits(scenario: schema.Scenario) -> Limits | None:
    """Returns the limits that a scenario's law keeps, in robot units, or None; needs no time scale.

    Raises:
        FeasibilityError: ground or motors leave none.
    """
    wanted = getattr(scenario.law, "limits", None)
    if wanted is None:
        return None
    spec = make_scene_spec(scenario)
    return motion_limits(reduced_models(spec)[1], spec.ground, wanted.utilisation, wanted.speed)


def make_law(law: LawSection, similarity: Similarity, limits: Limits | None = None) -> Law:
    """Returns the law of a scenario with its gains in robot units; limits are in robot units already."""
    return law.kind(limits=limits, **law.gains(similarity))


def make_reference(given: schema.Input) -> Reference:
    """Returns the reference of a leader's input, in scenario units."""
    match given:
        case schema.TableInput(table=table):
            return Reference.from_table(table.t, table.u_x, table.u_theta, given.interpolation)
        case schema.SignalInput():
            return Reference(_signal(given.u_x), _signal(given.u_theta))
        case _:
            raise TypeError("a CSV input becomes a table when the scenario is loaded; load it with nhtrack.load")


def _signal(given: schema.Signal) -> Signal:
    if isinstance(given, tuple):
        return make_segments([(segment.until, segment.value) for segment in given])
    return make_signal(given)


def _tracking(scenario: schema.Scenario, network: Network, similarity: Similarity) -> Tracking:
    places = {follower.name: follower.offset for follower in scenario.followers}
    offsets = np.array([places.get(name, (0.0, 0.0)) for name in network.names])
    return Tracking(
        offsets=similarity.length * offsets,
        virtual_leader=scenario.virtual_leader,
        formation=scenario.formation,
        dead_zone_speed=scenario.law.robot_gain("dead_zone_speed", similarity, _DEAD_ZONE_SPEED),
        rate_limit=scenario.law.robot_gain("turn_rate", similarity, inf),
    )


def _start(scenario: schema.Scenario, network: Network, similarity: Similarity) -> State:
    starts = {scenario.leader.name: scenario.leader.start} | {f.name: f.start for f in scenario.followers}
    pose = np.array([starts[name].pose for name in network.names])
    twist = np.array([(starts[name].twist[0], 0.0, starts[name].twist[1]) for name in network.names])
    return State(0.0, similarity.poses_to_robot(pose), similarity.twists_to_robot(twist))
