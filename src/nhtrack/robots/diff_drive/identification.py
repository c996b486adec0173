"""Reading the reduced model of a robot from its compiled MJCF, so that no number is typed twice."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from nhtrack.errors import RobotError
from nhtrack.robots.diff_drive.losses import WheelLosses
from nhtrack.robots.diff_drive.model import DiffDrive
from nhtrack.robots.motor import Motor

# A cylinder or a capsule touches the floor in two points, and two points on a wheel resist turning.
_ONE_POINT_SHAPES = (mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_ELLIPSOID)
_PLACEMENT_TOLERANCE = 1e-6  # [m] how well an MJCF must place the axle midpoint
_LEVEL_TOLERANCE = 1e-4  # [m] how far from the floor a sphere may hang and still count as a caster


@dataclass(frozen=True)
class Parts:
    """Names of the parts of a differential-drive robot in its MJCF; pairs are (left, right)."""

    chassis: str
    wheel_joints: tuple[str, str]
    motors: tuple[str, str]
    tyres: tuple[str, str]
    casters: tuple[str, ...]
    collision_geoms: tuple[str, ...]


def identify_parts(model: mujoco.MjModel) -> Parts:
    """Returns the names of chassis, wheels, motors, tyres and casters of the one robot in a compiled model.

    The chassis is the body with a free joint; the driven wheels are the two hinges along y that torque motors act on;
    a tyre is a wheel's collision geom; casters are the other collision spheres that reach the floor.

    Raises:
        RobotError: what is missing, doubled, unnamed or of the wrong kind, and what was found instead.
    """
    data = _at_reference(model)
    chassis = _chassis(model)
    motors = _wheel_motors(model)
    joints = [int(model.actuator_trnid[a, 0]) for a in motors]
    across = [_in_chassis(data, chassis, data.xpos[model.jnt_bodyid[j]])[1] for j in joints]
    if across[0] < across[1]:
        motors, joints = motors[::-1], joints[::-1]
    tyres = [_tyre(model, joint) for joint in joints]
    in_tree = model.body_rootid == model.body_rootid[chassis]
    geoms = [g for g in range(model.ngeom) if in_tree[model.geom_bodyid[g]] and _collides(model, g)]
    floor = -float(model.geom_size[tyres[0], 0])
    casters = [g for g in geoms if g not in tyres and _reaches(model, data, chassis, g, floor)]
    if not casters:
        raise RobotError("no caster: expected a sphere among the chassis' collision geoms that touches the floor")
    obj = mujoco.mjtObj
    return Parts(
        chassis=_name(model, obj.mjOBJ_BODY, chassis),
        wheel_joints=(_name(model, obj.mjOBJ_JOINT, joints[0]), _name(model, obj.mjOBJ_JOINT, joints[1])),
        motors=(_name(model, obj.mjOBJ_ACTUATOR, motors[0]), _name(model, obj.mjOBJ_ACTUATOR, motors[1])),
        tyres=(_name(model, obj.mjOBJ_GEOM, tyres[0]), _name(model, obj.mjOBJ_GEOM, tyres[1])),
        casters=tuple(_name(model, obj.mjOBJ_GEOM, g) for g in casters),
        collision_geoms=tuple(_name(model, obj.mjOBJ_GEOM, g) for g in geoms),
    )


def identify(model: mujoco.MjModel, parts: Parts | None = None) -> DiffDrive:
    """Returns the reduced model of the one robot in a compiled model.

    Mass, first moment and inertias are read from MuJoCo's own mass matrix at the reference configuration.

    Args:
        model: the compiled model.
        parts: its robot's, where they are known already.

    Raises:
        RobotError: as `identify_parts`; or wheels that differ, a body origin that is not the axle midpoint, missing
            motor data.
    """
    parts = parts or identify_parts(model)
    data = _at_reference(model)
    chassis = model.body(parts.chassis).id
    radius, half_separation = _wheel_geometry(model, data, chassis, parts)
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    root = int(model.body_dofadr[chassis])
    wheels = [int(model.joint(name).dofadr[0]) for name in parts.wheel_joints]
    spin, rotor = ([float(values[d]) for d in wheels] for values in (M.diagonal(), model.dof_armature))
    if not (np.isclose(spin[0], spin[1], rtol=1e-9) and np.isclose(rotor[0], rotor[1], rtol=1e-9)):
        raise RobotError(f"the wheels' spin inertias differ: {spin[0]:.6g} and {spin[1]:.6g} kg m^2")
    com, motor = _in_chassis(data, chassis, data.subtree_com[chassis]), _motor(model, parts)
    points = [_in_chassis(data, chassis, data.geom(name).xpos) for name in parts.casters]
    return DiffDrive(
        wheel_radius=radius,
        half_separation=half_separation,
        mass=float(M[root, root]),
        axle_inertia=float(M[root + 5, root + 5]),
        wheel_inertia=spin[0],
        com=(float(com[0]), float(com[1]), float(com[2]) + radius),
        casters=tuple((float(point[0]), float(point[1])) for point in points),
        motor=motor,
        reflected_inertia=rotor[0],
        products=(_product(M, root, com, 0), _product(M, root, com, 1)),
        losses=_losses(model, parts, motor.torque_limit),
    )


def _losses(model: mujoco.MjModel, parts: Parts, torque: float) -> WheelLosses:
    """Returns the friction of the wheel joints, which is proportional to their speed or does not depend on it."""
    dofs = [int(model.joint(name).dofadr[0]) for name in parts.wheel_joints]
    for name, dof in zip(parts.wheel_joints, dofs, strict=True):
        if model.dof_dampingpoly[dof].any():
            given = " ".join(f"{value:g}" for value in (model.dof_damping[dof], *model.dof_dampingpoly[dof]))
            raise RobotError(f"joint {name!r}: expected one damping, proportional to the speed, got {given}")
        if (dry := model.dof_frictionloss[dof]) >= torque:
            reason = f"no less than the {torque:g} N m of its motor, which never turns it"
            raise RobotError(f"joint {name!r}: its frictionloss of {dry:g} N m is {reason}")
    (d_left, d_right), (c_left, c_right) = model.dof_damping[dofs].tolist(), model.dof_frictionloss[dofs].tolist()
    return WheelLosses((d_left, d_right), (c_left, c_right))


def _product(M: np.ndarray, root: int, com: np.ndarray, axis: int) -> float:
    """Returns the element (axis, z) of the inertia tensor about the CoM; M has it about the axle midpoint."""
    return float(M[root + 3 + axis, root + 5] + M[root, root] * com[axis] * com[2])


def _at_reference(model: mujoco.MjModel) -> mujoco.MjData:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return data


def _name(model: mujoco.MjModel, kind: mujoco.mjtObj, index: int) -> str:
    name = mujoco.mj_id2name(model, kind, index)
    if not name:
        raise RobotError(f"a {kind.name.removeprefix('mjOBJ_').lower()} the robot drives or stands on has no name")
    return str(name)


def _in_chassis(data: mujoco.MjData, chassis: int, point: np.ndarray) -> np.ndarray:
    return np.asarray(data.xmat[chassis].reshape(3, 3).T @ (point - data.xpos[chassis]))


def _collides(model: mujoco.MjModel, geom: int) -> bool:
    return bool(model.geom_contype[geom] or model.geom_conaffinity[geom])


def _chassis(model: mujoco.MjModel) -> int:
    free = [int(model.jnt_bodyid[j]) for j in range(model.njnt) if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_FREE]
    if len(free) != 1:
        raise RobotError(f"expected one body with a free joint, the chassis; found {len(free)}")
    return free[0]


def _is_wheel_motor(model: mujoco.MjModel, actuator: int) -> bool:
    """Whether an actuator is a torque motor on a hinge along y."""
    joint = int(model.actuator_trnid[actuator, 0])
    return bool(
        model.actuator_trntype[actuator] == mujoco.mjtTrn.mjTRN_JOINT
        and model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE
        and model.actuator_gaintype[actuator] == mujoco.mjtGain.mjGAIN_FIXED
        and model.actuator_biastype[actuator] == mujoco.mjtBias.mjBIAS_NONE
        and np.allclose(model.jnt_axis[joint], (0, 1, 0), atol=1e-9)
    )


def _wheel_motors(model: mujoco.MjModel) -> list[int]:
    found = [a for a in range(model.nu) if _is_wheel_motor(model, a)]
    if len(found) != 2:
        names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_ACTUATOR, a) or f"#{a}" for a in range(model.nu)]
        raise RobotError(
            "expected two driven wheels (torque motors on hinge joints with axis 0 1 0), "
            f"found {len(found)} among the actuators: {', '.join(names) if names else 'none'}"
        )
    return found


def _tyre(model: mujoco.MjModel, joint: int) -> int:
    """Returns the one geom with which the wheel on a joint touches the floor."""
    body = int(model.jnt_bodyid[joint])
    wheel = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, body) or f"body #{body}"
    geoms = [g for g in range(model.ngeom) if model.geom_bodyid[g] == body and _collides(model, g)]
    if len(geoms) != 1:
        raise RobotError(f"wheel {wheel!r}: expected one collision geom, found {len(geoms)}")
    shape = mujoco.mjtGeom(int(model.geom_type[geoms[0]]))
    if shape not in _ONE_POINT_SHAPES:
        raise RobotError(
            f"wheel {wheel!r}: its collision geom is a {shape.name.removeprefix('mjGEOM_').lower()}, which touches the "
            "floor in more than one point and so resists turning; use a sphere or an ellipsoid and draw the cylinder "
            "as a visual"
        )
    if model.geom_condim[geoms[0]] != 3:
        given = int(model.geom_condim[geoms[0]])
        raise RobotError(f"wheel {wheel!r}: expected condim 3 (sliding friction only), got {given}")
    return geoms[0]


def _reaches(model: mujoco.MjModel, data: mujoco.MjData, chassis: int, geom: int, floor: float) -> bool:
    """Whether a geom is a sphere whose lowest point is at the height `floor` of the chassis' frame."""
    if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_SPHERE:
        return False
    lowest = _in_chassis(data, chassis, data.geom_xpos[geom])[2] - model.geom_size[geom, 0]
    return bool(abs(lowest - floor) < _LEVEL_TOLERANCE)


