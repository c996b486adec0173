"""Writes the MJCF of a whole scene, contact sensors included: what moves, not what it looks like."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nhtrack import assets
from nhtrack.mjcf import parse_mjcf, read_mjcf
from nhtrack.robots.contract import Parts

if TYPE_CHECKING:
    from nhtrack.robots.diff_drive import DiffDrive
    from nhtrack.simulation.spec import SceneSpec

# Impedance so close to one that penetration, and with it the change of the rolling radius, is a few nanometres.
_STIFF_SOLIMP = (0.9999, 0.9999, 0.001)
# A dense Jacobian is quicker for a handful of robots and ruinous for dozens (docs/fidelity.md).
_DENSE_ROBOTS = 4


def compose(spec: SceneSpec, mjcf: str, drive: DiffDrive, parts: Parts) -> Any:
    """Returns the MJCF element of a scene of robots in their standard form."""
    arena = read_mjcf(assets.models_directory() / "arena" / "scene.xml")
    arena.compiler.remove()  # how a robot's file is read is the robot's to say; the arena has no angles
    _set_options(arena, spec, any(drive.losses.damping))
    for name in spec.bodies:
        robot = parse_mjcf(mjcf)
        robot.model = name
        _set_contacts(robot, spec, parts)
        _set_motors(robot, drive, parts)
        _set_losses(robot, spec, drive, parts)
        for effect in spec.effects:
            effect.edit_robot(robot, parts, drive)
        frame = _attach(arena, robot, drive, parts)
        for effect in spec.effects:
            effect.edit_frame(frame)
    if spec.virtual_root:
        arena.worldbody.add("body", name=spec.robots[0], mocap=True)
    return arena


def _set_options(arena: Any, spec: SceneSpec, damped: bool) -> None:
    option = arena.option
    option.timestep = spec.timestep
    option.gravity = spec.ground.gravity  # the plane stays level in its own frame; on a slope gravity leans
    option.integrator = "Euler" if damped else "implicitfast"
    if damped:
        option.flag.eulerdamp = "disable"  # damping is split between the armature and an explicit force
    option.cone = "elliptic"  # the pyramid loses 29 % of the friction limit at 45 degrees
    option.solver = "Newton"
    option.impratio = 1  # more would shrink the creep of friction, which the rate correction makes up for anyway, and
    # sharpen the cones: at 10 the solver now and then ends a step beside the solution
    option.tolerance = 1e-15  # at 1e-12 a step near the limit of friction now and then ends beside the solution
    option.iterations = 100
    option.ls_iterations = 200  # with the 50 of the default a line search in a sliding contact may not end
    option.jacobian = "dense" if len(spec.bodies) <= _DENSE_ROBOTS else "sparse"
    option.flag.autoreset = "disable"  # a diverged state is an error to report, not one to hide by a reset


def _set_contacts(robot: Any, spec: SceneSpec, parts: Parts) -> None:
    """Writes contact parameters and collision masks into one robot's MJCF."""
    for name in parts.collision_geoms:
        geom = robot.find("geom", name)
        # The floor's type is 1: robots see it by their affinity 1, and each other only by type and affinity 2.
        geom.contype, geom.conaffinity = (2, 3) if spec.robot_contact else (0, 1)
        if spec.contact == "stiff" and name in (*parts.tyres, *parts.casters):
            geom.solref, geom.solimp = (2 * spec.timestep, 1), _STIFF_SOLIMP
    for name in parts.tyres:
        geom = robot.find("geom", name)
        geom.friction, geom.condim, geom.priority = (spec.friction, 0.005, 0.0001), 3, 1
        robot.sensor.add("contact", name=name, geom1=geom, data="force", reduce="netforce", num=1)
    for name in parts.casters:
        geom = robot.find("geom", name)
        geom.condim, geom.priority = 1, 1


def _set_motors(robot: Any, drive: DiffDrive, parts: Parts) -> None:
    """Makes motors take torques at the wheel, up to their limit."""
    for name in parts.motors:
        motor = robot.find("actuator", name)
        motor.gear, motor.ctrlrange = (1,), (-drive.motor.torque_limit, drive.motor.torque_limit)
        motor.ctrllimited = "true"
        if motor.tag == "general":
            motor.gainprm = (1,)


def _set_losses(robot: Any, spec: SceneSpec, drive: DiffDrive, parts: Parts) -> None:
    """Makes damping act by the mean of the speeds before and after a step, and dry friction as stiff as contacts."""
    losses = drive.losses
    for name, damping, dry in zip(parts.wheel_joints, losses.damping, losses.dry_friction, strict=True):
        joint = robot.find("joint", name)
        if damping > 0:
            joint.armature = drive.reflected_inertia + damping * spec.timestep / 2
        if dry > 0 and spec.contact == "stiff":
            joint.solreffriction, joint.solimpfriction = (2 * spec.timestep, 1), _STIFF_SOLIMP


def _attach(arena: Any, robot: Any, drive: DiffDrive, parts: Parts) -> Any:
    """Returns the frame by which one robot, free to move, hangs in the arena, at its axle midpoint."""
    for settings in (robot.option, robot.size, robot.statistic, robot.visual):
        settings.remove()  # the scene decides these; where both speak, dm_control would merge or refuse
    chassis = robot.find("body", parts.chassis)
    for joint in chassis.get_children("freejoint"), *chassis.get_children("joint"):
        if joint is not None and (joint.tag == "freejoint" or joint.type == "free"):
            joint.remove()
    chassis.pos, chassis.quat = (0, 0, 0), (1, 0, 0, 0)
    frame = arena.worldbody.attach(robot)
    frame.pos = (0, 0, drive.wheel_radius)
    frame.add("freejoint", name="root")
    return frame
