"""A point ahead of the axle (Siciliano et al. 2009, section 11.6), as arrays: kept as second implementation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from nhtrack.arrays import Array
from reference.laws.baselines.inner_loop import Velocities, inner_loop
from reference.laws.baselines.view import view
from reference.laws.law import Leader, Memory, Robots


@dataclass(frozen=True)
class LookAhead:
    """Tracking by the point a distance d ahead of the axle (Siciliano et al., "Robotics", 2009, section 11.6)."""

    dimensions: ClassVar[Mapping[str, tuple[int, int]]] = {"distance": (1, 0), "k": (0, -1), "k_inner": (0, -1)}

    distance: float
    k: float
    k_inner: float

    def init(self, follower: Robots, leader: Leader) -> Memory:
        """Returns nothing: the law has no memory."""
        return ()

    def __call__(self, follower: Robots, leader: Leader, memory: Memory) -> tuple[Array, Memory]:
        """Returns the accelerations (u_x, u_theta), shape (..., 2)."""
        return inner_loop(follower, self.velocities(follower, leader), self.k_inner), memory

    def velocities(self, follower: Robots, leader: Leader) -> Velocities:
        """Returns v_c, omega_c and their exact derivatives; vectors are in the follower's frame."""
        e, d = view(follower, leader), self.distance
        v, omega = follower.xi[..., 0], follower.xi[..., 2]
        v_r, omega_r = leader.xi[..., 0], leader.xi[..., 2]
        aside = leader.xi[..., 1] + d * omega_r
        z_r = e.turned(v_r, aside)
        z_r_rate = e.turned(leader.u[..., 0] - omega_r * aside, leader.u[..., 1] + d * leader.u[..., 2] + omega_r * v_r)
        w_x = z_r[0] + self.k * (e.x + d * e.cos - d)
        w_y = z_r[1] + self.k * (e.y + d * e.sin)
        w_x_rate = z_r_rate[0] + self.k * (z_r[0] - v)
        w_y_rate = z_r_rate[1] + self.k * (z_r[1] - d * omega)
        # The components of w change with the world's w and with the turning of the frame they are in.
        return Velocities(w_x, w_y / d, w_x_rate + omega * w_y, (w_y_rate - omega * w_x) / d)
