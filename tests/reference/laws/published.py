"""The paper's tracking law (Theorem 1, eq. 26), as arrays: kept as second implementation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from nhtrack import se2
from nhtrack.arrays import Array, namespace
from reference.laws.law import Leader, Memory, Robots
from reference.laws.relative import adjoint_attitude, relative_motion, side_angle


@dataclass(frozen=True)
class Published:
    """The tracking law of Theorem 1, paper eq. 26.

        u_theta1 = -ke (theta01 - theta~01) - kp (theta01 + k beta) - kd omega01 + u_theta0
        u_x1     = -kp q_x - kd v_x01 + (u_x0 - u_theta0 r_y) cos theta01 + u_theta0 r_x sin theta01

    `variant="full"` adds the x component of the bracket [xi_1, xi_01] to u_x1 (eq. 25).
    """

    kp: float
    kd: float
    ke: float
    k: float
    variant: Literal["published", "full"] = "published"
    hysteresis: float = 0.25
    dead_zone_length: float = 0.0
    dead_zone_speed: float = 0.0

    def init(self, follower: Robots, leader: Leader) -> Memory:
        """Returns the winding numbers of the relative headings; pi and -pi keep their signs."""
        return relative_motion(follower, leader, None, self.hysteresis).turns

    def __call__(self, follower: Robots, leader: Leader, memory: Memory) -> tuple[Array, Memory]:
        """Returns the accelerations (u_x, u_theta), shape (..., 2), and the winding numbers."""
        xp = namespace(follower.g)
        relative = relative_motion(follower, leader, memory, self.hysteresis)
        theta, omega = relative.g[..., 2], relative.xi[..., 2]
        beta = side_angle(relative, self.dead_zone_length)
        attitude = adjoint_attitude(relative, self.dead_zone_speed)
        u_theta = -self.ke * (theta - attitude) - self.kp * (theta + self.k * beta) - self.kd * omega + leader.u[..., 2]
        feedforward = se2.Ad_inverse(relative.g, leader.u)[..., 0]
        u_x = -self.kp * relative.q[..., 0] - self.kd * relative.xi[..., 0] + feedforward
        if self.variant == "full":
            u_x = u_x + se2.ad(follower.xi, relative.xi)[..., 0]
        return xp.stack([u_x, u_theta], axis=-1), relative.turns
