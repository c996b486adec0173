"""From a loaded scenario to its run on the array code."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Literal

import numpy as np

from nhtrack.config.law_sections import LawSection
from nhtrack.config.scenario import Scenario
from nhtrack.experiment.build import make_scene_spec
from nhtrack.network import Network
from nhtrack.similarity import Similarity
from nhtrack.simulation.robot_models import read_robot
from nhtrack.simulation.spec import SceneSpec
from reference.laws import BASELINES, Law, Limits, Published, Stabiliser, Universal
from reference.motion_limits import motion_limits
from reference.physics.ideal import IdealSimulation
from reference.physics.mujoco import MujocoSimulation
from reference.physics.scene import make_scene
from reference.physics.state import State
from reference.rollout import Rollout, Tracking, rollout

Backend = Literal["mujoco", "ideal"]


def run_reference(
    scenario: Scenario,
    duration_periods: int | None = None,
    backend: Backend | None = None,
    nudge: float = 0.0,
    *,
    telemetry: bool = True,
) -> dict[str, np.ndarray]:
    """Returns `time` [s], the variables of `nhtrack.recording.VARIABLES`, and `qpos` where MuJoCo ran.

    Rows are the starts of the control periods and the end of the last; a run that diverges has fewer.

    Args:
        scenario: a loaded scenario with a number for its time scale.
        duration_periods: how many control periods to run, or None for all.
        backend: what to run on instead of the scenario's own.
        nudge: how far to move the start of every robot but the root along x [m].
        telemetry: whether the variables that say what wheels did are wanted.

    Raises:
        ValueError: the scenario says `time: auto`.
    """
    experiment = build(scenario, duration_periods)
    experiment.start.g[1:, 0] += nudge
    names, dt = experiment.network.names, experiment.dt
    drive = read_robot(experiment.scene).plant
    main = twin = experiment.rollout(IdealSimulation(names, drive, dt, experiment.scene.ground), telemetry)
    if (backend or scenario.backend) == "mujoco":
        main = experiment.rollout(MujocoSimulation(make_scene(experiment.scene), dt), telemetry)
    shared = min(len(main.time), len(twin.time))
    ideal_pose = np.full_like(main.variables["pose"], np.nan)
    ideal_pose[:shared] = twin.variables["pose"][:shared]
    found = {"time": main.time, **main.variables, "ideal_pose": ideal_pose}
    return found if main.qpos is None else found | {"qpos": main.qpos}


@dataclass(frozen=True)
class Experiment:
    """All that a rollout needs, in robot units."""

    network: Network
    tracking: Tracking
    law: Law
    start: State
    inputs: np.ndarray
    dt: float
    scene: SceneSpec

    def rollout(self, simulation: IdealSimulation | MujocoSimulation, telemetry: bool) -> Rollout:
        """Returns the run of this experiment in a simulation."""
        return rollout(simulation, self.law, self.network, self.inputs, self.start, self.tracking, telemetry)


def build(scenario: Scenario, periods: int | None = None) -> Experiment:
    """Returns the experiment of a scenario; the leader's input is taken at the middle of each period."""
    if scenario.similarity.time == "auto":
        raise ValueError("similarity.time: auto; put the number there first")
    similarity = Similarity(scenario.similarity.length, scenario.similarity.time)
    network = Network.from_parents(scenario.parents, scenario.weights)
    dt = 1.0 / scenario.control_rate
    count = max(1, round(scenario.duration * similarity.time * scenario.control_rate))
    count = count if periods is None else min(periods, count)
    instants = similarity.times_to_scenario(np.arange(count + 1) * dt)
    return Experiment(
        network=network,
        tracking=_tracking(scenario, network, similarity),
        law=_law(scenario.law, similarity, _limits(scenario)),
        start=_start(scenario, network, similarity),
        inputs=similarity.inputs_to_robot(scenario.leader.input.reference().held(instants)),
        dt=dt,
        scene=make_scene_spec(scenario),
    )


def _limits(scenario: Scenario) -> Limits | None:
    wanted = getattr(scenario.law, "limits", None)
    if wanted is None:
        return None
    spec = make_scene_spec(scenario)
    return motion_limits(read_robot(spec).plant, spec.ground, wanted.utilisation, wanted.speed)


def _law(law: LawSection, similarity: Similarity, limits: Limits | None) -> Law:
    match law.name:
        case "published":
            gains = law.kp / similarity.time**2, law.kd / similarity.time, law.ke / similarity.time**2, law.k
            return Published(*gains, law.variant, law.hysteresis, law.dead_zone.length, law.dead_zone.speed)
        case "stabiliser":
            gains = law.kp / similarity.time**2, law.kd / similarity.time, law.k
            return Stabiliser(*gains, law.hysteresis, law.dead_zone.length)
        case "universal":
            length, time = similarity.length, similarity.time
            return Universal(
                k1=law.k1 / time**2,
                k2=law.k2 / time,
                k3=law.k3 / time,
                c=law.c / time,
                m=law.m,
                field_speed=law.field_speed * length / time,
                turn_rate=law.turn_rate / time,
                dock_radius=law.dock_radius * length,
                dock_speed=law.dock_speed * length / time,
                limits=limits,
            )
        case _:
            kind = BASELINES[law.name]
            return kind(
                **{gain: similarity.scale(getattr(law, gain), *powers) for gain, powers in kind.dimensions.items()}
            )


def _tracking(scenario: Scenario, network: Network, similarity: Similarity) -> Tracking:
    places = {follower.name: follower.offset for follower in scenario.followers}
    offsets = np.array([places.get(name, (0.0, 0.0)) for name in network.names])
    return Tracking(
        offsets=similarity.length * offsets,
        virtual_leader=scenario.virtual_leader,
        formation=scenario.formation,
        dead_zone_speed=scenario.law.dead_zone.speed,
        rate_limit=getattr(scenario.law, "turn_rate", inf) / similarity.time,
    )


def _start(scenario: Scenario, network: Network, similarity: Similarity) -> State:
    starts = {scenario.leader.name: scenario.leader.start} | {f.name: f.start for f in scenario.followers}
    pose = np.array([starts[name].pose for name in network.names])
    twist = np.array([(starts[name].twist[0], 0.0, starts[name].twist[1]) for name in network.names])
    return State(0.0, similarity.poses_to_robot(pose), similarity.twists_to_robot(twist))
