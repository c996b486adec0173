"""Wheels of unlike radii, of which whoever computes the torques does not know."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from pydantic import Field

from nhtrack.effects.contract import Effect, Setting
from nhtrack.section import Finding

if TYPE_CHECKING:
    from nhtrack.robots.contract import Parts
    from nhtrack.robots.diff_drive import DiffDrive


@dataclass(frozen=True)
class WheelMismatch(Effect):
    """Tyres of unlike radii whose mean is the robot's.

    Attributes:
        mismatch: (r_left - r_right)/r [1].
    """

    mismatch: float

    key: ClassVar[str] = "wheel_mismatch"
    field: ClassVar[tuple[Any, Any]] = (
        float,
        Field(
            default=0.0,
            gt=-0.5,
            lt=0.5,
            description="how much larger the left wheel is than the right one, over the nominal radius [1]",
        ),
    )

    @classmethod
    def of(cls, value: float, length: float) -> Self | None:
        """Returns the mismatch, a ratio in any units."""
        return cls(value) if value else None

    def edit_robot(self, robot: Any, parts: Parts, model: DiffDrive) -> None:
        """Makes the left tyre larger than the right one."""
        for name, factor in zip(parts.tyres, (1 + self.mismatch / 2, 1 - self.mismatch / 2), strict=True):
            geom = robot.find("geom", name)
            size = geom.size if geom.size is not None else geom.dclass.geom.size
            geom.size = factor * np.asarray(size)

    def findings(self, setting: Setting) -> Iterator[Finding]:
        """Yields that such a robot leans where something holds it level."""
        if setting.holds_level:
            yield (
                (),
                f"wheels that differ by {self.mismatch:g} make a robot lean, and `base: planar` holds it level; "
                "use `base: free`",
            )
