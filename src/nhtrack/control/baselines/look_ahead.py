"""Static input-output linearisation of a point ahead of the axle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from nhtrack.arrays import Array
from nhtrack.control.baselines.inner_loop import Velocities, inner_loop
from nhtrack.control.baselines.view import view
from nhtrack.control.law import Leader, Memory, Robots


@dataclass(frozen=True)
class LookAhead:
    """Tracking by the point a distance d ahead of the axle (Siciliano et al., "Robotics", 2009, section 11.6).

        z = p + d (cos theta, sin theta),   z_r likewise of the leader,   w = z_r' + k (z_r - z)
        v_c = w_x,   omega_c = w_y/d,   w in the follower's frame

    lifted to accelerations by `inner_loop`. z can be moved in any direction, so z - z_r decays as e^(-k t) once the
    inner loop has settled. The leader may have lateral velocity. Only sine and cosine of the heading enter: no memory.

    Assumes: velocities that the robot takes at once (here after the inner loop has settled). Needs: nothing for the
    point; v_r > 0 for the heading, which z does not determine: on target `e_theta' = omega_r (1 - cos e_theta)
    - (v_r/d) sin e_theta`, so it aligns behind a leader that drives forward, turns away from one in reverse, and stays
    where it is with one at rest, which leaves the axle up to 2 d from its place.
    Claims: global exponential stability of z - z_r. Checked: tests/property/test_baselines.py (`test_look_ahead_...`).

    Attributes:
        distance: d [m].
        k: gain on the point [1/s].
        k_inner: gain of the inner loop [1/s].
    """

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

    def warnings(self) -> tuple[str, ...]:
        """Returns nothing: positive gains are all that is needed."""
        return ()
