"""What the compiled control period knows of a scene beforehand, read from its reduced models and its compiled MJCF."""

from __future__ import annotations

from collections.abc import Iterable

import mujoco
import numpy as np

from nhtrack.ground import Ground
from nhtrack.simulation import memory
from nhtrack.simulation.contact import FrictionRow, tyre_compliance
from nhtrack.simulation.motion import Wheels
from nhtrack.simulation.plant import floor_of, plant_of
from nhtrack.simulation.scene import Scene
from nhtrack.simulation.spec import SceneSpec


def make_wheels(scene: Scene, spec: SceneSpec, dt: float) -> Wheels:
    """Returns what does not change while the robots of a scene drive; see `nhtrack.simulation.Wheels`."""
    drive, plant, step, at = scene.drive, scene.plant, spec.timestep, scene.addresses
    row = FrictionRow.of(scene.model, int(at.tyres[0, 0]))
    joints = [FrictionRow.of_joint(scene.model, int(dof)) for dof in at.wheel_qvel[0]]
    given_up = row.step * row.damping
    known = spec.ground if spec.compensation == "actual" else Ground()
    motor, felt = drive.motor, [drive.wheel_inertia + step * damping / 2 for damping in drive.losses.damping]
    return Wheels(
        dt=dt,
        h=step,
        substeps=round(dt / step),
        planar=plant.levelled,
        corrected=spec.rate_correction,
        told_of_slip=spec.contact == "stiff",
        compliance=tyre_compliance(scene),
        before_share=(1 - given_up) / given_up,
        after_share=-1 / given_up,
        force_share=-row.step * row.regularisation / given_up,
        straddling=0.5,
        lag=_pair(step * motor.slope / inertia for inertia in felt),
        mobility=_pair(step / inertia for inertia in felt),
        grip=_pair(1 / (joint.step * joint.regularisation) for joint in joints),
        kept=_pair(1 - joint.step * joint.damping for joint in joints),
        torque_map=np.ascontiguousarray(drive.torque_map),
        side_map=np.ascontiguousarray(drive.ground_map[:, 1]),
        torque_gain=np.ascontiguousarray(drive.torque_gain_over(step)),
        plant=plant_of(plant),
        floor=floor_of(spec.ground),
        known=floor_of(known),
        radius_factors=scene.radius_factors,
        flatness=scene.tyre_flatness,
        wheel_dofs=(int(at.wheel_qvel[0, 0] - at.root_qvel[0]), int(at.wheel_qvel[0, 1] - at.root_qvel[0])),
        motors=np.ascontiguousarray(at.motors, dtype=np.int64),
        tyres=np.ascontiguousarray(at.tyres, dtype=np.int64),
        roles=_roles(scene),
        owners=_owners(scene),
        first_body=spec.first_body,
        layout=memory.layout(),
    )


def _pair(values: Iterable[float]) -> tuple[float, float]:
    left, right = values
    return left, right


def _roles(scene: Scene) -> np.ndarray:
    """Returns what geoms are to the contact forces: 2 i + wheel for tyres, -2 for the floor, -1 for all others."""
    model = scene.model
    roles = np.full(model.ngeom, -1, dtype=np.int64)
    roles[(model.geom_bodyid == 0) & (model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE)] = -2
    roles[scene.addresses.tyres.ravel()] = np.arange(scene.addresses.tyres.size)
    return roles


def _owners(scene: Scene) -> np.ndarray:
    """Returns which robot each geom belongs to, -1 for none."""
    model = scene.model
    roots = model.jnt_bodyid[[model.joint(f"{name}/root/").id for name in scene.spec.bodies]]
    robots = np.full(model.nbody, -1, dtype=np.int64)
    robots[roots] = np.arange(len(roots))
    return np.ascontiguousarray(robots[model.body_rootid[model.geom_bodyid]])
