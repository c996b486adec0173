"""The paper's pose stabiliser (Lemma 1), as arrays: kept as second implementation."""

from __future__ import annotations

from dataclasses import dataclass

from nhtrack.arrays import Array, namespace
from reference.laws.law import Leader, Memory, Robots
from reference.laws.relative import relative_motion, side_angle


@dataclass(frozen=True)
class Stabiliser:
    """The law of Lemma 1, which brings a follower to the pose of a leader at rest."""

    kp: float
    kd: float
    k: float
    hysteresis: float = 0.25
    dead_zone_length: float = 0.0

    def init(self, follower: Robots, leader: Leader) -> Memory:
        """Returns the winding numbers of the relative headings; pi and -pi keep their signs."""
        return relative_motion(follower, leader, None, self.hysteresis).turns

    def __call__(self, follower: Robots, leader: Leader, memory: Memory) -> tuple[Array, Memory]:
        """Returns the accelerations (u_x, u_theta), shape (..., 2), and the winding numbers."""
        xp = namespace(follower.g)
        relative = relative_motion(follower, leader, memory, self.hysteresis)
        beta = side_angle(relative, self.dead_zone_length)
        u_theta = -self.kp * (relative.g[..., 2] + self.k * beta) - self.kd * follower.xi[..., 2]
        u_x = -self.kp * relative.q[..., 0] - self.kd * follower.xi[..., 0]
        return xp.stack([u_x, u_theta], axis=-1), relative.turns
