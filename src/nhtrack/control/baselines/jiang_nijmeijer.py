"""The tracking law of Jiang and Nijmeijer (1997), by backstepping through the velocities."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from nhtrack.arrays import Array
from nhtrack.control.baselines.inner_loop import Velocities, inner_loop
from nhtrack.control.baselines.view import View, sinc, unturned, view
from nhtrack.control.law import Leader, Memory, Robots


@dataclass(frozen=True)
class JiangNijmeijer:
    """The law of Jiang and Nijmeijer for their dynamic model.

    "Tracking control of mobile robots: a case study in backstepping", Automatica 33 (1997) 1393-1399:

        v_c = v_r cos e_theta + k_x e_x,   omega_c = omega_r + k_theta e_theta + gamma v_r sinc(e_theta) e_y
        u_x = v_c' - K (v - v_c) + a e_x,   u_theta = omega_c' - K (omega - omega_c) + a e_theta

    with sinc(x) = sin(x)/x. The storage function

        V = (e_x^2 + e_y^2)/2 + e_theta^2/(2 gamma) + ((v - v_c)^2 + (omega - omega_c)^2/gamma)/(2 a)

    obeys `V' = -k_x e_x^2 - k_theta e_theta^2/gamma - K ((v - v_c)^2 + (omega - omega_c)^2/gamma)/a`. The source has no
    a, which would add metres to metres per second, and 1/gamma in its place before e_theta; with gamma = 1/m^2 and
    a = 1/s^2 the two are one. Whole turns are taken off e_theta, counted in the memory with hysteresis, which can only
    lower V.

    Assumes: v_r, omega_r and their derivatives bounded. Needs: v_r or omega_r that does not tend to zero. Claims:
    global asymptotic tracking then. With the leader at rest e_x and e_theta vanish and e_y stays.
    Checked: tests/property/test_baselines.py (`test_jiang_nijmeijer_...`).

    Attributes:
        k_x: gain on the distance ahead [1/s].
        gamma: weight of place against heading [1/m^2].
        k_theta: gain on the heading [1/s].
        k_inner: K, gain on the velocities [1/s].
        coupling: a, what the errors add to the accelerations [1/s^2].
        hysteresis: how far past pi e_theta goes before a whole turn is dropped [rad].
    """

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

    def warnings(self) -> tuple[str, ...]:
        """Returns nothing: the source asks for positive gains only."""
        return ()
