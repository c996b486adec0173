"""From commanded velocities to commanded accelerations, the same for every law whose source stops at velocities."""

from __future__ import annotations

from typing import NamedTuple

from nhtrack.compiled import compiled
from nhtrack.laws.contract import Follower


class Velocities(NamedTuple):
    """Velocities that a law commands, and their derivatives along the motion of follower and leader.

    Attributes:
        v: forward speed v_c [m/s].
        omega: turning rate omega_c [rad/s].
        v_rate: v_c' [m/s^2].
        omega_rate: omega_c' [rad/s^2].
    """

    v: float
    omega: float
    v_rate: float
    omega_rate: float


@compiled
def inner_loop(follower: Follower, commanded: Velocities, gain: float) -> tuple[float, float]:
    """Returns the accelerations (u_x, u_theta) that lead to commanded velocities.

        u_x = v_c' - K (v - v_c),   u_theta = omega_c' - K (omega - omega_c)

    (Fierro and Lewis 1997 with one gain). The derivatives are exact, since a law knows its leader's accelerations;
    so `v - v_c` and `omega - omega_c` decay as e^(-K t) from any start, whatever the law above does. Sampled with
    the period h they do so to first order in h; K h must stay well below 1.

    Args:
        follower: the follower.
        commanded: what its law asks for.
        gain: K [1/s], positive.
    """
    u_x = commanded.v_rate - gain * (follower.v_x - commanded.v)
    u_theta = commanded.omega_rate - gain * (follower.omega - commanded.omega)
    return u_x, u_theta
