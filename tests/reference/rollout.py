"""The loop in which a simulation and a law meet, as arrays: kept as second implementation."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf
from typing import NamedTuple

import numpy as np

from nhtrack import se2
from nhtrack.arrays import Array
from nhtrack.errors import SimulationDiverged
from nhtrack.network import Network
from nhtrack.recording import VARIABLES
from reference.laws import Law, Leader, Memory, Robots
from reference.laws.virtual_leader import Combination, Transform, VirtualLeader, VirtualMemory
from reference.physics.state import Simulation, State


@dataclass(frozen=True)
class Tracking:
    """How what a follower tracks is made from its parents."""

    offsets: Array | None = None
    virtual_leader: Combination = "convex"
    formation: Transform = "printed"
    dead_zone_speed: float = 0.0
    rate_limit: float = inf


@dataclass(frozen=True)
class Rollout:
    """What a loop leaves behind."""

    time: np.ndarray
    variables: dict[str, np.ndarray]
    qpos: np.ndarray | None
    failure: SimulationDiverged | None = None


@np.errstate(over="ignore", invalid="ignore")  # a run that diverges says so itself, with robot and time
def rollout(
    simulation: Simulation,
    law: Law,
    network: Network,
    inputs: np.ndarray,
    start: State,
    tracking: Tracking | None = None,
    telemetry: bool = True,
) -> Rollout:
    """Returns the run of a network under a law."""
    log, failure = _Log(len(inputs), telemetry), None
    try:
        for period in periods(simulation, law, network, inputs, start, tracking):
            log.write(period, simulation)
    except SimulationDiverged as error:
        failure = error
    return Rollout(*log.arrays(), failure)


class Period(NamedTuple):
    """A control period as it begins; the last one of a run is where the run ends, and nothing is commanded in it."""

    state: State
    tracked: State
    u: Array | None
    memories: Sequence[Memory]


def periods(
    simulation: Simulation,
    law: Law,
    network: Network,
    inputs: np.ndarray,
    start: State,
    tracking: Tracking | None = None,
) -> Iterator[Period]:
    """Yields the control periods of a run, see `rollout`, and keeps none of them: for runs too many to record."""
    state = simulation.reset(start)
    crew = _Crew(law, network, tracking or Tracking(), state, simulation.dt)
    for u_root in inputs:
        u, tracked = crew.command(state, u_root)
        yield Period(state, tracked, u, crew.memories)
        state = simulation.step(u)
    _, tracked = crew.command(state, inputs[-1])
    yield Period(state, tracked, None, crew.memories)


def tracking_error(period: Period) -> Array:
    """Returns the poses of robots seen from what they track, headings within (-pi, pi], NaN for the root."""
    error = se2.between(period.tracked.g, period.state.g)
    return np.concatenate([error[..., :2], se2.wrap(error[..., 2:])], axis=-1)


class _Crew:
    """The followers, grouped by level, with their memories."""

    def __init__(self, law: Law, network: Network, tracking: Tracking, start: State, dt: float) -> None:
        self._law = law
        self._levels = [_Level(network, tracking, robots, dt) for robots in network.levels[1:]]
        at_rest = np.zeros((*start.g.shape[:-1], 2))
        self._memories = [level.init(law, start, at_rest) for level in self._levels]

    @property
    def memories(self) -> list[Memory]:
        """The law's memory at each level."""
        return [memory for _, memory in self._memories]

    def command(self, state: State, u_root: Array) -> tuple[Array, State]:
        """Returns the accelerations of all robots, shape (..., n, 2), and what each tracks (NaN for the root)."""
        u = np.full((*state.g.shape[:-1], 2), np.nan)
        g, xi = np.full_like(state.g, np.nan), np.full_like(state.xi, np.nan)
        u[..., 0, :] = u_root
        for i, level in enumerate(self._levels):
            virtual, memory = self._memories[i]
            leader, virtual = level.leaders(level.parents(state, u), virtual)
            u[..., level.robots, :], memory = self._law(level.followers(state), leader, memory)
            g[..., level.robots, :], xi[..., level.robots, :] = leader.g, leader.xi
            self._memories[i] = (virtual, memory)
        return u, State(state.t, g, xi)


class _Level:
    """The robots at one distance from the root, and what makes their leaders."""

    def __init__(self, network: Network, tracking: Tracking, robots: Array, dt: float) -> None:
        self.robots = robots
        most = max(len(network.parents[robot]) for robot in robots)  # who has fewer repeats the last with weight 0
        missing = [(robot, most - len(network.parents[robot])) for robot in robots]
        self._parents = np.array([network.parents[robot] + network.parents[robot][-1:] * n for robot, n in missing])
        weights = np.array([network.weights[robot] + (0.0,) * n for robot, n in missing]).reshape(len(robots), most - 1)
        offsets = np.zeros((len(network), 2)) if tracking.offsets is None else tracking.offsets
        self.leaders = VirtualLeader(
            weights,
            offsets[robots],
            dt,
            tracking.virtual_leader,
            tracking.formation,
            tracking.dead_zone_speed,
            tracking.rate_limit,
        )

    def init(self, law: Law, state: State, u: Array) -> tuple[VirtualMemory, Memory]:
        """Returns the memories of the leaders and of the law to begin with."""
        parents = self.parents(state, u)
        memory = self.leaders.init(parents)
        leader, _ = self.leaders(parents, memory)
        return memory, law.init(self.followers(state), leader)

    def followers(self, state: State) -> Robots:
        return Robots(state.g[..., self.robots, :], state.xi[..., self.robots, :])

    def parents(self, state: State, u: Array) -> Leader:
        """Returns the parents of each robot, shapes (..., m, M, 3); a robot on wheels has no lateral acceleration."""
        commanded = u[..., self._parents, :]
        body = np.concatenate([commanded[..., :1], np.zeros_like(commanded[..., :1]), commanded[..., 1:]], axis=-1)
        return Leader(state.g[..., self._parents, :], state.xi[..., self._parents, :], body)


class _Log:
    """Rows of a run, written as they come; only whole rows are kept."""

    def __init__(self, periods: int, telemetry: bool) -> None:
        self._size, self._telemetry = periods + 1, telemetry
        self._rows = 0
        self._time = np.empty(self._size)
        self._arrays: dict[str, np.ndarray] = {}

    def write(self, period: Period, simulation: Simulation) -> None:
        """Adds a row: state, what was tracked, telemetry of the period before, command of the one to come."""
        state, tracked, u, _ = period
        error = tracking_error(period)
        row = {"pose": state.g, "twist": state.xi, "leader_pose": tracked.g, "leader_twist": tracked.xi, "error": error}
        row["input"] = np.full((*state.g.shape[:-1], 2), np.nan) if u is None else u
        row |= simulation.telemetry() if self._telemetry else {}
        qpos = getattr(simulation, "qpos", None)
        if qpos is not None:
            row["qpos"] = qpos
        for name, values in row.items():
            if name not in self._arrays:
                self._arrays[name] = np.empty((self._size, *values.shape))
            self._arrays[name][self._rows] = values
        self._time[self._rows] = state.t
        self._rows += 1

    def arrays(self) -> tuple[np.ndarray, dict[str, np.ndarray], np.ndarray | None]:
        """Returns times, variables and qpos of the rows written."""
        kept = {name: values[: self._rows] for name, values in self._arrays.items()}
        qpos = kept.pop("qpos", None)
        return self._time[: self._rows], {name: kept[name] for name in VARIABLES if name in kept}, qpos
