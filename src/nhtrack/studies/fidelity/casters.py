"""What casters that swivel do to a robot: its motion with casters that roll, which the reduced model takes as fixed.

A caster of trail t, its swivel at s, rolls where the robot pulls it: with f and l ahead of and beside its wheel,

    (v + omega x (s + t) + phi' x t) . l = 0   gives phi',   the same . f = radius psi'   the spin of its wheel,

so that (v, omega) and the angles phi determine all velocities, qvel = S(phi) (v, omega). What the wheel torques of the
reduced model bring about, computed for casters that are fixed where they trail, is then

    S^T M S (u_x, u_theta) + S^T (bias + M dS/dt (v, omega) + d phi') = the same with fixed casters, as asked.

Nothing here knows of contacts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import mujoco
import numpy as np
from scipy.integrate import solve_ivp

from nhtrack.arrays import Array
from nhtrack.simulation.scene import Scene

_STEP = 1e-6  # [s] of the differences that give dS/dt


class Caster(NamedTuple):
    """A caster that swivels: where it does so, and which of MuJoCo's velocities are its own.

    Attributes:
        place: of the swivel in the chassis frame, shape (2,) [m].
        trail: from there to the wheel's centre where it trails, shape (2,) [m].
        axle: of the wheel there, pointing as it turns, shape (2,).
        radius: of its wheel [m].
        swivel: its joint, first in coordinates, then in velocities.
        roll: velocity of its wheel's joint.
        upright: 1 if the swivel turns as the robot does, -1 if the other way round.
    """

    place: Array
    trail: Array
    axle: Array
    radius: float
    swivel: tuple[int, int]
    roll: int
    upright: float


@dataclass(frozen=True)
class RollingCasters:
    """A robot alone, with casters that roll as its wheels do."""

    scene: Scene
    casters: tuple[Caster, ...]

    def slip_free(self, theta: float, phi: Array) -> tuple[Array, Array]:
        """Returns S, shape (nv, 2), and the rates of phi for v and for omega, shape (k, 2)."""
        pose = np.array([[0.0, 0.0, theta]])
        S = np.stack([self.scene.qvel_of(pose, np.array([unit])) for unit in ((1, 0, 0), (0, 0, 1))], axis=-1)
        rates = np.zeros((len(self.casters), 2))
        for caster, angle, rate in zip(self.casters, phi, rates, strict=True):
            turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
            trail, axle = turn @ caster.trail, turn @ caster.axle
            ahead = np.array([axle[1], -axle[0]])
            centre = np.stack([[1.0, 0.0], _across(caster.place + trail)], axis=-1)  # velocity for v and omega
            rate[:] = -(axle @ centre) / (axle @ _across(trail))
            S[caster.swivel[1]] = caster.upright * rate
            S[caster.roll] = ahead @ (centre + np.outer(_across(trail), rate)) / caster.radius
        return S, rates

    def balance(self, theta: float, phi: Array, velocity: Array, rolling: bool) -> tuple[Array, Array, Array]:
        """Returns S^T M S, the forces that (v, omega) takes without acceleration, and the rates of phi."""
        data, model = mujoco.MjData(self.scene.model), self.scene.model
        still = 0.0 * phi

        def columns(later: float, turning: Array) -> Array:
            S, _ = self.slip_free(theta + later * velocity[1], phi + later * turning)
            if not rolling:
                S[[dof for caster in self.casters for dof in (caster.swivel[1], caster.roll)]] = 0.0
            return S

        turning = self.slip_free(theta, phi)[1] @ velocity if rolling else still
        S, change = columns(0.0, turning), columns(_STEP, turning) - columns(-_STEP, turning)
        data.qpos = self.scene.qpos_of(np.array([[0.0, 0.0, theta]]), np.zeros((1, 2)))
        for caster, angle in zip(self.casters, phi, strict=True):
            data.qpos[caster.swivel[0]] += caster.upright * angle
        data.qvel, data.qacc = S @ velocity, change @ velocity / (2 * _STEP)
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        matrix, forces = np.zeros((model.nv, model.nv)), np.empty(model.nv)
        mujoco.mj_fullM(model, data, matrix)
        mujoco.mj_rne(model, data, 1, forces)
        forces += model.dof_armature * data.qacc
        own = [dof for caster in self.casters for dof in (caster.swivel[1], caster.roll)]
        forces[own] += model.dof_damping[own] * data.qvel[own]
        return S.T @ matrix @ S, S.T @ forces, turning

    def drive(self, signal: Callable[[Array], Array], time: Array) -> Array:
        """Returns the poses, shape (t, 3), of a robot that starts from rest with casters that trail."""
        k = len(self.casters)

        def rate(t: float, y: Array) -> Array:
            theta, phi, velocity = float(y[2]), y[3 : 3 + k], y[3 + k :]
            matrix, forces, turning = self.balance(theta, phi, velocity, rolling=True)
            fixed, asked, _ = self.balance(theta, 0.0 * phi, velocity, rolling=False)
            acceleration = np.linalg.solve(matrix, fixed @ signal(np.array(t)) + asked - forces)
            ahead = velocity[0] * np.array([np.cos(theta), np.sin(theta)])
            return np.concatenate([ahead, velocity[1:], turning, acceleration])

        found = solve_ivp(
            rate, (time[0], time[-1]), np.zeros(5 + k), method="DOP853", rtol=1e-9, atol=1e-11, t_eval=time
        )
        return np.asarray(found.y[:3].T)


def rolling_casters(scene: Scene) -> RollingCasters:
    """Returns the casters of a robot alone, those of its hinges that are no wheels of its own.

    Raises:
        ValueError: a hinge is not part of a caster: a swivel that stands upright, and in it a wheel.
    """
    model, data = scene.model, mujoco.MjData(scene.model)
    data.qpos = scene.qpos_of(np.zeros((1, 3)), np.zeros((1, 2)))
    mujoco.mj_forward(model, data)
    wheels = set(scene.addresses.wheel_qvel.ravel())
    hinges = [
        joint
        for joint in range(model.njnt)
        if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE and model.jnt_dofadr[joint] not in wheels
    ]
    found = []
    for swivel, roll in zip(hinges[::2], hinges[1::2], strict=True):
        upright, axle = data.xaxis[swivel][2], data.xaxis[roll]
        if abs(upright) < 1 - 1e-9 or abs(axle[2]) > 1e-9:
            raise ValueError(f"{model.joint(swivel).name} and {model.joint(roll).name} make no caster")
        place, centre = data.xanchor[swivel], data.xanchor[roll]
        addresses = int(model.jnt_qposadr[swivel]), int(model.jnt_dofadr[swivel])
        found.append(
            Caster(
                place[:2].copy(),
                (centre - place)[:2],
                axle[:2].copy(),
                float(centre[2]),
                addresses,
                int(model.jnt_dofadr[roll]),
                float(upright),
            )
        )
    return RollingCasters(scene, tuple(found))


def _across(vector: Array) -> Array:
    """Returns a vector of the plane turned by 90 degrees to the left."""
    return np.array([-vector[1], vector[0]])
