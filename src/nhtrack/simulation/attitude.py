"""Heading and tilt of a robot, out of MuJoCo's coordinates of its base."""

from __future__ import annotations

import math

import numpy as np

from nhtrack.compiled import compiled_inside


@compiled_inside
def heading_of(planar: bool, qpos: np.ndarray) -> float:
    """Returns the heading of a robot, on a free base the swing-twist rotation about the vertical [rad]."""
    return qpos[3] if planar else 2 * math.atan2(qpos[6], qpos[3])


@compiled_inside
def tilt_of(planar: bool, qpos: np.ndarray) -> float:
    """Returns the angle between a robot's vertical axis and the floor's normal [rad]."""
    return 0.0 if planar else 2 * math.asin(min(math.hypot(qpos[4], qpos[5]), 1.0))
