"""What MuJoCo's friction rows make of a velocity, what makes up for it at a tyre, and how tyres answer to forces."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from nhtrack.arrays import Array
from nhtrack.simulation.scene import Scene


@dataclass(frozen=True)
class FrictionRow:
    """One friction row of a tyre's contact, or of a joint's dry friction, below the limit of friction.

    A physics step h of a row with the damping b and the regularisation R that bears the force f turns the velocity
    `before` of the tyre along the row, in the configuration at the middle of the step, into

        after = (1 - h b) before - h b surface - h R f

    where `surface` is the tyre's surface velocity. MuJoCo leaves the rate of the contact frame out of its rows, so that
    a wheel that turns slides sideways at v omega / b; and a force makes it creep at R f / b.

    Attributes:
        step: h [s].
        damping: b = 2/(d timeconst) [1/s], from the geom's solref (timeconst) and the impedance d of its solimp.
        regularisation: R = (1 - d)/d A/impratio [1/kg], A the inverse inertia that MuJoCo takes for the tyre's body.
    """

    step: float
    damping: float
    regularisation: float

    @classmethod
    def of(cls, model: mujoco.MjModel, tyre: int) -> FrictionRow:
        """Returns the friction row of a geom on the floor."""
        step, impedance = float(model.opt.timestep), float(model.geom_solimp[tyre, 1])
        timeconst = max(float(model.geom_solref[tyre, 0]), 2 * step)
        inverse = float(model.body_invweight0[model.geom_bodyid[tyre], 0])
        return cls(step, 2 / (impedance * timeconst), (1 - impedance) / impedance * inverse / float(model.opt.impratio))

    @classmethod
    def of_joint(cls, model: mujoco.MjModel, dof: int) -> FrictionRow:
        """Returns the row of the dry friction of a hinge, in rad for m, N m for N and kg m^2 for kg."""
        step, (impedance, largest) = float(model.opt.timestep), model.dof_solimp[dof, :2].tolist()
        timeconst = max(float(model.dof_solref[dof, 0]), 2 * step)
        inverse = float(model.dof_invweight0[dof])
        return cls(step, 2 / (largest * timeconst), (1 - impedance) / impedance * inverse)

    def force(self, before: Array, after: Array) -> Array:
        """Returns the force [N] against which a step without surface velocity ends at the velocity `after` [m/s]."""
        return (after - (1 - self.step * self.damping) * before) / (self.step * self.regularisation)

    def surface_velocity(self, before: Array, after: Array, force: Array) -> Array:
        """Returns the surface velocity [m/s] with which a step under a force [N] ends at the velocity `after` [m/s]."""
        given_up = self.step * self.damping
        return ((1 - given_up) * before - after - self.step * self.regularisation * force) / given_up


def tyre_compliance(scene: Scene) -> Array:
    """Returns how the points where the tyres of one robot touch speed up under forces there [1/kg], shape (6, 6).

    Rows and columns are x, y, z of the left tyre, then of the right one, in the robot's frame where it stands; its
    casters keep to the floor. What regularised normal rows give way by is in z.
    """
    model, data, at = scene.model, mujoco.MjData(scene.model), scene.addresses
    robots = len(at.tyres)
    data.qpos = scene.qpos_of(np.zeros((robots, 3)), np.zeros((robots, 2)))
    mujoco.mj_fwdPosition(model, data)
    tyres = at.tyres[0].tolist()
    points = [(geom, data.geom_xpos[geom] - (0, 0, model.geom_size[geom, 0])) for geom in tyres]
    root = model.body_rootid[model.geom_bodyid[tyres[0]]]
    for contact in data.contact:
        floor, geom = contact.geom
        if model.geom_bodyid[floor] == 0 and geom not in tyres and model.body_rootid[model.geom_bodyid[geom]] == root:
            points.append((int(geom), contact.pos))
    rows = np.zeros((3 * len(points), model.nv))
    for place, (geom, point) in enumerate(points):
        mujoco.mj_jac(model, data, rows[3 * place : 3 * place + 3], None, point, model.geom_bodyid[geom])
    moved = np.zeros_like(rows)
    mujoco.mj_solveM(model, data, moved, rows)
    whole = rows @ moved.T
    for place, (geom, _) in enumerate(points):
        whole[3 * place + 2, 3 * place + 2] += FrictionRow.of(model, geom).regularisation
    own, held = slice(0, 6), slice(8, None, 3)
    by_casters = np.linalg.solve(whole[held, held], whole[held, own])
    return np.ascontiguousarray(whole[own, own] - whole[own, held] @ by_casters)
