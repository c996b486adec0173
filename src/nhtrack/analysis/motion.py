"""The motion of robots in an ideal run, as the reduced model's functions take it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from nhtrack.arrays import Array
from nhtrack.experiment.build import Experiment
from nhtrack.experiment.driven import root_path
from nhtrack.experiment.loop import Rollout
from nhtrack.recording import COMPONENTS

WHEELS = COMPONENTS["wheel"]

_BLOCK = 1 << 15  # rows looked at at once, so that what is worked out of each stays small
Rates: TypeAlias = tuple[Array, Array, Array, Array]


class IdealMotion(NamedTuple):
    """Motion of n robots at the start and at the end of every control period, between which it changes linearly.

    Attributes:
        time: [s], shape (k,), two rows a period.
        g: poses, shape (k, ..., n, 3).
        v: forward velocities [m/s], shape (k, ..., n), and so the others.
        omega: yaw rates [rad/s].
        u_x: forward accelerations [m/s^2].
        u_theta: yaw accelerations [rad/s^2].
    """

    time: Array
    g: Array
    v: Array
    omega: Array
    u_x: Array
    u_theta: Array

    @property
    def rates(self) -> Rates:
        """v, omega, u_x, u_theta: what the reduced model's functions take."""
        return self.v, self.omega, self.u_x, self.u_theta

    @property
    def at_rest(self) -> Rates:
        """The same for robots that stand."""
        zero = np.zeros_like(self.v)
        return zero, zero, zero, zero

    def blocks(self) -> Iterator[IdealMotion]:
        """Yields the motion in pieces of some rows each, in order."""
        for first in range(0, len(self.time), _BLOCK):
            yield IdealMotion(*(values[first : first + _BLOCK] for values in self))


def root_motion(experiment: Experiment) -> IdealMotion:
    """Returns how the root of an experiment moves on the ideal model, arrays of shape (k,); nothing is run for it."""
    pose, v, omega = root_path_of(experiment)
    time = _ends(experiment.dt * np.arange(len(v)))
    return IdealMotion(time, _ends(pose), _ends(v), _ends(omega), *np.repeat(experiment.inputs, 2, axis=0).T)


def root_path_of(experiment: Experiment) -> tuple[Array, Array, Array]:
    """Returns poses, shape (k + 1, 3), v and omega of an experiment's root on the ideal model, period by period."""
    return root_path(experiment.inputs, experiment.dt, experiment.start.g[0], experiment.start.xi[0])


def motion_of(run: Rollout, robots: Any = slice(None)) -> IdealMotion:
    """Returns the motion of a run on the ideal model, of the chosen robots (indices or a slice).

    Of a run with a row every so many periods, the motion at the start of those periods only.
    """
    if run.every > 1:
        pose, twist, u = (run.variables[name][:-1, ..., robots, :] for name in ("pose", "twist", "input"))
        return IdealMotion(run.time[:-1], pose, twist[..., 0], twist[..., 2], u[..., 0], u[..., 1])
    pose, twist = (_ends(run.variables[name][..., robots, :]) for name in ("pose", "twist"))
    u = np.repeat(run.variables["input"][:-1, ..., robots, :], 2, axis=0)
    return IdealMotion(_ends(run.time), pose, twist[..., 0], twist[..., 2], u[..., 0], u[..., 1])


def _ends(values: Array) -> Array:
    """Returns the rows at the start and at the end of every period, shape (t, ...) -> (2 (t - 1), ...)."""
    return np.stack([values[:-1], values[1:]], axis=1).reshape(-1, *values.shape[1:])


def robots_with_wheels(experiment: Experiment) -> dict[str, int]:
    """Returns the index of every robot that has a body, by name: all but a virtual leader."""
    return {name: i for i, name in enumerate(experiment.network.names) if name in experiment.scene.bodies}
