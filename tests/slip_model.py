"""A second engine: a planar differential-drive robot that rolls, spins its wheels and slides under Coulomb friction.

Written from rigid-body mechanics alone, to be held against MuJoCo's wheel contacts; nothing of `nhtrack` is used.

Body frame: origin on the floor below the axle midpoint, x forward, y to the left, z up. The velocity u = (v_x, v_y,
omega, phi_left, phi_right) is that of the axle midpoint, of the yaw and of the two wheels about their axle. Newton and
Euler in the turning frame, with wheel torques Q and the floor's forces f on the wheels:

    M u' + C(u) = Q + J^T f,    slip velocities s = J u,
    s_left = (v_x - b omega - r phi_left, v_y),    s_right = (v_x + b omega - r phi_right, v_y).

Loads N are quasi-static: the robot stays upright, so that vertical force, pitch and roll balance at every instant, with
the inertia of the CoM at its height, of the wheels' spin and of the products of inertia. N thus depends on the
acceleration, and so on f. Coulomb's law, by which friction dissipates as much as it can, holds at both wheels:

    |f| <= mu N,    f = -mu N s/|s| where s is not zero.

The law is set-valued, so a wheel that holds has a slip velocity of zero, not a small one. Where both wheels hold, only
the sum of their side forces is determined, since they share an axle: equal shares are taken as far as the friction
circles allow.

Steps are those of the L-stable SDIRK method of order 2 (Alexander 1977), each stage an implicit Euler step with
Coulomb's law at its end. Where a force jumps or turns quickly, as where a slip ends, steps are halved down to a
thousandth, so that what is of first order there is so in a thousandth of a step. Poses follow by the trapezoidal rule.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

GRAVITY = 9.81

# Diagonal coefficient that makes Alexander's method of order 2 L-stable.
GAMMA = 1 - np.sqrt(0.5)
# A step over which a force changes by more than this share of mu m g is halved, at most so many times.
JUMP = 0.05
HALVINGS = 10
# Forces are solved to this share of the weight and velocities to this many m/s and rad/s, far below any step's error.
FORCE_SOLVED = 1e-11
VELOCITY_SOLVED = 1e-10
# A wheel whose slip velocity is below this [m/s] holds; what the solution of the forces leaves is smaller.
HELD = 1e-9
UNIT = np.eye(4)

Torques = Callable[[float], np.ndarray]
"""Wheel torques (left, right) [N m] as a function of time [s]."""


@dataclass(frozen=True)
class SlipRobot:
    """The numbers of one robot.

    Attributes:
        wheel_radius: r [m].
        half_separation: b, from the axle midpoint to a wheel [m].
        mass: of the whole robot [kg].
        yaw_inertia: of the whole robot about the vertical through its CoM [kg m^2].
        com: CoM, forward and to the left of the axle midpoint [m].
        com_height: height of the CoM above the floor [m].
        wheel_inertia: of one wheel about its axle [kg m^2].
        casters: places of the frictionless casters, forward and to the left of the axle midpoint [m]. Loads of one
            caster are exact; of several, those with the least sum of squares.
        friction: mu.
        rotor_inertia: what a motor adds to its wheel's, geared so high that its angular momentum is none [kg m^2].
        products_of_inertia: integrals of x z and y z over the mass, about the CoM [kg m^2].
    """

    wheel_radius: float
    half_separation: float
    mass: float
    yaw_inertia: float
    com: tuple[float, float]
    com_height: float
    wheel_inertia: float
    casters: tuple[tuple[float, float], ...]
    friction: float
    rotor_inertia: float = 0.0
    products_of_inertia: tuple[float, float] = (0.0, 0.0)

    @cached_property
    def mass_matrix(self) -> np.ndarray:
        """M, shape (5, 5)."""
        (x, y), m = self.com, self.mass
        matrix = np.zeros((5, 5))
        matrix[:3, :3] = [[m, 0, -m * y], [0, m, m * x], [-m * y, m * x, self.yaw_inertia + m * (x * x + y * y)]]
        matrix[3:, 3:] = (self.wheel_inertia + self.rotor_inertia) * np.eye(2)
        return matrix

    @cached_property
    def mobility(self) -> np.ndarray:
        """Inverse of M, shape (5, 5)."""
        return np.linalg.inv(self.mass_matrix)

    @cached_property
    def slip_matrix(self) -> np.ndarray:
        """J of the slip velocities (left x, left y, right x, right y), shape (4, 5)."""
        r, b = self.wheel_radius, self.half_separation
        sideways = [0.0, 1, 0, 0, 0]
        return np.array([[1.0, 0, -b, -r, 0], sideways, [1.0, 0, b, 0, -r], sideways])

    @cached_property
    def compliance(self) -> np.ndarray:
        """Rates of change of the slip velocities with the floor's forces, shape (4, 4)."""
        return self.slip_matrix @ self.mobility @ self.slip_matrix.T

    @cached_property
    def stiffness(self) -> float:
        """Inverse of the largest of them."""
        return 1 / float(np.linalg.norm(self.compliance, 2))

    def turning_force(self, u: np.ndarray) -> np.ndarray:
        """C(u): the forces that a velocity needs to stay as it is in the turning frame, shape (5,)."""
        (x, y), (v_x, v_y, omega) = self.com, u[:3]
        return self.mass * omega * np.array([-v_y - omega * x, v_x - omega * y, x * v_x + y * v_y, 0, 0])

    def rolling(self, v: float, omega: float) -> np.ndarray:
        """Returns the velocity of a robot whose wheels roll without slip, shape (5,)."""
        across = self.half_separation * omega
        return np.array([v, 0, omega, (v - across) / self.wheel_radius, (v + across) / self.wheel_radius])

    def loads(self, u: np.ndarray, rate: np.ndarray) -> np.ndarray:
        """Normal forces (left, right, casters) [N] at a velocity and its rate of change in the body frame."""
        return self._support @ (self._balance(u) - self._inertial @ rate)

    @cached_property
    def load_per_force(self) -> np.ndarray:
        """Change of the wheels' loads with the floor's forces, through the accelerations they cause, shape (2, 4)."""
        return -(self._support @ self._inertial @ self.mobility @ self.slip_matrix.T)[:2]

    @cached_property
    def _support(self) -> np.ndarray:
        """Loads of the supports from sum N, sum N x and sum N y, shape (2 + casters, 3)."""
        b = self.half_separation
        points = np.array([(0.0, b), (0.0, -b), *self.casters])
        return np.linalg.pinv(np.vstack([np.ones(len(points)), points.T]))

    def _balance(self, u: np.ndarray) -> np.ndarray:
        """Sum N, sum N x and sum N y at a constant u: weight, centripetal forces and gyroscopic moments, shape (3,)."""
        (x, y), (xz, yz) = self.com, self.products_of_inertia
        weight, omega, force = self.mass * GRAVITY, u[2], self.turning_force(u)
        pitch = weight * x - self.com_height * force[0] + xz * omega**2
        roll = weight * y - self.com_height * force[1] + yz * omega**2 - self.wheel_inertia * omega * (u[3] + u[4])
        return np.array([weight, pitch, roll])

    @cached_property
    def _inertial(self) -> np.ndarray:
        """What each rate of u takes away from sum N, sum N x and sum N y, shape (3, 5)."""
        (x, y), (xz, yz), moment = self.com, self.products_of_inertia, self.mass * self.com_height
        spin = self.wheel_inertia
        pitch = [moment, 0, -moment * y - yz, spin, spin]
        roll = [0, moment, moment * x + xz, 0, 0]
        return np.array([np.zeros(5), pitch, roll])


