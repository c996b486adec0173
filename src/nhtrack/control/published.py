"""The paper's single-follower tracking law (Theorem 1)."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import Literal

from nhtrack import se2
from nhtrack.arrays import Array, namespace
from nhtrack.control.law import Leader, Memory, Robots
from nhtrack.control.relative import adjoint_attitude, relative_motion, side_angle


@dataclass(frozen=True)
class Published:
    """The tracking law of Theorem 1, paper eq. 26.

        u_theta1 = -ke (theta01 - theta~01) - kp (theta01 + k beta) - kd omega01 + u_theta0
        u_x1     = -kp q_x - kd v_x01 + (u_x0 - u_theta0 r_y) cos theta01 + u_theta0 r_x sin theta01

    with (r_x, r_y, theta01) the follower seen from the leader, q its exponential coordinates, beta = -arctan(q_y/q_x)
    and theta~01 the adjoint attitude. `variant="full"` adds to u_x1 the x component of the bracket [xi_1, xi_01],
    `-omega_1 v_y01`, which the paper's own general form has (eq. 25) and its printed law drops.

    Assumes: states measured without error; leader without lateral velocity (another leader's is taken in by the adjoint
    attitude and the relative velocity). Claims, as printed: global asymptotic tracking of any reference. What holds:
    with the leader at rest, alignment from almost every start where k > 2 (1 + ke/kp) and kd >= 2 sqrt(kp); with a
    moving leader a limit cycle around it remains (tests/property/test_laws.py; docs/theory.md).

    Attributes:
        kp: position gain [1/s^2].
        kd: damping gain [1/s].
        ke: gain on the adjoint attitude [1/s^2].
        k: steering gain on beta [1].
        variant: `published` as printed, `full` with the bracket.
        hysteresis: how far past the antipode the branch of log is kept [rad].
        dead_zone_length: |q| below which beta is taken as 0 [m].
        dead_zone_speed: leader speed below which theta~01 is taken as 0 [m/s].
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

    def warnings(self) -> tuple[str, ...]:
        """Returns what the gains break, with the formula; empty where a resting leader's heading is reached."""
        return gain_warnings(self.kp, self.kd, self.ke, self.k)


def gain_warnings(kp: float, kd: float, ke: float, k: float) -> tuple[str, ...]:
    """Returns a sentence for each condition that the gains break.

    For a resting leader the heading follows m = 2 k_eff/(2 + k_eff) times the polar angle of the position, with
    k_eff = k kp/(kp + ke); the angle shrinks only if m > 1, that is k > 2 (1 + ke/kp). kd >= 2 sqrt(kp) keeps q_x from
    changing sign, where beta jumps by pi.
    """
    found = []
    bound = 2 * (1 + ke / kp)
    if k <= bound:
        found.append(
            f"k = {k:g} is not above 2 (1 + ke/kp) = {bound:g}: with the leader at rest the heading will not align"
        )
    critical = 2 * sqrt(kp)
    if kd < critical:
        found.append(f"kd = {kd:g} is below 2 sqrt(kp) = {critical:g}: q_x overshoots and beta jumps by pi each time")
    return tuple(found)
