"""The numbers of a differential-drive robot, and what follows from them without any motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nhtrack.arrays import Array, namespace
from nhtrack.robots.diff_drive.losses import NO_LOSSES, WheelLosses
from nhtrack.robots.motor import Motor


@dataclass(frozen=True)
class WheeledBody:
    """Numbers of one robot, each read from its MJCF by `identify`; see `DiffDrive` for the frame.

    Attributes:
        wheel_radius: r [m].
        half_separation: b, from the axle midpoint to a wheel [m].
        mass: m, the whole robot [kg].
        axle_inertia: J_axle, the whole robot about the vertical through the axle midpoint [kg m^2].
        wheel_inertia: I_w, spin of one wheel with its motor's reflected rotor [kg m^2].
        com: CoM in the body frame (x, y) and its height above the floor [m], shape (3,).
        casters: contact points of the casters in the body frame (x, y) [m], shape (k, 2).
        motor: limits of each wheel motor.
        reflected_inertia: the part of I_w that is the rotor's, seen through the gears; it turns inside the chassis and
            tips nothing [kg m^2].
        products: elements (xz, yz) of the whole robot's inertia tensor about its CoM, axes as the body frame [kg m^2].
        compliances: how far wheels (left, right) and casters give way to a load, in any unit, shape (2 + k,); empty if
            alike.
            Only where there are more than three supports do they matter.
        levelled: whether a planar base keeps the robot level, so that the wheels share the weight whatever it does.
        losses: viscous and dry friction at the wheel joints.
    """

    wheel_radius: float
    half_separation: float
    mass: float
    axle_inertia: float
    wheel_inertia: float
    com: tuple[float, float, float]
    casters: tuple[tuple[float, float], ...]
    motor: Motor
    reflected_inertia: float = 0.0
    products: tuple[float, float] = (0.0, 0.0)
    compliances: tuple[float, ...] = ()
    levelled: bool = False
    losses: WheelLosses = NO_LOSSES

    @property
    def wheel_separation(self) -> float:
        """Distance between the wheels, 2 b [m]."""
        return 2 * self.half_separation

    @property
    def m_eff(self) -> float:
        """Mass the motors feel, m + 2 I_w / r^2 [kg]."""
        return self.mass + 2 * self.wheel_inertia / self.wheel_radius**2

    @property
    def J_eff(self) -> float:
        """Yaw inertia the motors feel, J_axle + 2 I_w b^2 / r^2 [kg m^2]."""
        return self.axle_inertia + 2 * self.wheel_inertia * (self.half_separation / self.wheel_radius) ** 2

    @property
    def first_moment(self) -> tuple[float, float]:
        """First moments m c_x and m c_y of the whole robot [kg m]."""
        return self.mass * self.com[0], self.mass * self.com[1]

    @property
    def mass_matrix(self) -> np.ndarray:
        """S^T M S = [[m_eff, -m c_y], [-m c_y, J_eff]], the inertia in (v, omega)."""
        return np.array([[self.m_eff, -self.first_moment[1]], [-self.first_moment[1], self.J_eff]])

    def mass_matrix_over(self, step: float) -> np.ndarray:
        """Returns S^T M S + h/2 B^T d B, the inertia in mean accelerations over a step h [s] that starts with d w.

        Viscous friction then acts by the mean of the wheel speeds w = B (v, omega) before and after the step.
        """
        B = self.rolling_map
        felt: np.ndarray = self.mass_matrix + step / 2 * B.T @ np.diag(self.losses.damping) @ B
        return felt

    def wheel_places(self, g: Array) -> Array:
        """Returns where the wheels (left, right) of robots at poses g, shape (..., 3), touch the floor, (..., 2, 2)."""
        xp = namespace(g)
        across = self.half_separation * xp.stack([-xp.sin(g[..., 2]), xp.cos(g[..., 2])], axis=-1)
        return xp.stack([g[..., :2] + across, g[..., :2] - across], axis=-2)

    def wheel_speeds(self, v: Array, omega: Array) -> Array:
        """Returns the speeds [rad/s] of wheels that roll without slip, (v -+ b omega)/r, shape (..., 2)."""
        xp = namespace(v, omega)
        across = self.half_separation * omega
        return xp.stack([v - across, v + across], axis=-1) / self.wheel_radius

    @property
    def rolling_map(self) -> np.ndarray:
        """Matrix of `wheel_speeds`: rows left and right, columns v and omega, shape (2, 2)."""
        b = self.half_separation
        return np.array([[1.0, -b], [1.0, b]]) / self.wheel_radius

    @property
    def top_speed(self) -> float:
        """Largest speed that the motors hold straight on, their losses alone to overcome [m/s]."""
        losses = zip(self.losses.damping, self.losses.dry_friction, strict=True)
        return self.wheel_radius * min(self.motor.free_speed(*loss) for loss in losses)
