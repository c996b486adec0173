"""Straight lines between waypoints and turns on the spot at them, each from rest to rest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from nhtrack.references.motion import Motion

_NO_TURN = 1e-9  # [rad]


class Pace(NamedTuple):
    """Limits of a move: of its rate and of the change of its rate."""

    rate: float
    change: float


@dataclass(frozen=True)
class Move:
    """A move from rest to rest: speeding up, going on, braking.

    Attributes:
        pose: x, y, theta before it.
        amount: how far ahead, or how much to the left where it turns.
        turns: whether it turns.
        begin: when it begins.
        pace: its limits.
    """

    pose: tuple[float, float, float]
    amount: float
    turns: bool
    begin: float
    pace: Pace

    @property
    def rise(self) -> float:
        """How long it speeds up, and brakes."""
        return min(self.pace.rate / self.pace.change, math.sqrt(abs(self.amount) / self.pace.change))

    @property
    def duration(self) -> float:
        """How long it takes."""
        return self.rise + abs(self.amount) / (self.pace.change * self.rise) if self.amount else 0.0

    def done(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns how much of it is done at times, and at which rate, shape (T,) each."""
        if not self.amount:
            return np.zeros(t.shape), np.zeros(t.shape)
        since, rise = np.clip(t - self.begin, 0.0, self.duration), self.rise
        early, late = np.minimum(since, rise), np.maximum(since - (self.duration - rise), 0.0)
        level = np.clip(since, rise, self.duration - rise) - rise
        change = math.copysign(self.pace.change, self.amount)
        return change * (0.5 * early**2 + rise * (level + late) - 0.5 * late**2), change * (early - late)


def make_moves(points: np.ndarray, laps: int, closed: bool, drive: Pace, turn: Pace, pause: float) -> tuple[Move, ...]:
    """Returns the moves along points, headed for the second at first; of a closed line back to that.

    Args:
        points: x, y, shape (n, 2), each other than the one before it.
        laps: how often a closed line is gone round.
        closed: whether the last point is joined to the first.
        drive: limits of speed and acceleration.
        turn: limits of yaw rate and yaw acceleration.
        pause: how long it stands at a point before it turns.
    """
    moves: list[Move] = []
    (x, y), *others = points.tolist()
    goals = [*others, [x, y]] * laps if closed else others
    first = theta = math.atan2(goals[0][1] - y, goals[0][0] - x)
    now = 0.0
    for goal in goals:
        heading = math.atan2(goal[1] - y, goal[0] - x)
        for amount, turns, pace in ((_wrapped(heading - theta), True, turn), (math.dist((x, y), goal), False, drive)):
            moves.append(Move((x, y, theta), amount, turns, now, pace))
            now += moves[-1].duration
            theta += amount if turns else 0.0
        (x, y), now = goal, now + pause
    if closed:
        moves.append(Move((x, y, theta), _wrapped(first - theta), True, now, turn))
    return tuple(moves)


def _wrapped(angle: float) -> float:
    """Returns an angle in (-pi, pi]: the shorter way round, to the left where both are as long; 0 for rounding."""
    wrapped = math.pi - (math.pi - angle) % (2 * math.pi)
    return wrapped if abs(wrapped) > _NO_TURN else 0.0


def moves_motion(moves: Sequence[Move]) -> Motion:
    """Returns the motion of moves one after the other."""
    begins = np.array([move.begin for move in moves])

    def sampled(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        poses, speeds = np.zeros((len(t), 3)), np.zeros((len(t), 2))
        which = np.searchsorted(begins, t, side="right") - 1
        for i in np.unique(which):
            move, here = moves[i], which == i
            done, rate = move.done(t[here])
            theta = move.pose[2]
            way = (0.0, 0.0, 1.0) if move.turns else (math.cos(theta), math.sin(theta), 0.0)
            poses[here] = np.array(move.pose) + done[:, None] * np.array(way)
            speeds[here, int(move.turns)] = rate
        return poses, speeds

    return Motion(lambda t: sampled(t)[0], lambda t: sampled(t)[1], moves[-1].begin + moves[-1].duration)
