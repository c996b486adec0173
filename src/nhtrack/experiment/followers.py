"""What every follower tracks and commands, compiled: virtual leaders first, then the law, called by its address."""

from __future__ import annotations

import math
from dataclasses import dataclass
from math import inf
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from nhtrack.arrays import Array
from nhtrack.compiled import call_6, compiled_inside, compiled_loop
from nhtrack.experiment.link import Channel, Link, make_channel, make_commands, pass_on, see_own
from nhtrack.laws.address import FAILED, entry_of
from nhtrack.laws.contract import Follower, Leader
from nhtrack.laws.law import Law
from nhtrack.laws.virtual_leader import displace, fold
from nhtrack.network import Network
from nhtrack.simulation.motion import copy

Combination: TypeAlias = Literal["convex", "exact"]
Transform: TypeAlias = Literal["printed", "exact"]


@dataclass(frozen=True)
class Tracking:
    """How what a follower tracks is made from its parents.

    Attributes:
        offsets: places of the robots in the frames of their (virtual) leaders [m], shape (n, 2), or None.
        virtual_leader: twist of a leader folded from several parents, see `nhtrack.laws.virtual_leader.fold`.
        formation: twist of a leader displaced by an offset, see `nhtrack.laws.virtual_leader.displace`.
        dead_zone_speed: speed below which the attitude of a place is that of its leader [m/s].
        rate_limit: largest rate of the attitude of a place with the transform `exact` [rad/s].
    """

    offsets: Array | None = None
    virtual_leader: Combination = "convex"
    formation: Transform = "printed"
    dead_zone_speed: float = 0.0
    rate_limit: float = inf


class Followers(NamedTuple):
    """Who tracks whom and how, for compiled code; n robots, m followers, e edges.

    Attributes:
        order: followers, parents before children, shape (m,).
        first: where the edges of each robot begin, shape (n + 1,).
        parents: of each edge, shape (e,).
        weights: lambda of the fold that takes in an edge's parent; of a first parent nothing; shape (e,).
        offsets: see `Tracking`, shape (n, 2).
        exact_fold: whether folds are differentiated.
        exact_place: whether the attitude of a place moves.
        dead_zone_speed: see `Tracking`.
        rate_limit: see `Tracking`.
        dt: control period [s].
        init: address of the law's.
        command: address of the law's.
        gains: of the law, shape (1 or b, gains).
        context: period and limits, shape (5,).
        channel: between robots and the law.
    """

    order: np.ndarray
    first: np.ndarray
    parents: np.ndarray
    weights: np.ndarray
    offsets: np.ndarray
    exact_fold: bool
    exact_place: bool
    dead_zone_speed: float
    rate_limit: float
    dt: float
    init: int
    command: int
    gains: np.ndarray
    context: np.ndarray
    channel: Channel


class Memories(NamedTuple):
    """What followers remember, in b simulations, and what they see.

    Attributes:
        law: memory of the law, shape (b, n, values).
        turns: winding numbers of the folds, shape (b, e).
        rate: of the attitude of a place in the last period [rad/s], NaN before the first; shape (b, n).
        tracked: leaders of this period, as `nhtrack.laws.contract.Leader`, NaN for the root; shape (b, n, 9).
        commands: what the law asked for in the last periods, see `nhtrack.experiment.link`.
        asked: what a law that raised was called with, follower and leader, shape (b, 15).
    """

    law: np.ndarray
    turns: np.ndarray
    rate: np.ndarray
    tracked: np.ndarray
    commands: np.ndarray
    asked: np.ndarray


class Scratch(NamedTuple):
    """Memory of one thread: what a law is called with, follower (6,), leader (9,), result (3,); commands u (n, 2)."""

    follower: np.ndarray
    leader: np.ndarray
    result: np.ndarray
    u: np.ndarray


def make_followers(network: Network, tracking: Tracking, law: Law, dt: float, link: Link) -> Followers:
    """Returns who tracks whom, and how, for compiled code."""
    n = len(network)
    offsets = np.zeros((n, 2)) if tracking.offsets is None else np.asarray(tracking.offsets, dtype=float)
    counts = [len(parents) for parents in network.parents]
    edges = [parent for parents in network.parents for parent in parents]
    weights = [w for i in range(n) if counts[i] for w in (0.0, *network.weights[i])]
    return Followers(
        order=np.concatenate([np.empty(0, np.int64), *network.levels[1:]]).astype(np.int64),
        first=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        parents=np.array(edges, dtype=np.int64),
        weights=np.array(weights, dtype=float),
        offsets=np.ascontiguousarray(offsets),
        exact_fold=tracking.virtual_leader == "exact",
        exact_place=tracking.formation == "exact",
        dead_zone_speed=float(tracking.dead_zone_speed),
        rate_limit=float(tracking.rate_limit),
        dt=float(dt),
        init=entry_of(law.kind).init,
        command=entry_of(law.kind).command,
        gains=law.gain_rows,
        context=np.array([dt, *law.limits], dtype=float),
        channel=make_channel(link, law.delay_periods, dt),
    )