class Instant(NamedTuple):
    """Where a step ends.

    Attributes:
        pose: x [m], y [m], theta [rad] in the world, shape (3,).
        u: velocity, shape (5,).
        force: the floor's forces (left x, left y, right x, right y) in the body frame [N], shape (4,).
        load: normal forces (left, right, casters) [N].
    """

    pose: np.ndarray
    u: np.ndarray
    force: np.ndarray
    load: np.ndarray


@dataclass(frozen=True)
class SlipRun:
    """A run of n steps: n + 1 times, poses and velocities, and n forces and loads, those at the ends of the steps."""

    time: np.ndarray
    pose: np.ndarray
    u: np.ndarray
    force: np.ndarray
    load: np.ndarray

    def slip(self, robot: SlipRobot) -> np.ndarray:
        """Returns the slip velocities (left x, left y, right x, right y) [m/s], shape (n + 1, 4)."""
        return self.u @ robot.slip_matrix.T

    def utilisation(self, robot: SlipRobot) -> np.ndarray:
        """Returns |f|/(mu N) of the wheels at the ends of the steps, shape (n, 2)."""
        return np.hypot(self.force[:, ::2], self.force[:, 1::2]) / (robot.friction * self.load[:, :2])


def simulate(robot: SlipRobot, torques: Torques, start: np.ndarray, duration: float, h: float) -> SlipRun:
    """Returns a run in steps of h from the world's origin, heading along x, at the velocity `start`, shape (5,)."""
    now = Instant(np.zeros(3), np.asarray(start, float), np.zeros(4), np.zeros(2 + len(robot.casters)))
    instants = [now]
    for k in range(round(duration / h)):
        instants.append(now := advance(robot, now, h, torques, k * h))
    pose, u, force, load = (np.array(column) for column in zip(*instants, strict=True))
    return SlipRun(h * np.arange(len(instants)), pose, u, force[1:], load[1:])


