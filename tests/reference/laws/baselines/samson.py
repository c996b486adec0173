"""Samson 1993, as De Luca, Oriolo and Samson 1998 have it, as arrays: kept as second implementation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from nhtrack.arrays import Array, namespace
from reference.laws.baselines.inner_loop import Velocities, inner_loop
from reference.laws.baselines.view import View, sinc, unturned, view
from reference.laws.law import Leader, Memory, Robots


@dataclass(frozen=True)
class Samson:
    """The law of De Luca, Oriolo and Samson, "Feedback control of a nonholonomic car-like robot", Springer 1998."""

    dimensions: ClassVar[Mapping[str, tuple[int, int]]] = {
        "zeta": (0, 0), "b": (-2, 0), "k_inner": (0, -1), "hysteresis": (0, 0),
    }  # fmt: skip

    zeta: float
    b: float
    k_inner: float
    hysteresis: float = 0.25

    def init(self, follower: Robots, leader: Leader) -> Memory:
        """Returns the winding numbers of e_theta; pi and -pi keep their signs."""
        return unturned(view(follower, leader), None, self.hysteresis)[1]

    def __call__(self, follower: Robots, leader: Leader, memory: Memory) -> tuple[Array, Memory]:
        """Returns the accelerations (u_x, u_theta), shape (..., 2), and the winding numbers."""
        e, turns = unturned(view(follower, leader), memory, self.hysteresis)
        return inner_loop(follower, self.velocities(e, leader), self.k_inner), turns

    def velocities(self, e: View, leader: Leader) -> Velocities:
        """Returns v_c, omega_c and their exact derivatives."""
        v_r, omega_r = leader.xi[..., 0], leader.xi[..., 2]
        u_r, alpha_r = leader.u[..., 0], leader.u[..., 2]
        k, k_rate = self._gain(v_r, omega_r, u_r, alpha_r)
        ratio, slope = sinc(e.theta)
        aside = ratio * e.y
        aside_rate = slope * e.theta_rate * e.y + ratio * e.y_rate
        return Velocities(
            v=v_r * e.cos + k * e.x,
            omega=omega_r + k * e.theta + self.b * v_r * aside,
            v_rate=u_r * e.cos - v_r * e.sin * e.theta_rate + k_rate * e.x + k * e.x_rate,
            omega_rate=alpha_r + k_rate * e.theta + k * e.theta_rate + self.b * (u_r * aside + v_r * aside_rate),
        )

    def _gain(self, v_r: Array, omega_r: Array, u_r: Array, alpha_r: Array) -> tuple[Array, Array]:
        """Returns k [1/s] and k' [1/s^2]."""
        xp = namespace(v_r)
        size = xp.sqrt(omega_r * omega_r + self.b * v_r * v_r)
        still = size == 0
        growth = (omega_r * alpha_r + self.b * v_r * u_r) / xp.where(still, xp.ones_like(size), size)
        starting = xp.sqrt(alpha_r * alpha_r + self.b * u_r * u_r)
        return 2 * self.zeta * size, 2 * self.zeta * xp.where(still, starting, growth)
