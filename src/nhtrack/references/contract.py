"""What a signal and a reference are, and what the file of a form of the leader's input defines."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np

from nhtrack.errors import NhtrackError
from nhtrack.section import Finding, Section


class ReferenceInputError(NhtrackError):
    """An input that cannot be understood or has no finite value at some time.

    Attributes:
        t: the time it happened at, or None where the fault is in the text itself.
    """

    def __init__(self, message: str, t: float | None = None) -> None:
        self.t = t
        super().__init__(message)


class Signal(Protocol):
    """A scalar function of time, sampled on a grid."""

    def __call__(self, t: np.ndarray) -> np.ndarray:
        """Returns the values at the times `t`, both of shape (T,)."""
        ...


class Commands(Protocol):
    """Accelerations for a robot that holds them from one instant to the next."""

    def held(self, instants: np.ndarray) -> np.ndarray:
        """Returns (u_x, u_theta) to be held between instants, shape (T + 1,) to (T, 2)."""
        ...


class PathStart(NamedTuple):
    """Where a leader begins whose input is a path, in scenario units.

    Attributes:
        pose: x, y, theta, or None where the input says only how fast it moves.
        twist: v, omega.
    """

    pose: tuple[float, float, float] | None
    twist: tuple[float, float]


@dataclass(frozen=True)
class Reference:
    """The root's commanded accelerations over time.

    Attributes:
        u_x: forward acceleration [length/time^2].
        u_theta: angular acceleration [rad/time^2].
    """

    u_x: Signal
    u_theta: Signal

    def sample(self, t: np.ndarray) -> np.ndarray:
        """Returns (u_x, u_theta) at the times `t` of shape (T,), shape (T, 2).

        Raises:
            ReferenceInputError: no finite value at some time.
        """
        times = np.asarray(t, dtype=np.float64)
        return np.stack([self.u_x(times), self.u_theta(times)], axis=-1)

    def held(self, instants: np.ndarray) -> np.ndarray:
        """Returns (u_x, u_theta) at the middles between instants, shape (T + 1,) to (T, 2).

        Raises:
            ReferenceInputError: no finite value at some time.
        """
        return self.sample(0.5 * (instants[1:] + instants[:-1]))


class InputSection(Section):
    """A form of the leader's input, and its section of a file.

    A subclass in a module of this room is found by `nhtrack.references.inputs`.

    Attributes:
        key: the key that only this form has, by which it is told from others.
        words: what messages call it.
    """

    key: ClassVar[str]
    words: ClassVar[str]

    def reference(self) -> Commands:
        """Returns the reference, in scenario units."""
        raise NotImplementedError

    def start(self) -> PathStart | None:
        """Returns where the leader has to begin, or None where the input does not say."""
        return None

    @classmethod
    def resolved(cls, given: Mapping[str, Any], directory: Path) -> Mapping[str, Any]:
        """Returns a raw section with what files hold in place of their names.

        Args:
            given: anything in it may be of the wrong type.
            directory: what relative paths start from.

        Raises:
            ValueError: a file cannot be read.
        """
        return given

    @classmethod
    def findings(cls, given: Mapping[str, Any], times: np.ndarray | None) -> Iterator[Finding]:
        """Yields faults that only show where the input is asked; of the section itself its model tells.

        Paths begin below the input.

        Args:
            given: the raw section; anything in it may be of the wrong type.
            times: the middles of the control periods, shape (T,), or None where these are at fault.
        """
        yield from ()