def advance(
    robot: SlipRobot, now: Instant, h: float, torques: Torques, t: float, halvings: int = HALVINGS
) -> Instant:
    """Returns the end of one step from the time t, halved where a force jumps.

    The smallest of halved steps are implicit Euler steps: the second stage starts from an extrapolation, which would
    carry a slip that ends beyond zero.
    """
    u, force, _ = implicit_step(robot, now.u, GAMMA * h, torques(t + GAMMA * h), now.force)
    base = now.u + (1 - GAMMA) / GAMMA * (u - now.u)
    last = implicit_step(robot, base, GAMMA * h, torques(t + h), force)
    if np.abs(last[1] - force).max() > JUMP * robot.friction * robot.mass * GRAVITY:
        if halvings > 0:
            middle = advance(robot, now, h / 2, torques, t, halvings - 1)
            return advance(robot, middle, h / 2, torques, t + h / 2, halvings - 1)
        last = implicit_step(robot, now.u, h, torques(t + h), force)
    return Instant(moved(now.pose, now.u, last[0], h), *last)


def moved(pose: np.ndarray, before: np.ndarray, after: np.ndarray, h: float) -> np.ndarray:
    """Returns the pose after a step, by the trapezoidal rule on the velocities at its ends."""
    theta = pose[2] + h * (before[2] + after[2]) / 2
    step = h / 2 * (complex(*before[:2]) * np.exp(1j * pose[2]) + complex(*after[:2]) * np.exp(1j * theta))
    return np.array([pose[0] + step.real, pose[1] + step.imag, theta])


def implicit_step(
    robot: SlipRobot, start: np.ndarray, h: float, torque: np.ndarray, guess: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns velocity, forces and loads at the end of an implicit Euler step: Coulomb's law, loads and motion at once.

    Newton's method on Coulomb's law written as projections on the friction circles (Alart and Curnier 1991). Products
    of velocities are those of the iteration before, which costs iterations but no exactness. Where thirty iterations
    do not do, ten plain projections lead out of the cycle that Newton's method has fallen into.

    Args:
        robot: the robot.
        start: velocity at the start, shape (5,).
        h: length of the step [s].
        torque: wheel torques during it [N m], shape (2,).
        guess: forces to begin with [N], shape (4,).

    Raises:
        ArithmeticError: no solution was found, or a support would have to pull.
    """
    slip, mobility = robot.slip_matrix, h * robot.mobility
    stiffness = robot.stiffness / h
    pull_slope, limit_slope = robot.stiffness * robot.compliance, robot.friction * robot.load_per_force
    applied = np.concatenate([np.zeros(3), torque])
    force, u = guess, start
    for iteration in range(200):
        before, u = u, start + mobility @ (applied - robot.turning_force(u) + slip.T @ force)
        load = robot.loads(u, (u - start) / h)
        limit = robot.friction * np.maximum(load[:2], 0)
        residual, slope = coulomb_residual(force, stiffness * slip @ u, limit, pull_slope, limit_slope)
        solved = np.abs(residual).max() <= FORCE_SOLVED * robot.mass * GRAVITY
        if solved and np.abs(u - before).max() <= VELOCITY_SOLVED:
            if load.min() < 0:
                raise ArithmeticError("a support would have to pull")
            return u, shared(force, limit) if np.abs(slip @ u).max() < HELD else force, load
        plain = iteration % 40 >= 30
        force = force - (residual if plain else np.linalg.lstsq(slope, residual, rcond=1e-12)[0])
    raise ArithmeticError("no forces that obey Coulomb's law were found")


def coulomb_residual(
    force: np.ndarray, pull: np.ndarray, limit: np.ndarray, pull_slope: np.ndarray, limit_slope: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Returns f - proj(f - p), zero where Coulomb's law holds, and its derivative by the forces.

    Args:
        force: f, shape (4,).
        pull: p, slip velocities times any positive number [N], shape (4,).
        limit: radii mu N of the friction circles projected on, shape (2,).
        pull_slope: derivative of the pull by the forces, shape (4, 4).
        limit_slope: derivative of the radii by the forces, shape (2, 4).
    """
    residual, slope = pull.copy(), pull_slope.copy()
    for wheel in (0, 1):
        rows = slice(2 * wheel, 2 * wheel + 2)
        trial = force[rows] - pull[rows]
        size = np.hypot(*trial)
        if size > limit[wheel]:
            along = trial / size
            across = limit[wheel] / size * (UNIT[:2, :2] - along[:, None] * along)
            residual[rows] = force[rows] - limit[wheel] * along
            slope[rows] = UNIT[rows] - across @ (UNIT[rows] - pull_slope[rows]) - along[:, None] * limit_slope[wheel]
    return residual, slope


def shared(force: np.ndarray, limit: np.ndarray) -> np.ndarray:
    """Returns forces of wheels that both hold with equal side forces, as far as the friction circles allow."""
    total = force[1] + force[3]
    room = np.sqrt(np.maximum(limit**2 - force[::2] ** 2, 0))
    right = np.clip(total - np.clip(total / 2, -room[0], room[0]), -room[1], room[1])
    return np.array([force[0], total - right, force[2], right])
