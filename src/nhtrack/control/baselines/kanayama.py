"""The tracking law of Kanayama, Kimura, Miyazaki and Noguchi (1990)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from nhtrack.arrays import Array
from nhtrack.control.baselines.inner_loop import Velocities, inner_loop
from nhtrack.control.baselines.view import view
from nhtrack.control.law import Leader, Memory, Robots


@dataclass(frozen=True)
class Kanayama:
    """The law of Kanayama et al., "A stable tracking control method for an autonomous mobile robot", ICRA 1990.

        v_c = v_r cos e_theta + k_x e_x,   omega_c = omega_r + v_r (k_y e_y + k_theta sin e_theta)

    lifted to accelerations by `inner_loop`. Only sine and cosine of the heading enter: no memory.

    Assumes: velocities that the robot takes at once (here after the inner loop has settled); v_r > 0, slowly varying.
    Needs: a leader that moves forward; at rest e_y and e_theta are left as they are.
    Claims: local asymptotic stability, by `(e_x^2 + e_y^2)/2 + (1 - cos e_theta)/k_y`; e_theta = pi is an equilibrium
    too, unstable for v_r > 0. Critically damped on a line where k_theta^2 = 4 k_y.
    Checked: tests/property/test_baselines.py (`..._on_a_line_...`, `..._on_a_circle_...`).

    Attributes:
        k_x: gain on the distance ahead [1/s].
        k_y: gain on the distance aside [1/m^2].
        k_theta: gain on the heading [1/m].
        k_inner: gain of the inner loop [1/s].
    """

    dimensions: ClassVar[Mapping[str, tuple[int, int]]] = {
        "k_x": (0, -1), "k_y": (-2, 0), "k_theta": (-1, 0), "k_inner": (0, -1),
    }  # fmt: skip

    k_x: float
    k_y: float
    k_theta: float
    k_inner: float

    def init(self, follower: Robots, leader: Leader) -> Memory:
        """Returns nothing: the law has no memory."""
        return ()

    def __call__(self, follower: Robots, leader: Leader, memory: Memory) -> tuple[Array, Memory]:
        """Returns the accelerations (u_x, u_theta), shape (..., 2)."""
        return inner_loop(follower, self.velocities(follower, leader), self.k_inner), memory

    def velocities(self, follower: Robots, leader: Leader) -> Velocities:
        """Returns v_c, omega_c and their exact derivatives."""
        e = view(follower, leader)
        v_r, u_r = leader.xi[..., 0], leader.u[..., 0]
        steering = self.k_y * e.y + self.k_theta * e.sin
        steering_rate = self.k_y * e.y_rate + self.k_theta * e.cos * e.theta_rate
        return Velocities(
            v=v_r * e.cos + self.k_x * e.x,
            omega=leader.xi[..., 2] + v_r * steering,
            v_rate=u_r * e.cos - v_r * e.sin * e.theta_rate + self.k_x * e.x_rate,
            omega_rate=leader.u[..., 2] + u_r * steering + v_r * steering_rate,
        )

    def warnings(self) -> tuple[str, ...]:
        """Returns nothing: the source asks for positive gains only."""
        return ()
