"""Dynamics of a differential-drive robot that does not slip, in the two velocities (v, omega) that are left to it.

Body frame: origin at the axle midpoint on the axle, x forward, y along the axle to the left, z up. Planar inertia of
the whole robot about that point, in the order (v_x, v_y, omega):

    I = [[m, 0, -m c_y], [0, m, m c_x], [-m c_y, m c_x, J_axle]]

with CoM (c_x, c_y) and J_axle its inertia about the vertical through the axle midpoint. The wheels' spin adds
2 I_w / r^2 to the mass and 2 I_w b^2 / r^2 to the yaw inertia that the motors feel, but asks nothing of the ground. Nor
do losses at the wheel joints: motors supply them, and what is left of their torques reaches the ground.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from nhtrack.arrays import Array, namespace
from nhtrack.ground import LEVEL, Gravity, Ground
from nhtrack.robots.diff_drive.body import WheeledBody


class Wrench(NamedTuple):
    """Planar force and moment at the axle midpoint, body frame: f_x [N], f_y [N], tau [N m]; any shape."""

    f_x: Array
    f_y: Array
    tau: Array


@dataclass(frozen=True)
class DiffDrive(WheeledBody):
    """Reduced model of one robot, of the numbers of `WheeledBody`."""

    def ground_wrench(self, v: Array, omega: Array, u_x: Array, u_theta: Array, gravity: Gravity = LEVEL) -> Wrench:
        """Returns the wrench that wheel friction must supply, the friction demand.

        Euler-Poincare with v_y = 0, `F = I u - ad_xi^T I xi`, less what gravity does along a slope:

            f_x = m (u_x - g_x) - m c_y u_theta - m c_x omega^2
            f_y = m (omega v - g_y) + m c_x u_theta - m c_y omega^2
            tau = J_axle u_theta - m c_y (u_x - g_x) + m c_x (omega v - g_y)

        Args:
            v: forward velocity [m/s], any shape; the others broadcast with it.
            omega: yaw rate [rad/s].
            u_x: forward acceleration [m/s^2].
            u_theta: yaw acceleration [rad/s^2].
            gravity: in the body frame.
        """
        m_x, m_y = self.first_moment
        square, ahead, aside = omega * omega, u_x - gravity.x, omega * v - gravity.y
        return Wrench(
            self.mass * ahead - m_y * u_theta - m_x * square,
            self.mass * aside + m_x * u_theta - m_y * square,
            self.axle_inertia * u_theta - m_y * ahead + m_x * aside,
        )

    def wheel_torques(self, v: Array, omega: Array, u_x: Array, u_theta: Array, gravity: Gravity = LEVEL) -> Array:
        """Returns the wheel torques (left, right) [N m], shape (..., 2), that accelerate the robot by (u_x, u_theta).

        The motors supply the longitudinal force and the moment of `ground_wrench` and the wheels' own spin-up,
        `f = f_x + (2 I_w / r^2) u_x`, `t = tau + (2 I_w b^2 / r^2) u_theta`, split as `r/2 (f -+ t/b)`, and the losses
        `d w + c sign(w)` at each wheel's speed w; of a wheel at rest the sign is that of its acceleration.

        Args:
            v: forward velocity [m/s], any shape; the others broadcast with it.
            omega: yaw rate [rad/s].
            u_x: forward acceleration [m/s^2].
            u_theta: yaw acceleration [rad/s^2].
            gravity: in the body frame.
        """
        xp = namespace(v, omega, u_x, u_theta)
        f_x, _, tau = self.ground_wrench(v, omega, u_x, u_theta, gravity)
        r, b = self.wheel_radius, self.half_separation
        spin = 2 * self.wheel_inertia / r**2
        half_force = (r / 2) * (f_x + spin * u_x)
        half_moment = (r / (2 * b)) * (tau + spin * b**2 * u_theta)
        torque = xp.stack([half_force - half_moment, half_force + half_moment], axis=-1)
        return torque + self.wheel_losses(v, omega, u_x, u_theta) if self.losses else torque

    def wheel_losses(self, v: Array, omega: Array, u_x: Array, u_theta: Array) -> Array:
        """Returns what friction at the wheel joints takes of `wheel_torques` [N m], shape (..., 2)."""
        speed, rate = self.wheel_speeds(v, omega), self.wheel_speeds(u_x, u_theta)
        return self.losses.viscous(speed) + self.losses.dry(speed, rate)

    @cached_property
    def ground_map(self) -> np.ndarray:
        """Matrix of `ground_wrench`: (f_x, f_y, tau) = (u_x, u_theta, omega^2, omega v, g_x, g_y) W, shape (6, 3).

        With `torque_map` for simulations that evaluate these terms at times of their own.
        """
        m, (m_x, m_y) = self.mass, self.first_moment
        ahead, aside = (m, 0.0, -m_y), (0.0, m, m_x)
        turning, centripetal = (-m_y, m_x, self.axle_inertia), (-m_x, -m_y, 0.0)
        return np.array([ahead, turning, centripetal, aside, np.negative(ahead), np.negative(aside)])

    @cached_property
    def torque_map(self) -> np.ndarray:
        """Matrix of `wheel_torques` without losses, in the terms of `ground_map`, shape (6, 2)."""
        r, b = self.wheel_radius, self.half_separation
        force, moment = self.ground_map[:, 0].copy(), self.ground_map[:, 2].copy()
        force[0] += 2 * self.wheel_inertia / r**2
        moment[1] += 2 * self.wheel_inertia * (b / r) ** 2
        return r / 2 * np.stack([force - moment / b, force + moment / b], axis=-1)

    def wheel_loads(self, v: Array, omega: Array, u_x: Array, u_theta: Array, gravity: Gravity = LEVEL) -> Array:
        """Returns the quasi-static normal forces (left, right) [N], shape (..., 2).

        Balance of the force along the floor's normal, pitch and roll about the axle's ground point, with the inertia of
        the CoM at height h, of the spinning wheels (I each, without rotors) and of a body that is not symmetric to its
        vertical axis (I_xz, I_yz), and (f_x, f_y) of `ground_wrench`:

            sum N = m g_n
            sum N x = m g_n c_x - h f_x - 2 I u_x / r - I_yz u_theta - I_xz omega^2
            sum N y = m g_n c_y - h f_y - 2 I omega v / r + I_xz u_theta - I_yz omega^2

        over the wheels and casters at (x, y). Three supports bear what these say; more share it as their compliances
        have it, with the least energy. A negative load means that the wheel would lift. On a planar base each wheel
        bears half of the weight.
        """
        xp = namespace(v, omega, u_x, u_theta)
        f_x, f_y, _ = self.ground_wrench(v, omega, u_x, u_theta, gravity)
        c_x, c_y, height = self.com
        weight = self.mass * gravity.normal
        if self.levelled:
            half = xp.full_like(f_x + f_y, weight / 2)
            return xp.stack([half, half], axis=-1)
        spin = 2 * (self.wheel_inertia - self.reflected_inertia) / self.wheel_radius
        I_xz, I_yz = self.products
        pitch = weight * c_x - height * f_x - spin * u_x - I_yz * u_theta - I_xz * omega * omega
        roll = weight * c_y - height * f_y - spin * omega * v + I_xz * u_theta - I_yz * omega * omega
        left, right = (row[0] * weight + row[1] * pitch + row[2] * roll for row in self.load_solution.tolist())
        return xp.stack([left, right], axis=-1)

    @cached_property
    def load_solution(self) -> np.ndarray:
        """Wheels' loads by the sums of `wheel_loads`, shape (2, 3): of all that balance, least in sum C_i N_i^2."""
        wheels = [(0.0, self.half_separation), (0.0, -self.half_separation)]
        points = np.array([*wheels, *self.casters])
        balance = np.vstack([np.ones(len(points)), points.T])
        stiffness = 1 / np.sqrt(self.compliances or np.ones(len(points)))
        solution = stiffness[:, None] * np.linalg.pinv(balance * stiffness)
        return np.ascontiguousarray(solution[:2])

    def caster_load(self, v: Array, omega: Array, u_x: Array, u_theta: Array, gravity: Gravity = LEVEL) -> Array:
        """Returns what the casters bear together [N], the weight less `wheel_loads`; negative where they would lift."""
        wheels = self.wheel_loads(v, omega, u_x, u_theta, gravity)
        return self.mass * gravity.normal - wheels[..., 0] - wheels[..., 1]

    def support_loads(self, gravity: Gravity = LEVEL) -> dict[str, Array]:
        """Returns what wheels and casters of a robot that stands still bear [N], by their names, shaped as gravity."""
        still = (np.zeros(np.shape(gravity.x)),) * 4
        wheels = self.wheel_loads(*still, gravity)
        return {
            "left wheel": wheels[..., 0],
            "right wheel": wheels[..., 1],
            "caster": self.caster_load(*still, gravity),
        }

    def friction_demand(self, v: Array, omega: Array, u_x: Array, u_theta: Array, gravity: Gravity = LEVEL) -> Array:
        """Returns the horizontal force that each wheel asks of the floor [N], shape (..., 2).

        Longitudinal force of a wheel f_x/2 -+ tau/(2 b), lateral force f_y/2: the two wheels share an axle, so only
        their sum is determined; equal shares are assumed.
        """
        xp = namespace(v, omega, u_x, u_theta)
        f_x, f_y, tau = self.ground_wrench(v, omega, u_x, u_theta, gravity)
        moment = tau / self.half_separation
        longitudinal = xp.stack([f_x - moment, f_x + moment], axis=-1) / 2
        return xp.hypot(longitudinal, f_y[..., None] / 2)

    def friction_utilisation(
        self,
        v: Array,
        omega: Array,
        u_x: Array,
        u_theta: Array,
        friction: Array | float,
        gravity: Gravity = LEVEL,
    ) -> Array:
        """Returns the predicted utilisation of each wheel, hypot(f_long, f_lat)/(mu N), shape (..., 2).

        Force from `friction_demand`, load from `wheel_loads`, mu from `friction`, a number or one for each wheel.
        Infinite where the wheel would lift or friction is zero and a force is asked for, zero where none is.
        """
        demand = self.friction_demand(v, omega, u_x, u_theta, gravity)
        return utilisation(demand, friction * self.wheel_loads(v, omega, u_x, u_theta, gravity))

    def predicted_utilisation(
        self, ground: Ground, g: Array, v: Array, omega: Array, u_x: Array, u_theta: Array
    ) -> Array:
        """Returns the predicted utilisation of each wheel on a ground, see `friction_utilisation`, shape (..., 2).

        Args:
            ground: its friction where the wheels are, and gravity in the robots' frames.
            g: poses, shape (..., 3).
            v: forward velocity [m/s], shape (...).
            omega: yaw rate [rad/s].
            u_x: forward acceleration [m/s^2].
            u_theta: yaw acceleration [rad/s^2].
        """
        friction = ground.friction_at(self.wheel_places(g)) if ground.patches else ground.friction
        return self.friction_utilisation(v, omega, u_x, u_theta, friction, ground.gravity_at(g[..., 2]))

    def acceleration(self, v: Array, omega: Array, torque: Array) -> Array:
        """Returns (u_x, u_theta) under wheel torques (left, right), both (..., 2); inverse of `wheel_torques`.

        A wheel at rest stays at rest as long as its dry friction can hold it.
        """
        xp = namespace(v, omega, torque)
        m_x, _ = self.first_moment
        free = xp.stack([m_x * omega * omega, -m_x * omega * v], axis=-1)
        speed = self.wheel_speeds(v, omega)
        inertia = xp.asarray(np.linalg.inv(self.mass_matrix))
        given: Array = self.gained(torque - self.losses.viscous(speed)) + free @ inertia
        if not any(self.losses.dry_friction):
            return given
        rate = given @ xp.asarray(self.rolling_map.T)
        return given - self.gained(self.losses.held(speed, rate, self.torque_gain @ self.rolling_map.T))

    def gained(self, torque: Array) -> Array:
        """Returns what wheel torques (left, right) add to (u_x, u_theta), both (..., 2)."""
        xp = namespace(torque)
        return torque @ xp.asarray(self.torque_gain)

    @cached_property
    def torque_gain(self) -> np.ndarray:
        """Matrix of `gained`: rows left and right, columns u_x and u_theta, shape (2, 2)."""
        return self.torque_gain_over(0.0)

    def torque_gain_over(self, step: float) -> np.ndarray:
        """Returns the same for mean accelerations over a time step [s], see `mass_matrix_over`."""
        gain: np.ndarray = self.rolling_map @ np.linalg.inv(self.mass_matrix_over(step))
        return gain


def utilisation(demand: Array, limit: Array) -> Array:
    """Returns demand/limit; infinite where the limit is not positive but a force is asked for, zero where none is."""
    xp = namespace(demand, limit)
    positive = limit > 0
    ratio = demand / xp.where(positive, limit, xp.ones_like(limit))
    return xp.where(positive, ratio, xp.where(demand > 0, xp.full_like(demand, float("inf")), xp.zeros_like(demand)))
