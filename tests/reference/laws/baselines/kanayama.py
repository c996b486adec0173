"""Kanayama, Kimura, Miyazaki and Noguchi 1990, as arrays: kept as second implementation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from nhtrack.arrays import Array
from reference.laws.baselines.inner_loop import Velocities, inner_loop
from reference.laws.baselines.view import view
from reference.laws.law import Leader, Memory, Robots


@dataclass(frozen=True)
class Kanayama:
    """The law of Kanayama et al., "A stable tracking control method for an autonomous mobile robot", ICRA 1990."""

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
