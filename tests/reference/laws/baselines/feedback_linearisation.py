"""Oriolo, De Luca and Vendittelli 2002, as arrays: kept as second implementation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from nhtrack.arrays import Array, namespace
from reference.laws.baselines.inner_loop import Velocities, inner_loop
from reference.laws.baselines.view import View, view
from reference.laws.law import Leader, Memory, Robots


@dataclass(frozen=True)
class FeedbackLinearisation:
    """The law of Oriolo, De Luca and Vendittelli, IEEE Trans. Control Systems Technology 10, 2002."""

    dimensions: ClassVar[Mapping[str, tuple[int, int]]] = {
        "kp": (0, -2), "kd": (0, -1), "k_inner": (0, -1), "v_min": (1, -1),
    }  # fmt: skip

    kp: float
    kd: float
    k_inner: float
    v_min: float

    def init(self, follower: Robots, leader: Leader) -> Memory:
        """Returns nothing: the source's integrator is the follower's own speed."""
        return ()

    def __call__(self, follower: Robots, leader: Leader, memory: Memory) -> tuple[Array, Memory]:
        """Returns the accelerations (u_x, u_theta), shape (..., 2)."""
        return inner_loop(follower, self.velocities(follower, leader), self.k_inner), memory

    def velocities(self, follower: Robots, leader: Leader) -> Velocities:
        """Returns xi, omega_c and their derivatives; vectors are in the follower's frame."""
        xp, e = namespace(follower.xi), view(follower, leader)
        v, omega = follower.xi[..., 0], follower.xi[..., 2]
        velocity = e.turned(leader.xi[..., 0], leader.xi[..., 1])
        closing = velocity[0] - v, velocity[1]
        acceleration, jerk = _leader_derivatives(e, leader)
        w_x = acceleration[0] + self.kd * closing[0] + self.kp * e.x
        w_y = acceleration[1] + self.kd * closing[1] + self.kp * e.y
        w_y_rate = jerk[1] + self.kd * (acceleration[1] - v * omega) + self.kp * closing[1] - omega * w_x

        moving, sign = self._direction(v, leader.xi[..., 0])
        regular = sign * v >= self.v_min
        xi = xp.where(regular, v, sign * self.v_min)
        held = moving & ~regular
        speeding = xp.where(sign * w_x > 0, w_x, xp.zeros_like(w_x))
        omega_c = w_y / xi
        xi_rate = xp.where(regular, w_x, xp.zeros_like(w_x))
        return Velocities(
            v=xp.where(held, xi, v),
            omega=omega_c,
            v_rate=xp.where(held, speeding, w_x),
            omega_rate=(w_y_rate - omega_c * xi_rate) / xi,
        )

    def _direction(self, v: Array, v_r: Array) -> tuple[Array, Array]:
        """Returns whether the leader moves, and the sign of xi: of v_r, or with the leader at rest of v."""
        xp = namespace(v, v_r)
        moving = xp.abs(v_r) > self.v_min
        one = xp.ones_like(v)
        return moving, xp.where(xp.where(moving, v_r, v) < 0, -one, one)

def _leader_derivatives(e: View, leader: Leader) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Returns p_r'' and p_r''' in the follower's frame, the latter for u_r' = 0."""
    (v, aside, omega), (u_x, u_y, u_theta) = (
        (values[..., 0], values[..., 1], values[..., 2]) for values in (leader.xi, leader.u)
    )
    acceleration = u_x - omega * aside, u_y + omega * v
    jerk = (
        -u_theta * aside - omega * u_y - omega * acceleration[1],
        u_theta * v + omega * u_x + omega * acceleration[0],
    )
    return e.turned(*acceleration), e.turned(*jerk)
