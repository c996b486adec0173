"""What robots stand on: friction by place, and gravity on a slope."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from nhtrack.arrays import Array

GRAVITY = 9.81


class Gravity(NamedTuple):
    """Gravity as a robot on the floor feels it [m/s^2]: along its x and y axes, and into the floor."""

    x: Array | float
    y: Array | float
    normal: float


LEVEL = Gravity(0.0, 0.0, GRAVITY)


@dataclass(frozen=True)
class Patch:
    """A region of the floor with a friction coefficient of its own; a disc or a rectangle.

    Attributes:
        friction: Coulomb coefficient of wheels on it [1].
        rectangle: (x_min, x_max, y_min, y_max) [m], or None.
        disc: centre and radius (x, y, r) [m], or None.
    """

    friction: float
    rectangle: tuple[float, float, float, float] | None = None
    disc: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        if (self.rectangle is None) == (self.disc is None):
            raise ValueError("patch: expected a rectangle or a disc")

    def covers(self, position: Array) -> Array:
        """Returns whether points of the floor, shape (..., 2) [m], lie on the patch, its edge included; shape (...)."""
        x, y = position[..., 0], position[..., 1]
        if self.disc is not None:
            x_0, y_0, radius = self.disc
            return np.asarray(np.hypot(x - x_0, y - y_0) <= radius)
        assert self.rectangle is not None
        x_min, x_max, y_min, y_max = self.rectangle
        return np.asarray((x_min <= x) & (x <= x_max) & (y_min <= y) & (y <= y_max))

    def grown(self, margin: float) -> Patch:
        """Returns the patch with its edge so much farther out [m]; the corners of a rectangle stay square."""
        if self.disc is not None:
            x, y, radius = self.disc
            return replace(self, disc=(x, y, radius + margin))
        assert self.rectangle is not None
        x_min, x_max, y_min, y_max = self.rectangle
        return replace(self, rectangle=(x_min - margin, x_max + margin, y_min - margin, y_max + margin))


@dataclass(frozen=True)
class Ground:
    """An endless plane, level or inclined.

    Attributes:
        friction: Coulomb coefficient of wheels outside all patches [1].
        patches: regions with a coefficient of their own; where they overlap the last one counts.
        slope: angle of the plane with the horizontal [rad].
        uphill: direction in the plane in which it rises, from the x axis [rad].
    """

    friction: float = 1.0
    patches: tuple[Patch, ...] = ()
    slope: float = 0.0
    uphill: float = 0.0

    def friction_at(self, position: Array) -> Array:
        """Returns the friction coefficient at points of the floor, shape (..., 2) [m] -> (...)."""
        friction = np.full(position.shape[:-1], self.friction)
        for patch in self.patches:
            friction = np.where(patch.covers(position), patch.friction, friction)
        return friction

    def scaled(self, share: float) -> Ground:
        """Returns the ground with a share of the friction everywhere."""
        patches = tuple(replace(patch, friction=share * patch.friction) for patch in self.patches)
        return replace(self, friction=share * self.friction, patches=patches)

    @property
    def gravity(self) -> tuple[float, float, float]:
        """Gravity in the frame of the plane, z along its normal [m/s^2]."""
        along = -GRAVITY * math.sin(self.slope)
        return along * math.cos(self.uphill), along * math.sin(self.uphill), -GRAVITY * math.cos(self.slope)

    def gravity_at(self, theta: Array) -> Gravity:
        """Returns gravity in the body frames of robots with headings theta [rad], any shape."""
        if self.slope == 0.0:
            return LEVEL
        along, ahead = GRAVITY * math.sin(self.slope), self.uphill - theta
        return Gravity(-along * np.cos(ahead), -along * np.sin(ahead), GRAVITY * math.cos(self.slope))
