"""Dynamic feedback linearisation of the unicycle (Oriolo, De Luca and Vendittelli 2002)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import sqrt
from typing import ClassVar

from nhtrack.arrays import Array, namespace
from nhtrack.control.baselines.inner_loop import Velocities, inner_loop
from nhtrack.control.baselines.view import View, view
from nhtrack.control.law import Leader, Memory, Robots


@dataclass(frozen=True)
class FeedbackLinearisation:
    """The law of Oriolo, De Luca and Vendittelli, IEEE Trans. Control Systems Technology 10, 2002.

        w = p_r'' + kd (p_r' - p') + kp (p_r - p)
        xi' = w_x,   omega_c = w_y/xi,   w in the follower's frame

    The source integrates xi and commands it as speed. Here speed is an integrator already, so xi is the follower's own
    speed v, u_x = w_x, and there is no memory; omega_c is lifted by `inner_loop`. Its derivative takes the leader's
    jerk, of which u_r' is not known and counts as zero, as it is while an input is held. So `e'' + kd e' + kp e = 0`
    for e = p_r - p once the inner loop has settled.

    At xi = 0 the law is singular. |xi| is therefore never taken smaller than `v_min`, with the sign of the leader's
    speed, or of v where the leader is slower than `v_min` itself. As if the source's integrator were reset, a follower
    whose speed is not on that side of v_min is led there by the inner loop while the leader moves, and a w_x that would
    slow it down further is left out. With the leader at rest it is not, so that it can stop. A small v_min asks for
    turning rates w_y/v_min that a control period cannot follow; too small a one and the follower runs away.

    Assumes: p_r'' as commanded. Needs: |v_r| above v_min. Claims: exponential tracking of p_r while |v| > v_min; the
    heading follows from the direction of p', so at a leader at rest it is left over.
    Checked: tests/property/test_baselines.py (`test_feedback_linearisation_...`).

    Attributes:
        kp: position gain [1/s^2].
        kd: damping gain [1/s].
        k_inner: gain of the inner loop on the turning rate [1/s].
        v_min: smallest |xi| [m/s].
    """

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

    def warnings(self) -> tuple[str, ...]:
        """Returns what the gains break of the source's conditions."""
        critical = 2 * sqrt(self.kp)
        if self.kd >= critical:
            return ()
        return (f"kd = {self.kd:g} is below 2 sqrt(kp) = {critical:g}: errors overshoot, and v passes the singularity",)


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
