"""From commanded velocities to commanded accelerations, the same for every law whose source stops at velocities."""

from __future__ import annotations

from typing import NamedTuple

from nhtrack.arrays import Array, namespace
from nhtrack.control.law import Robots


class Velocities(NamedTuple):
    """Velocities that a law commands, and their derivatives along the motion of follower and leader.

    Attributes:
        v: forward speed v_c [m/s], shape (...).
        omega: turning rate omega_c [rad/s].
        v_rate: v_c' [m/s^2].
        omega_rate: omega_c' [rad/s^2].
    """

    v: Array
    omega: Array
    v_rate: Array
    omega_rate: Array


def inner_loop(follower: Robots, commanded: Velocities, gain: float) -> Array:
    """Returns the accelerations (u_x, u_theta) that lead to commanded velocities, shape (..., 2).

        u_x = v_c' - K (v - v_c),   u_theta = omega_c' - K (omega - omega_c)

    (Fierro and Lewis 1997 with one gain). The derivatives are exact, since a law knows its leader's accelerations;
    so `v - v_c` and `omega - omega_c` decay as e^(-K t) from any start, whatever the law above does. Sampled with
    the period h they do so to first order in h; K h must stay well below 1.

    Args:
        follower: the follower.
        commanded: what its law asks for.
        gain: K [1/s], positive.
    """
    xp = namespace(follower.xi)
    u_x = commanded.v_rate - gain * (follower.xi[..., 0] - commanded.v)
    u_theta = commanded.omega_rate - gain * (follower.xi[..., 2] - commanded.omega)
    return xp.stack(xp.broadcast_arrays(u_x, u_theta), axis=-1)
