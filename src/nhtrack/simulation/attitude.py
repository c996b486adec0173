"""Heading and tilt of a robot and the height of its wheels, out of MuJoCo's coordinates of its base."""

from __future__ import annotations

import math

import numpy as np

from nhtrack.compiled import compiled_inside
from nhtrack.simulation.motion import Wheels


@compiled_inside
def heading_of(planar: bool, qpos: np.ndarray) -> float:
    """Returns the heading of a robot, on a free base the swing-twist rotation about the vertical [rad]."""
    return qpos[3] if planar else 2 * math.atan2(qpos[6], qpos[3])


@compiled_inside
def clearances_of(wheels: Wheels, qpos: np.ndarray) -> tuple[float, float]:
    """Returns how high above the floor the lowest points of the tyres (left, right) are [m]; 0 on a planar base.

    A tyre is an ellipsoid of radius r and half width k r: with its axle at the angle phi to the floor, its lowest point
    is r sqrt(1 - (1 - k^2) sin^2 phi) below its centre.
    """
    if wheels.planar:
        return 0.0, 0.0
    sine = 2 * (qpos[5] * qpos[6] + qpos[3] * qpos[4])
    across = wheels.plant.half_separation * sine
    radius = wheels.plant.radius * math.sqrt(max(1 - wheels.flatness * sine * sine, 0.0))
    left, right = wheels.radius_factors
    return qpos[2] + across - left * radius, qpos[2] - across - right * radius


@compiled_inside
def tilt_of(planar: bool, qpos: np.ndarray) -> float:
    """Returns the angle between a robot's vertical axis and the floor's normal [rad]."""
    return 0.0 if planar else 2 * math.asin(min(math.hypot(qpos[4], qpos[5]), 1.0))
