"""Reading the reduced model of a robot from its compiled standard form, so that no number is typed twice."""

from __future__ import annotations

import mujoco
import numpy as np

from nhtrack.robots.contract import Parts
from nhtrack.robots.diff_drive.losses import WheelLosses
from nhtrack.robots.diff_drive.model import DiffDrive
from nhtrack.robots.motor import Motor


def identify(model: mujoco.MjModel, parts: Parts, motor: Motor) -> DiffDrive:
    """Returns the reduced model of the one robot in a compiled model.

    Mass, first moment and inertias are read from MuJoCo's own mass matrix at the reference configuration.

    Args:
        model: the compiled standard form.
        parts: names in it.
        motor: limits of its motors.
    """
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    chassis = model.body(parts.chassis).id
    tyres = [model.geom(name) for name in parts.tyres]
    radius = float(tyres[0].size[0])
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    root = int(model.body_dofadr[chassis])
    wheels = [int(model.joint(name).dofadr[0]) for name in parts.wheel_joints]
    spin, rotor = (float(np.mean(values[wheels])) for values in (M.diagonal(), model.dof_armature))
    com = data.subtree_com[chassis] - data.xpos[chassis]
    places = [data.geom(name).xpos - data.xpos[chassis] for name in parts.casters]
    return DiffDrive(
        wheel_radius=radius,
        half_separation=float(data.geom(parts.tyres[0]).xpos[1] - data.geom(parts.tyres[1]).xpos[1]) / 2,
        mass=float(M[root, root]),
        axle_inertia=float(M[root + 5, root + 5]),
        wheel_inertia=spin,
        com=(float(com[0]), float(com[1]), float(com[2]) + radius),
        casters=tuple((float(place[0]), float(place[1])) for place in places),
        motor=motor,
        reflected_inertia=rotor,
        products=(_product(M, root, com, 0), _product(M, root, com, 1)),
        compliances=tuple(_compliance(model, name) for name in (*parts.tyres, *parts.casters)),
        losses=WheelLosses(_pair(model.dof_damping[wheels]), _pair(model.dof_frictionloss[wheels])),
    )


def _pair(values: np.ndarray) -> tuple[float, float]:
    return float(values[0]), float(values[1])


def _product(M: np.ndarray, root: int, com: np.ndarray, axis: int) -> float:
    """Returns the element (axis, z) of the inertia tensor about the CoM; M has it about the axle midpoint."""
    return float(M[root + 3 + axis, root + 5] + M[root, root] * com[axis] * com[2])


def _compliance(model: mujoco.MjModel, geom: str) -> float:
    """Returns by how much MuJoCo's contact of a geom gives way, but for a factor that all of a scene's share."""
    return float(model.body_invweight0[model.geom(geom).bodyid[0], 0])