def _wheel_geometry(model: mujoco.MjModel, data: mujoco.MjData, chassis: int, parts: Parts) -> tuple[float, float]:
    """Returns wheel radius and half separation [m]."""
    radii = [float(model.geom(name).size[0]) for name in parts.tyres]
    if abs(radii[0] - radii[1]) > _PLACEMENT_TOLERANCE:
        raise RobotError(f"the wheels' radii differ: {radii[0]:g} m and {radii[1]:g} m")
    bodies = [int(model.joint(name).bodyid[0]) for name in parts.wheel_joints]
    centres = np.array([_in_chassis(data, chassis, data.xpos[body]) for body in bodies])
    midpoint = centres.mean(axis=0)
    askew = np.abs(centres[:, (0, 2)]).max()
    if max(np.abs(midpoint).max(), askew) > _PLACEMENT_TOLERANCE:
        shown = ", ".join(f"{x:.4g}" for x in midpoint)
        raise RobotError(f"the chassis' origin must be the axle midpoint, with the axle along y; it is at ({shown}) m")
    return radii[0], float(centres[0, 1])


def _motor(model: mujoco.MjModel, parts: Parts) -> Motor:
    limits = []
    for name in parts.motors:
        actuator = model.actuator(name)
        if not actuator.ctrllimited[0]:
            raise RobotError(f"motor {name!r}: expected a ctrlrange, the torque its driver allows")
        limits.append(float(actuator.ctrlrange[1] * actuator.gear[0] * actuator.gainprm[0]))
    if not np.isclose(limits[0], limits[1]) or limits[0] <= 0:
        given = f"{limits[0]:g} and {limits[1]:g} N m"
        raise RobotError(f"the motors' torque limits must be equal and positive, got {given}")
    return Motor(limits[0], _numeric(model, "motor_stall_torque"), _numeric(model, "motor_no_load_speed"))


def _numeric(model: mujoco.MjModel, name: str) -> float:
    index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_NUMERIC, name)
    if index < 0:
        raise RobotError(f'expected <custom><numeric name="{name}" data="..."/></custom>, the motor\'s datasheet value')
    return float(model.numeric_data[model.numeric_adr[index]])
