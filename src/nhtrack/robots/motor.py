"""The limits of a wheel motor."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite

from nhtrack.arrays import Array, namespace


@dataclass(frozen=True)
class Motor:
    """Torque envelope of one geared direct-current motor, at the wheel.

    The torque is held within +-`torque_limit` (driver current) and, in the direction of motion, below the motor's line
    `stall_torque (1 - speed / no_load_speed)`.

    Attributes:
        torque_limit: largest torque the driver allows [N m]; infinite for none.
        stall_torque: torque at standstill at rated voltage [N m].
        no_load_speed: wheel speed at which the motor gives no torque [rad/s]; infinite for a motor without a line.
    """

    torque_limit: float
    stall_torque: float
    no_load_speed: float

    def __post_init__(self) -> None:
        for name in ("torque_limit", "stall_torque", "no_load_speed"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name}: expected a positive number, got {getattr(self, name)}")

    @property
    def slope(self) -> float:
        """Torque that the motor's line loses for each unit of speed, 0 where it has no line [N m s]."""
        return self.stall_torque / self.no_load_speed if isfinite(self.no_load_speed) else 0.0

    def saturate(self, torque: Array, wheel_speed: Array, lag: Array | float = 0.0) -> Array:
        """Returns the torque [N m] the motor delivers where `torque` is asked for at `wheel_speed` [rad/s].

        Args:
            torque: what is asked for.
            wheel_speed: the speed at the beginning of a time step h.
            lag: h stall_torque / (I no_load_speed) of a wheel that only its own inertia I holds. Its speed changes
                within the step, and the line is that of the speed at its end; else a light wheel that spins free would
                overshoot the line and be thrown back, more in every step.
        """
        xp = namespace(torque, wheel_speed)
        line = wheel_speed / self.no_load_speed
        # Cut on both sides: far above the no-load speed the line asks for more braking than the driver allows.
        upper = xp.clip(self.stall_torque * (1 - line) / (1 + lag), -self.torque_limit, self.torque_limit)
        lower = xp.clip(-self.stall_torque * (1 + line) / (1 + lag), -self.torque_limit, self.torque_limit)
        return xp.minimum(xp.maximum(torque, lower), upper)

    def free_speed(self, damping: float, dry_friction: float) -> float:
        """Returns the speed w [rad/s] that the motor holds against nothing but losses, d w + c, not below zero.

        `(1 - c/tau_s)/(1/w_0 + d/tau_s)`, or (tau_max - c)/d where the driver does not allow that torque.

        Args:
            damping: d [N m s/rad].
            dry_friction: c [N m].
        """
        fall = 1 / self.no_load_speed + damping / self.stall_torque
        spare = max(1 - dry_friction / self.stall_torque, 0.0)
        speed = spare / fall if fall else (inf if spare else 0.0)
        if (damping * speed if damping else 0.0) + dry_friction > self.torque_limit:
            speed = (self.torque_limit - dry_friction) / damping if damping else 0.0
        return max(speed, 0.0)
