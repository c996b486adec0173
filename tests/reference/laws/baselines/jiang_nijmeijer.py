"""Jiang and Nijmeijer 1997, as arrays: kept as second implementation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from nhtrack.arrays import Array
from reference.laws.baselines.inner_loop import Velocities, inner_loop
from reference.laws.baselines.view import View, sinc, unturned, view
from reference.laws.law import Leader, Memory, Robots


@dataclass(frozen=True)
class JiangNijmeijer:
    """The law of Jiang and Nijmeijer for their dynamic model."""

    dimensions: ClassVar[Mapping[str, tuple[int, int]]] = {
        "k_x": (0, -1), "gamma": (-2, 0), "k_theta": (0, -1), "k_inner": (0, -1), "coupling": (0, -2),
        "hysteresis": (0, 0),
    }  # fmt: skip

    k_x: float
    gamma: float
    k_theta: float
    k_inner: float
    coupling: float
    hysteresis: float = 0.25

    def init(self, follower: Robots, leader: Leader) -> Memory:
        """Returns the winding numbers of e_theta; pi and -pi keep their signs."""
        return unturned(view(follower, leader), None, self.hysteresis)[1]

    def __call__(self, follower: Robots, leader: Leader, memory: Memory) -> tuple[Array, Memory]:
        """Returns the accelerations (u_x, u_theta), shape (..., 2), and the winding numbers."""
        e, turns = unturned(view(follower, leader), memory, self.hysteresis)
        commanded = self.velocities(e, leader)
        coupled = commanded._replace(
            v_rate=commanded.v_rate + self.coupling * e.x, omega_rate=commanded.omega_rate + self.coupling * e.theta
        )
        return inner_loop(follower, coupled, self.k_inner), turns

    def velocities(self, e: View, leader: Leader) -> Velocities:
        """Returns v_c, omega_c and their exact derivatives."""
        v_r, u_r = leader.xi[..., 0], leader.u[..., 0]
        ratio, slope = sinc(e.theta)
        aside = ratio * e.y
        aside_rate = slope * e.theta_rate * e.y + ratio * e.y_rate
        return Velocities(
            v=v_r * e.cos + self.k_x * e.x,
            omega=leader.xi[..., 2] + self.k_theta * e.theta + self.gamma * v_r * aside,
            v_rate=u_r * e.cos - v_r * e.sin * e.theta_rate + self.k_x * e.x_rate,
            omega_rate=leader.u[..., 2]
            + self.k_theta * e.theta_rate
            + self.gamma * (u_r * aside + v_r * aside_rate),
        )
