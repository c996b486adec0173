"""What the bearings and gears of the wheels take: viscous and dry friction at the wheel joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nhtrack.arrays import Array, namespace

_Pair = tuple[float, float]


@dataclass(frozen=True)
class WheelLosses:
    """Friction torques at the joints of the wheels (left, right), d w + c sign(w) at the wheel speed w.

    Attributes:
        damping: d, viscous [N m s/rad].
        dry_friction: c, Coulomb's, which holds a wheel at rest against torques up to it [N m].
    """

    damping: _Pair = (0.0, 0.0)
    dry_friction: _Pair = (0.0, 0.0)

    def __bool__(self) -> bool:
        """Returns whether there are any."""
        return any((*self.damping, *self.dry_friction))

    def viscous(self, speed: Array) -> Array:
        """Returns d w [N m] at wheel speeds w [rad/s], both (..., 2)."""
        return speed * namespace(speed).asarray(self.damping)

    def dry(self, speed: Array, rate: Array) -> Array:
        """Returns c sign(w) [N m] of wheels that do as they are told, both (..., 2).

        Args:
            speed: w [rad/s].
            rate: their acceleration [rad/s^2], in whose direction wheels at rest begin to turn.
        """
        xp = namespace(speed, rate)
        direction = xp.where(speed == 0, xp.sign(rate), xp.sign(speed))
        return direction * xp.asarray(self.dry_friction)

    def held(self, speed: Array, rate: Array, mobility: np.ndarray) -> Array:
        """Returns the torques of dry friction [N m] on wheels that torques act on, shape (..., 2).

        That of a turning wheel is c sign(w). That of a wheel at rest, within +-c, is the one that leaves it at rest, or
        the one that leaves it least acceleration: the f that minimises `f G f/2 - f rate` within these bounds. At its
        minimum no torque lies inside its bounds, one does, or both, which are five cases to choose from.

        Args:
            speed: w [rad/s], shape (..., 2).
            rate: acceleration that the wheels would have without dry friction [rad/s^2], shape (..., 2).
            mobility: G, from wheel torques to wheel accelerations, shape (2, 2).
        """
        xp = namespace(speed, rate)
        turning, c = xp.sign(speed), xp.asarray(self.dry_friction)
        lowest, highest = xp.where(speed == 0, -c, c * turning), xp.where(speed == 0, c, c * turning)

        def beside(first: Array, wheel: int) -> Array:
            """Returns the torques with a given one of a wheel, and the best for the other."""
            other = 1 - wheel
            second = (rate[..., other] - mobility[other, wheel] * first) / mobility[other, other]
            second = xp.clip(second, lowest[..., other], highest[..., other])
            return xp.stack([first, second] if wheel == 0 else [second, first], axis=-1)

        def work(f: Array) -> Array:
            terms = (f @ xp.asarray(mobility) / 2 - rate) * f
            return terms[..., 0] + terms[..., 1]

        best = xp.clip(rate @ xp.asarray(np.linalg.inv(mobility)), lowest, highest)
        for bound in (lowest, highest):
            for wheel in (0, 1):
                tried = beside(bound[..., wheel], wheel)
                best = xp.where((work(tried) < work(best))[..., None], tried, best)
        return best


NO_LOSSES = WheelLosses()
