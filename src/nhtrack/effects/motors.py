"""Limits of the wheel motors, in place of the robot's own."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

from pydantic import Field

from nhtrack.effects.contract import Effect
from nhtrack.section import Section

if TYPE_CHECKING:
    from nhtrack.robots.diff_drive import DiffDrive


class MotorsSection(Section):
    """Limits of the wheel motors, in place of the robot's own; robot units."""

    torque_limit: float | None = Field(
        default=None, gt=0, description="largest torque at a wheel [N m]; null keeps the robot's own"
    )
    no_load_speed: float | None = Field(
        default=None, gt=0, description="wheel speed at which a motor gives no torque [rad/s]; null keeps the robot's"
    )


@dataclass(frozen=True)
class Motors(Effect):
    """Limits of the wheel motors; None for the robot's own.

    Attributes:
        torque_limit: of each wheel motor [N m].
        no_load_speed: of each wheel [rad/s].
    """

    torque_limit: float | None = None
    no_load_speed: float | None = None

    key: ClassVar[str] = "motors"
    field: ClassVar[tuple[Any, Any]] = (
        MotorsSection,
        Field(default=MotorsSection(), description="limits of the wheel motors"),
    )

    @classmethod
    def of(cls, value: MotorsSection, length: float) -> Self | None:
        """Returns the limits, which are in robot units already."""
        return None if value == MotorsSection() else cls(value.torque_limit, value.no_load_speed)

    def model(self, model: DiffDrive) -> DiffDrive:
        """Returns the reduced model with these motors; their actuators get their limits from it."""
        limits = {name: limit for name, limit in vars(self).items() if limit is not None}
        return replace(model, motor=replace(model.motor, **limits))
