"""A leader that is to be at given poses at given times, and the accelerations that take the ideal robot there.

Between instants the ideal robot holds its accelerations: its velocities are joined lines, and what these depart from a
smooth motion by adds up. So the accelerations of a period reach the motion's own velocities at its end, corrected by
what is missing of the pose at its beginning; errors of a period, of third order in it, fade instead of adding up.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from pydantic import ValidationError

from nhtrack.references.contract import InputSection, PathStart, ReferenceInputError
from nhtrack.section import Finding

Along: TypeAlias = Callable[[np.ndarray], np.ndarray]

_CORRECTION = 0.05  # share of a missing pose that is made good in a period
_SLOW = 0.01  # share of the greatest speed; below it, a lateral error is left for later
_NODES, _WEIGHTS = (np.array(rule) for rule in np.polynomial.legendre.leggauss(4))
_STOPPED = 0.01  # share of the greatest speed at which a motion that ends counts as ended


class Departure(NamedTuple):
    """How far the ideal leader is from its motion, over all instants; lengths in the motion's unit.

    Attributes:
        rms: root mean square distance.
        largest: largest distance.
        heading: largest difference of headings [rad].
    """

    rms: float
    largest: float
    heading: float


@dataclass(frozen=True)
class Motion:
    """Poses and velocities over time that a leader is to keep.

    Attributes:
        poses: (x, y, theta) at increasing times, shape (T,) to (T, 3), theta unwrapped.
        speeds: (v, omega) at them, shape (T,) to (T, 2).
        end: when it comes to its end; there it stands still. Infinite where it has none.
        tracked: whether a missing pose is made good; not where only velocities are given.
    """

    poses: Along
    speeds: Along
    end: float = math.inf
    tracked: bool = True

    def held(self, instants: np.ndarray) -> np.ndarray:
        """Returns accelerations (u_x, u_theta) to be held between instants, shape (T + 1,) to (T, 2).

        Raises:
            ReferenceInputError: the motion has no finite value at some time.
        """
        if not self.tracked:
            return np.asarray(np.diff(self.speeds(instants), axis=0) / np.diff(instants)[:, None])
        return self._driven(instants)[0]

    def departure(self, instants: np.ndarray) -> Departure:
        """Returns how far the ideal leader is from the motion at instants, shape (T + 1,)."""
        missing = self._driven(instants)[1] - self.poses(instants)
        distance = np.hypot(missing[:, 0], missing[:, 1])
        return Departure(float(np.sqrt(np.mean(distance**2))), float(distance.max()), float(abs(missing[:, 2]).max()))

    def _driven(self, instants: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns accelerations of the periods and poses of the ideal robot at instants."""
        goals, speeds = self.poses(instants), self.speeds(instants)
        slow = (_SLOW * float(abs(speeds[:, 0]).max())) ** 2 or 1.0
        pose, twist = tuple(goals[0].tolist()), tuple(speeds[0].tolist())
        poses, inputs = [pose], []
        steps = zip(np.diff(instants).tolist(), goals.tolist(), speeds[1:].tolist(), strict=False)
        for period, goal, following in steps:
            u = _accelerations(pose, twist, goal, following, slow, period)
            pose, twist = _flow(pose, twist, u, period)
            poses.append(pose)
            inputs.append(u)
        return np.array(inputs).reshape(-1, 2), np.array(poses)


def _accelerations(
    pose: tuple[float, ...], twist: tuple[float, ...], goal: list[float], following: list[float], slow: float, h: float
) -> tuple[float, float]:
    """Returns what to hold over a period of length h, from a pose and its goal, so that velocities come out right."""
    dx, dy, turn = goal[0] - pose[0], goal[1] - pose[1], goal[2] - pose[2]
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    ahead, aside = cos * dx + sin * dy, cos * dy - sin * dx
    rate, v = _CORRECTION / h, following[0]
    missing_v = rate * ahead
    missing_omega = 2 * rate * turn + rate**2 * v / (v * v + slow) * aside  # both roots of heading and side at -rate
    return (v + missing_v - twist[0]) / h, (following[1] + missing_omega - twist[1]) / h


def _flow(
    pose: tuple[float, ...], twist: tuple[float, ...], u: tuple[float, float], h: float
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Returns pose and velocities of the ideal robot after a period of length h under held accelerations."""
    x, y, theta = pose
    v, omega = twist
    for node, weight in zip(_NODES.tolist(), _WEIGHTS.tolist(), strict=True):
        s = 0.5 * h * (1 + node)
        heading, way = theta + omega * s + 0.5 * u[1] * s * s, 0.5 * h * weight * (v + u[0] * s)
        x, y = x + way * math.cos(heading), y + way * math.sin(heading)
    return (x, y, theta + omega * h + 0.5 * u[1] * h * h), (v + u[0] * h, omega + u[1] * h)


class MotionInput(InputSection):
    """A form of the leader's input that says where the leader is to be, or how fast; it says where it begins, too."""

    def reference(self) -> Motion:
        """Returns the motion, in scenario units."""
        raise NotImplementedError

    def start(self) -> PathStart:
        """Returns pose and velocities at the beginning."""
        motion, beginning = self.reference(), np.zeros(1)
        x, y, theta = motion.poses(beginning)[0].tolist()
        v, omega = motion.speeds(beginning)[0].tolist()
        return PathStart((x, y, theta) if motion.tracked else None, (v, omega))

    @classmethod
    def findings(cls, given: Mapping[str, Any], times: np.ndarray | None) -> Iterator[Finding]:
        """Yields why there is no motion, and that it ends, still moving, before the run does."""
        try:
            motion = cls.model_validate(given).reference()
            if times is None:
                return
            instants = np.insert(times, 0, 0.0)
            speeds = motion.speeds(instants)
            motion.poses(instants)
        except ReferenceInputError as error:
            yield (cls.key,), str(error)
        except (ValidationError, TypeError):
            return  # the section's own fault, told by its model; or a file that could not be read
        else:
            if motion.end < times[-1] * (1 - 1e-9):
                final = motion.speeds(np.array([motion.end]))[0]
                if (abs(final) > _STOPPED * abs(speeds).max(axis=0)).any():
                    yield (
                        (cls.key,),
                        f"it ends at t = {motion.end:.6g}, moving at v = {final[0]:.3g}, omega = {final[1]:.3g}, but "
                        f"the run goes on until t = {times[-1]:.6g}: shorten the duration, or let the leader stop",
                    )
