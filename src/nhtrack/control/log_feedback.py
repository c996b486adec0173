"""Fully actuated proportional-derivative feedback on SE(2), the paper's Lemma 6 (Bullo and Murray 1995, Theorem 6)."""

from __future__ import annotations

from nhtrack import se2
from nhtrack.arrays import Array


def log_feedback(g: Array, xi: Array, kp: float, kd: float) -> Array:
    """Returns u = -kp log(g) - kd xi, body accelerations (u_x, u_y, u_theta), shape (..., 3).

    Stabilises the identity from every pose with tr(g) != -1, that is |theta| < pi, for a body with all three inputs;
    no wheel robot is one. Tested on a fully actuated ideal body in tests/property/test_laws.py.

    Args:
        g: poses, |theta| < 2 pi, shape (..., 3).
        xi: body twists, shape (..., 3).
        kp: position gain [1/s^2], positive.
        kd: damping gain [1/s], positive.
    """
    return -kp * se2.log(g) - kd * xi
