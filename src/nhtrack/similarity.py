"""Length and time scaling between a scenario's own units and the robot's.

The laws are equivariant under x -> L x and t -> T t when accelerations and gains scale along:
`v -> v L/T`, `omega -> omega/T`, `u_x -> u_x L/T^2`, `u_theta -> u_theta/T^2`, `kp, ke -> /T^2`, `kd -> /T`,
k unchanged. Gravity, friction and the robot do not scale, so a factor chooses how hard the ground has to
work, and nothing else.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from nhtrack.arrays import Array, namespace, require_last_axis

_DIGITS = 4  # of a time scale; friction goes with its square and is then used to within 0.2 % of the margin


@dataclass(frozen=True)
class Similarity:
    """Maps a scenario to the robot and back.

    Attributes:
        length: robot metres per scenario length unit, L > 0.
        time: robot seconds per scenario time unit, T > 0.

    Raises:
        ValueError: a factor that is not positive and finite.
    """

    length: float = 1.0
    time: float = 1.0

    def __post_init__(self) -> None:
        for name, factor in (("length", self.length), ("time", self.time)):
            if not (math.isfinite(factor) and factor > 0):
                raise ValueError(f"similarity.{name}: expected a positive number, got {factor}")

    def times_to_robot(self, t: Array) -> Array:
        """Returns times on the robot's clock [s], t T; any shape."""
        return t * self.time

    def times_to_scenario(self, t: Array) -> Array:
        """Returns scenario times of times on the robot's clock, t / T; any shape."""
        return t / self.time

    def poses_to_robot(self, g: Array) -> Array:
        """Returns poses (x [m], y [m], theta [rad]) of scenario poses, (L x, L y, theta), shape (..., 3)."""
        return self._scaled("poses", g, (self.length, self.length, 1.0))

    def poses_to_scenario(self, g: Array) -> Array:
        """Returns scenario poses of robot poses, shape (..., 3)."""
        return self._scaled("poses", g, (1.0 / self.length, 1.0 / self.length, 1.0))

    def twists_to_robot(self, xi: Array) -> Array:
        """Returns body twists (v_x, v_y [m/s], omega [rad/s]): (L v_x, L v_y, omega)/T, shape (..., 3)."""
        speed = self.length / self.time
        return self._scaled("twists", xi, (speed, speed, 1.0 / self.time))

    def twists_to_scenario(self, xi: Array) -> Array:
        """Returns scenario twists of robot twists, shape (..., 3)."""
        speed = self.time / self.length
        return self._scaled("twists", xi, (speed, speed, self.time))

    def inputs_to_robot(self, u: Array) -> Array:
        """Returns accelerations (u_x [m/s^2], u_theta [rad/s^2]): (L u_x, u_theta)/T^2, shape (..., 2)."""
        return self._scaled("inputs", u, (self.length / self.time**2, 1.0 / self.time**2))

    def inputs_to_scenario(self, u: Array) -> Array:
        """Returns scenario accelerations of robot accelerations, shape (..., 2)."""
        return self._scaled("inputs", u, (self.time**2 / self.length, self.time**2))

    def scale(self, value: float, length: int, time: int) -> float:
        """Returns the robot's value of a scenario's quantity of unit length^length time^time, such as a gain.

        Args:
            value: in scenario units; may be an array.
            length: power of length in its unit.
            time: power of time.
        """
        return value * self.length**length * self.time**time

    @staticmethod
    def _scaled(name: str, values: Array, factors: tuple[float, ...]) -> Array:
        require_last_axis(name, values, len(factors))
        xp = namespace(values)
        return values * xp.asarray(factors, dtype=xp.float64)


def rounded_up(value: float, digits: int = _DIGITS) -> float:
    """Returns the smallest number of so many significant digits that is not below a positive value."""
    nearest = float(f"{value:.{digits}g}")
    if nearest >= value:
        return nearest
    step = 10.0 ** (math.floor(math.log10(value)) - digits + 1)
    return float(f"{nearest + step:.{digits}g}")
