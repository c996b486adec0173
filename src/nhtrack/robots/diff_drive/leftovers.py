"""What of a robot's file the reduced model does not know of, and what of it is left out."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import mujoco
import numpy as np

from nhtrack.arrays import Array
from nhtrack.robots.contract import Refusal
from nhtrack.robots.diff_drive.roles import Roles
from nhtrack.robots.reading.source import Source

__all__ = ["leftovers", "unknown_to_model"]

_EQ, _WRAP = mujoco.mjtEq, mujoco.mjtWrap
_OFF_AXIS = 1e-3  # mass of a wheel times its distance from the axis, over the robot's mass times the wheel's radius
_UNROUND = 2e-2  # how far a wheel's inertia may be from one of revolution, over the robot's mass times radius squared


def unknown_to_model(source: Source, roles: Roles) -> Iterator[Refusal]:
    """Yields what acts on wheels or weight and is neither modelled nor held."""
    model = source.model
    for joint in roles.wheels:
        name, dof = source.element("joint", joint), int(model.jnt_dofadr[joint])
        if model.jnt_limited[joint]:
            low, high = model.jnt_range[joint]
            yield Refusal(name, f"its range {low:.4g} {high:.4g} rad stops the wheel: remove it (limited='false')")
        if model.jnt_stiffness[joint] or model.jnt_stiffnesspoly[joint].any():
            yield Refusal(name, "a spring holds the wheel: remove its stiffness")
        if model.dof_dampingpoly[dof].any():
            yield Refusal(name, "its damping is no constant: give it one number")
        yield from _unbalanced(source, roles, joint)
    yield from _coupled(source, roles)
    yield from _floating(source, roles)


def _coupled(source: Source, roles: Roles) -> Iterator[Refusal]:
    """Yields what ties driven wheels or casters to anything else."""
    model, moving = source.model, {*roles.wheels, *roles.swivels}
    bodies = {body for body in source.subtree(roles.root) if roles.link_of(source, body) in moving}
    inside = set(source.subtree(roles.root))
    for e in range(model.neq):
        one, two = int(model.eq_obj1id[e]), int(model.eq_obj2id[e])
        if not model.eq_active0[e]:
            continue
        if model.eq_type[e] == _EQ.mjEQ_JOINT and {one, two} & moving:
            yield Refusal(source.element("equality", e), "it couples a wheel to another joint: remove it")
        elif (
            _EQ(int(model.eq_type[e])) in (_EQ.mjEQ_CONNECT, _EQ.mjEQ_WELD)
            and model.eq_objtype[e] == mujoco.mjtObj.mjOBJ_BODY
        ):
            if {one, two} & bodies:
                yield Refusal(source.element("equality", e), "it ties a wheel to another body: remove it")
            elif len({one, two} & inside) == 1:
                yield Refusal(source.element("equality", e), "it ties the robot to something outside it: remove it")
    for t in range(model.ntendon):
        acts = model.tendon_stiffness[t], model.tendon_damping[t], model.tendon_frictionloss[t]
        if not (any(np.any(each) for each in acts) or model.tendon_limited[t]):
            continue
        met = set(_met(source, t))
        if met & bodies:
            yield Refusal(source.element("tendon", t), "it springs, brakes or stops a wheel: remove that")
        elif met & inside and met - inside:
            yield Refusal(source.element("tendon", t), "it ties the robot to something outside it: remove it")


def _met(source: Source, tendon: int) -> Iterator[int]:
    """Yields the bodies that a tendon acts on."""
    model = source.model
    first, count = int(model.tendon_adr[tendon]), int(model.tendon_num[tendon])
    for w in range(first, first + count):
        kind, at = _WRAP(int(model.wrap_type[w])), int(model.wrap_objid[w])
        if kind == _WRAP.mjWRAP_JOINT:
            yield int(model.jnt_bodyid[at])
        elif kind == _WRAP.mjWRAP_SITE:
            yield int(model.site_bodyid[at])
        elif kind in (_WRAP.mjWRAP_SPHERE, _WRAP.mjWRAP_CYLINDER):
            yield int(model.geom_bodyid[at])


def _unbalanced(source: Source, roles: Roles, joint: int) -> Iterator[Refusal]:
    """Yields that a wheel's mass does not turn about its axis."""
    model = source.model
    bodies = [b for b in source.subtree(int(model.jnt_bodyid[joint])) if model.body_mass[b] > 0]
    mass, middle = source.mass_of(bodies)
    axis, anchor = source.axis(joint), source.anchor(joint)
    if not mass:
        return
    off = float(np.linalg.norm(np.cross(middle - anchor, axis)))
    total = float(model.body_subtreemass[roles.root])
    low = min((source.bottom(g) for g in source.geoms_of(bodies)), default=anchor[2] - 1.0)
    radius = max(anchor[2] - low, 1e-9)
    across = _inertia_across(source, bodies, anchor, axis)
    if float(np.ptp(across)) > _UNROUND * total * radius**2:
        yield Refusal(
            source.element("joint", joint),
            f"the wheel's inertia across its axis is {across[0]:.3g} one way and {across[1]:.3g} kg m^2 the other; "
            "make it that of a body of revolution",
        )
    if mass * off > _OFF_AXIS * total * radius:
        yield Refusal(
            source.element("joint", joint),
            f"the wheel is eccentric: its centre of mass lies {off:.3g} m off its axis; put it on the axis",
        )


