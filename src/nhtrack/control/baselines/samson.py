"""The tracking law of Samson (1993) in the form of De Luca, Oriolo and Samson (1998)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from nhtrack.arrays import Array, namespace
from nhtrack.control.baselines.inner_loop import Velocities, inner_loop
from nhtrack.control.baselines.view import View, sinc, unturned, view
from nhtrack.control.law import Leader, Memory, Robots


@dataclass(frozen=True)
class Samson:
    """The law of De Luca, Oriolo and Samson, "Feedback control of a nonholonomic car-like robot", Springer 1998.

        k = 2 zeta sqrt(omega_r^2 + b v_r^2)
        v_c = v_r cos e_theta + k e_x,   omega_c = omega_r + k e_theta + b v_r sinc(e_theta) e_y

    lifted to accelerations by `inner_loop`; sinc(x) = sin(x)/x. The idea is C. Samson's (ICRA 1991, Int. J. Robotics
    Research 1993); robotics libraries know the law as Ramsete. e_theta enters itself, so whole turns are taken off it,
    counted in the memory with hysteresis. k has a corner where the leader stands still; there k' is the derivative to
    come, `2 zeta sqrt(u_theta_r^2 + b u_xr^2)`.

    Assumes: velocities that the robot takes at once (here after the inner loop has settled); v_r, omega_r bounded with
    bounded derivatives. Needs: v_r or omega_r that does not tend to zero. Claims: global asymptotic stability then,
    by `b (e_x^2 + e_y^2)/2 + e_theta^2/2`; all gains vanish with the leader's velocities.
    Checked: tests/property/test_baselines.py (`..._on_a_line_...`, `..._on_a_circle_...`).

    Attributes:
        zeta: damping ratio of the linearised error [1], in (0, 1).
        b: weight of place against heading [1/m^2].
        k_inner: gain of the inner loop [1/s].
        hysteresis: how far past pi e_theta goes before a whole turn is dropped [rad].
    """

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

    def warnings(self) -> tuple[str, ...]:
        """Returns what the gains break of the source's conditions."""
        if self.zeta < 1:
            return ()
        return (f"zeta = {self.zeta:g} is not below 1: its source designs for complex poles, 0 < zeta < 1",)
