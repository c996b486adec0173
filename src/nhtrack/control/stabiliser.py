"""The paper's pose stabiliser (Lemma 1)."""

from __future__ import annotations

from dataclasses import dataclass

from nhtrack.arrays import Array, namespace
from nhtrack.control.law import Leader, Memory, Robots
from nhtrack.control.published import gain_warnings
from nhtrack.control.relative import relative_motion, side_angle


@dataclass(frozen=True)
class Stabiliser:
    """The law of Lemma 1, which brings a follower to the pose of a leader at rest.

        u_theta = -kp (theta + k beta) - kd omega,   u_x = -kp q_x - kd v

    with (q_x, q_y, theta) the exponential coordinates of the follower seen from the leader, beta = -arctan(q_y/q_x),
    and the follower's own velocities.

    Assumes: a leader at rest (its motion is not looked at); states measured without error. Claims: convergence to the
    leader's pose from any start; needs k > 2 and kd >= 2 sqrt(kp), which the paper does not say
    (tests/property/test_laws.py).

    Attributes:
        kp: position gain [1/s^2].
        kd: damping gain [1/s].
        k: steering gain on beta [1].
        hysteresis: how far past the antipode the branch of log is kept [rad].
        dead_zone_length: |q| below which beta is taken as 0 [m].
    """

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

    def warnings(self) -> tuple[str, ...]:
        """Returns what the gains break, with the formula."""
        return gain_warnings(self.kp, self.kd, 0.0, self.k)