def _inertia_across(source: Source, bodies: Sequence[int], anchor: Array, axis: Array) -> Array:
    """Returns the principal moments of inertia across an axis, about a point of it [kg m^2], shape (2,)."""
    plane = np.linalg.svd(axis[None])[2][1:]
    return np.asarray(np.linalg.eigvalsh(plane @ source.inertia_about(bodies, anchor) @ plane.T))


def _floating(source: Source, roles: Roles) -> Iterator[Refusal]:
    """Yields bodies whose weight MuJoCo takes away, unless they are arms, which are held: their weight then counts."""
    model = source.model
    for body in source.subtree(roles.root):
        arm = [*source.chain(body), *source.subtree(body)] if body != roles.root else []
        held = any(j in roles.held for each in arm for j in source.joints_of(each))
        weightless = float(model.body_gravcomp[body] * model.body_mass[body])
        if weightless and not held and abs(weightless) > 1e-6 * model.body_subtreemass[roles.root]:
            yield Refusal(
                source.element("body", body), f"gravcomp {model.body_gravcomp[body]:g} takes its weight off: remove it"
            )


def leftovers(source: Source, roles: Roles) -> Iterator[str]:
    """Yields what of a file is left out, a sentence each."""
    model, inside = source.model, set(source.subtree(roles.root))
    yield from _freedom(source, roles)
    outside = [g for g in range(model.ngeom) if int(model.geom_bodyid[g]) not in inside]
    bodies = [source.name("body", b) for b in range(1, model.nbody) if b not in inside]
    parts = [_counted(len(outside), "geom") + " of the world" if outside else "", _counted(model.nlight, "light")]
    if bodies:
        parts.append(f"the bodies {_some(bodies)}")
    driving = {pull.actuator for pull in roles.pulls if pull.joint in roles.wheels}
    idle = [source.name("actuator", a) for a in range(model.nu) if a not in driving]
    parts += [_counted(model.nsensor, "sensor"), _counted(model.nkey, "key")]
    parts += [f"{_counted(len(idle), 'actuator')} ({_some(idle)})" if idle else "", *_surroundings(source)]
    if any(parts):
        yield f"left out: {', '.join(part for part in parts if part)}; options and contact settings are the scene's"
    if roles.held:
        names = [source.name("joint", j) for j in roles.held]
        yield f"held: {_counted(len(names), 'joint')} ({_some(names)}), their masses counted"
    if roles.swivels:
        names = [source.name("joint", j) for j in roles.swivels]
        yield f"casters swing freely about {_some(names)}: the reduced model does not know of it, the gap shows it"


def _freedom(source: Source, roles: Roles) -> Iterator[str]:
    """Yields what is made of the joint that lets the base move."""
    model = source.model
    free = [j for j in source.joints_of(roles.root) if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_FREE]
    if not free:
        yield f"{source.element('body', roles.root)} has no free joint: it gets one"
    for joint in free:
        dofs = slice(int(model.jnt_dofadr[joint]), int(model.jnt_dofadr[joint]) + 6)
        held = {"damping": model.dof_damping, "armature": model.dof_armature, "frictionloss": model.dof_frictionloss}
        said = [name for name, values in held.items() if values[dofs].any()]
        if said:
            yield f"{source.element('joint', joint)} moves freely: its {' and '.join(said)} is left out"


def _surroundings(source: Source) -> Iterator[str]:
    """Yields what a file has around its robot that scenes do not have."""
    option = source.model.opt
    if option.density or option.viscosity or np.any(option.wind):
        yield "its air or water"
    weightless = option.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY
    if weightless or np.abs(option.gravity - (0, 0, -9.81)).max() > 0.02:
        yield "its gravity"


def _counted(number: int, noun: str) -> str:
    """Returns how many of something there are; empty for none."""
    return f"{number} {noun}{'' if number == 1 else 's'}" if number else ""


def _some(names: Sequence[str]) -> str:
    """Returns the first few of many names."""
    return ", ".join(names[:6]) + (" ..." if len(names) > 6 else "")
