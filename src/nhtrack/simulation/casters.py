"""Casters that swivel: the velocities of their joints while their wheels roll where the robot pulls them."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from nhtrack.arrays import Array


def caster_rates(
    model: mujoco.MjModel, data: mujoco.MjData, joints: Sequence[int], wheels: Sequence[int], pull: Array
) -> Array:
    """Returns the velocities of casters' joints at which the points where their wheels touch the floor stand still.

    With J the Jacobian of those points, J[:, joints] rates = -J pull; the smallest rates where these leave a choice.

    Args:
        model: the compiled scene.
        data: its state, positions worked out.
        joints: velocities of all joints of the casters.
        wheels: geoms of the casters' wheels.
        pull: velocities of the scene without those of the casters, a column for each motion, shape (nv, k).

    Returns:
        Rates, shape (joints, k).
    """
    rows, rest = list[Array](), list[Array]()
    for wheel in wheels:
        jacobian, (x, y, _) = np.zeros((3, model.nv)), data.geom_xpos[wheel]
        mujoco.mj_jac(model, data, jacobian, None, np.array([x, y, 0.0]), model.geom_bodyid[wheel])
        rows.append(jacobian[:2, list(joints)])
        rest.append(jacobian[:2] @ pull)
    if not rows:
        return np.zeros((len(joints), pull.shape[1]))
    return np.asarray(-np.linalg.pinv(np.concatenate(rows)) @ np.concatenate(rest))