def make_memories(followers: Followers, law: Law, simulations: int) -> Memories:
    """Returns memories with nothing in them."""
    n = len(followers.offsets)
    return Memories(
        law=np.zeros((simulations, n, max(law.kind.memory_size, 1))),
        turns=np.zeros((simulations, max(len(followers.parents), 1))),
        rate=np.full((simulations, n), math.nan),
        tracked=np.full((simulations, n, len(Leader._fields)), math.nan),
        commands=make_commands(followers.channel, simulations, n),
        asked=np.full((simulations, len(Follower._fields) + len(Leader._fields)), math.nan),
    )


def make_scratch(robots: int) -> Scratch:
    """Returns the memory of one thread."""
    return Scratch(np.zeros(6), np.zeros(9), np.zeros(3), np.zeros((robots, 2)))


@compiled_loop
def begin_followers(
    followers: Followers, memories: Memories, g: np.ndarray, xi: np.ndarray, scratch: Scratch
) -> int:
    """Gives every follower of all simulations its first memory; returns the first one whose law raised, or -1.

    Leaders are seen as if nothing had been commanded.

    Args:
        followers: who tracks whom.
        memories: changed.
        g: poses, shape (b, n, 3).
        xi: twists, shape (b, n, 3).
        scratch: of the thread, with commands of zero.
    """
    for b in range(g.shape[0]):
        for robot in followers.order:
            memories.rate[b, robot] = math.nan
            _see(followers, memories, b, robot, 0, g[b], xi[b], False, scratch)
            memories.rate[b, robot] = math.nan
            if not _call(followers, memories, b, robot, followers.init, scratch):
                return int(robot)
    return -1


@compiled_inside
def command_followers(
    followers: Followers, memories: Memories, b: int, period: int, g: np.ndarray, xi: np.ndarray, scratch: Scratch
) -> int:
    """Commands all followers of a simulation; returns the first one whose law raised, or -1.

    Args:
        followers: who tracks whom.
        memories: changed.
        b: which simulation.
        period: since the start.
        g: its poses, shape (n, 3).
        xi: its twists, shape (n, 3).
        scratch: of the thread; of its commands that of the root is given, the others are written.
    """
    for k in range(followers.order.shape[0]):
        robot = followers.order[k]
        _see(followers, memories, b, robot, period, g, xi, True, scratch)
        if not _call(followers, memories, b, robot, followers.command, scratch):
            return int(robot)
        pass_on(followers.channel, memories.commands[b, robot], period, scratch.result, scratch.u[robot])
    return -1


@compiled_inside
def _call(followers: Followers, memories: Memories, b: int, robot: int, address: int, scratch: Scratch) -> bool:
    """Calls a function of the law; returns whether it came back without an exception."""
    own = b if followers.gains.shape[0] > 1 else 0
    scratch.result[FAILED] = 0.0
    call_6(
        address,
        followers.gains[own].ctypes.data,
        followers.context.ctypes.data,
        scratch.follower.ctypes.data,
        scratch.leader.ctypes.data,
        memories.law[b, robot].ctypes.data,
        scratch.result.ctypes.data,
    )
    if scratch.result[FAILED] == 0.0:
        return True
    copy(memories.asked[b, :6], scratch.follower)
    copy(memories.asked[b, 6:], scratch.leader)
    return False


@compiled_inside
def _see(
    followers: Followers, memories: Memories, b: int, robot: int, period: int, g: np.ndarray, xi: np.ndarray,
    known: bool, scratch: Scratch,
) -> None:  # fmt: skip
    """Writes the follower and what it tracks into the thread's memory."""
    u = scratch.u
    leader = _parent(followers.parents[followers.first[robot]], g, xi, u)
    for edge in range(followers.first[robot] + 1, followers.first[robot + 1]):
        other = _parent(followers.parents[edge], g, xi, u)
        leader, memories.turns[b, edge] = fold(
            leader, other, followers.weights[edge], followers.exact_fold, memories.turns[b, edge], known
        )
    x, y = followers.offsets[robot, 0], followers.offsets[robot, 1]
    if x != 0.0 or y != 0.0:
        leader, rate = displace(
            leader, x, y, followers.exact_place, followers.dead_zone_speed, followers.rate_limit
        )
        if followers.exact_place:
            before, limit = memories.rate[b, robot], followers.rate_limit * followers.rate_limit
            second = 0.0 if math.isnan(before) else min(max((rate - before) / followers.dt, -limit), limit)
            leader = Leader(
                leader.x, leader.y, leader.theta, leader.v_x, leader.v_y, leader.omega, leader.u_x, leader.u_y,
                leader.u_theta + second,
            )  # fmt: skip
        memories.rate[b, robot] = rate
    for c, value in enumerate(leader):
        scratch.leader[c] = value
    see_own(
        followers.channel, memories.commands[b, robot], b, robot, period, g[robot], xi[robot],
        memories.tracked[b, robot], scratch.follower, scratch.leader,
    )  # fmt: skip
    for c, value in enumerate(leader):
        memories.tracked[b, robot, c] = value


@compiled_inside
def _parent(robot: int, g: np.ndarray, xi: np.ndarray, u: np.ndarray) -> Leader:
    """Returns a robot as a leader; one on wheels has no lateral acceleration."""
    return Leader(
        g[robot, 0], g[robot, 1], g[robot, 2], xi[robot, 0], xi[robot, 1], xi[robot, 2], u[robot, 0], 0.0, u[robot, 1]
    )
