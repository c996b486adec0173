"""What casters that swivel do to a robot: its motion while they roll, where the reduced model takes them as fixed.

A caster rolls where the robot pulls it, so that (v, omega) and the angles of its joints determine all velocities,
qvel = S (v, omega). What the wheel torques of the reduced model bring about, computed for casters that are fixed
where they trail, is then

    S^T M S (v', omega') + S^T (bias + M S' (v, omega) + damping) = the same of fixed casters, as asked

with MuJoCo's mass matrix M and bias. Nothing here knows of contacts, or of how they give way.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import mujoco
import numpy as np
from scipy.integrate import solve_ivp

from nhtrack.arrays import Array
from nhtrack.simulation.casters import caster_rates
from nhtrack.simulation.scene import Scene
from nhtrack.studies.fidelity.bench import Bench, Finding
from nhtrack.studies.fidelity.motion import InputSignal, difference, drive_open_loop, integrate, middles, weave_within
from nhtrack.studies.fidelity.open_loop import DURATION, SHARE, path_length

_DIFFERENCE = 1e-6  # [s] between the configurations that S' is taken from
_TIMESTEPS = (0.002, 0.001)  # [s]
_MISSED, _POSITION, _HEADING, _ORDER = 0.02, 5e-4, 5e-3, 0.9  # of the prediction; of the path; [rad]; 1


class Balance(NamedTuple):
    """Inertia in (v, omega), shape (2, 2), forces that motion alone takes, (2,), rates of the casters' joints, (k,)."""

    inertia: Array
    forces: Array
    rates: Array


@dataclass(frozen=True)
class RollingCasters:
    """A robot alone, and its casters."""

    scene: Scene

    @property
    def joints(self) -> Array:
        """Velocities of the casters' joints, shape (k,)."""
        return np.asarray(self.scene.addresses.casters[0])

    def slip_free(self, theta: float, angles: Array, rolling: bool) -> tuple[mujoco.MjData, Array]:
        """Returns the robot at a place, and S there, shape (nv, 2)."""
        scene, pose = self.scene, np.array([[0.0, 0.0, theta]])
        data = mujoco.MjData(scene.model)
        data.qpos = scene.qpos_of(pose, np.zeros((1, 2)))
        data.qpos[scene.model.jnt_qposadr[scene.model.dof_jntid[self.joints]]] += angles
        mujoco.mj_fwdPosition(scene.model, data)
        S = np.stack([scene.qvel_of(pose, np.array([unit])) for unit in ((1, 0, 0), (0, 0, 1))], axis=-1)
        S[self.joints] = 0.0
        if rolling:
            S[self.joints] = caster_rates(scene.model, data, list(self.joints), list(scene.addresses.rollers[0]), S)
        return data, S

    def balance(self, theta: float, angles: Array, motion: Array, rolling: bool = True) -> Balance:
        """Returns what a motion (v, omega) takes at a heading and angles of the casters, rolling or fixed."""
        model, rates = self.scene.model, np.zeros(len(angles))
        data, S = self.slip_free(theta, angles, rolling)
        if rolling:
            rates = S[self.joints] @ motion
        ahead, behind = (
            self.slip_free(theta + h * motion[1], angles + h * rates, rolling)[1] for h in (_DIFFERENCE, -_DIFFERENCE)
        )
        data.qvel, data.qacc = S @ motion, (ahead - behind) @ motion / (2 * _DIFFERENCE)
        mujoco.mj_fwdVelocity(model, data)
        matrix, forces = np.zeros((model.nv, model.nv)), np.empty(model.nv)
        mujoco.mj_fullM(model, data, matrix)
        mujoco.mj_rne(model, data, 1, forces)
        forces += model.dof_armature * data.qacc  # rotors are no bodies, mj_rne leaves them out
        forces[self.joints] += model.dof_damping[self.joints] * data.qvel[self.joints]
        return Balance(S.T @ matrix @ S, S.T @ forces, rates)

    def drive(self, signal: InputSignal, time: Array) -> Array:
        """Returns the poses, shape (t, 3), of a robot that starts from rest with casters that trail."""
        k = len(self.joints)

        def rate(t: float, y: Array) -> Array:
            theta, angles, motion = float(y[2]), y[3 : 3 + k], y[3 + k :]
            found = self.balance(theta, angles, motion)
            asked = self.balance(theta, 0.0 * angles, motion, rolling=False)
            push = asked.inertia @ signal(np.array(t)) + asked.forces - found.forces
            ahead = motion[0] * np.array([np.cos(theta), np.sin(theta)])
            return np.concatenate([ahead, motion[1:], found.rates, np.linalg.solve(found.inertia, push)])

        start = np.zeros(5 + k)
        found = solve_ivp(rate, (time[0], time[-1]), start, method="DOP853", rtol=1e-8, atol=1e-10, t_eval=time)
        return np.asarray(found.y[:3].T)


def swivel_casters(bench: Bench) -> Iterator[Finding]:
    """Yields what casters that swivel do to a drive at half the motors' limits, and what they are predicted to do."""
    if not bench.swivels:
        return
    weave, finest = weave_within(bench.drive, SHARE, duration=DURATION), min(_TIMESTEPS)
    time = finest * np.arange(round(DURATION / finest) + 1)
    expected, ideal = RollingCasters(bench.scene()).drive(weave, time), integrate(weave, time)[0][:, 0]
    runs = [drive_open_loop(bench.simulation(timestep=h), weave(middles(DURATION, h))[:, None]) for h in _TIMESTEPS]
    left = [difference(run.g[:, 0], expected[:: round(h / finest)]) for run, h in zip(runs, _TIMESTEPS, strict=True)]
    gap, predicted, path = (
        difference(runs[-1].g[:, 0], ideal).position,
        difference(expected, ideal).position,
        path_length(weave),
    )
    cause = "casters that turn round push the robot aside, and rolling they have not the inertia of fixed ones"
    yield bench.find("swivel casters: gap to the ideal robot", gap / path, "1", (1 + _MISSED) * predicted / path, cause)
    missed = abs(gap / predicted - 1)
    yield bench.find("swivel casters: that gap against its prediction", missed, "1", _MISSED, cause)
    cause = "first order in the step: the rate correction is the tyres' alone, a caster that turns slides a little"
    yield bench.find("swivel casters: position beyond prediction", left[-1].position / path, "1", _POSITION, cause)
    yield bench.find("swivel casters: heading beyond prediction", left[-1].heading, "rad", _HEADING, cause)
    order = float(np.log2(left[0].position / left[1].position))
    yield bench.find(
        "swivel casters: order in the step, beyond prediction", order, "1", _ORDER, cause, sense="at least"
    )
