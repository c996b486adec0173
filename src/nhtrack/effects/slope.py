"""An inclined floor. Gravity leans, not the floor, so that poses, contacts and the law live in its plane."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar, Self

from pydantic import BeforeValidator, Field

from nhtrack.effects.contract import Effect, RobotsAtRest
from nhtrack.ground import Ground
from nhtrack.section import Section, fault, is_bounded
from nhtrack.similarity import rounded_up


def _no_degrees(value: Any) -> Any:
    if is_bounded(value) and 2 <= value < 90:
        raise fault(f"expected less than pi/2 rad, got {value:g}; {value:g} degrees are {math.radians(value):.4g} rad")
    return value


class SlopeSection(Section):
    """An inclined floor. Poses are given in its plane; its normal is what robots take for upwards."""

    angle: Annotated[float, BeforeValidator(_no_degrees)] = Field(
        default=0.0, ge=0, lt=math.pi / 2, description="angle with the horizontal [rad]"
    )
    uphill: float = Field(default=0.0, description="direction in which the floor rises, from the x axis [rad]")


@dataclass(frozen=True)
class Slope(Effect):
    """An inclined floor.

    Attributes:
        angle: with the horizontal [rad].
        uphill: direction in which the floor rises, from the x axis [rad].
    """

    angle: float
    uphill: float = 0.0

    key: ClassVar[str] = "slope"
    field: ClassVar[tuple[Any, Any]] = (SlopeSection, Field(default=SlopeSection(), description="an inclined floor"))

    @classmethod
    def of(cls, value: SlopeSection, length: float) -> Self | None:
        """Returns the slope, an angle in any units."""
        return cls(value.angle, value.uphill) if value.angle else None

    def ground(self, ground: Ground) -> Ground:
        """Returns the ground inclined."""
        return replace(ground, slope=self.angle, uphill=self.uphill)

    def warnings(self, robots: RobotsAtRest) -> Iterator[str]:
        """Yields that robots slide or tip where they begin."""
        places = {"physics.friction": robots.ground.friction}
        places |= {f"physics.patches[{i}].friction": robots.ground.patches[i].friction for i in robots.met}
        for key, friction in places.items():
            if self.angle > math.atan(friction):
                holds = rounded_up(math.tan(self.angle), 3)
                yield (
                    f"{key} {friction:g} holds up to {math.atan(friction):.3g} rad, and physics.slope.angle is "
                    f"{self.angle:.3g}: nothing there stays where it is; {holds:g} would hold it"
                )
        if robots.plant.levelled:
            return
        loads = robots.plant.support_loads(robots.ground.gravity_at(robots.heading))
        for place, name in enumerate(robots.names):
            least, part = min((float(load[place]), part) for part, load in loads.items())
            if least < 0:
                yield f"{name} starts on a slope too steep to stand on: held there, it would lift its {part}"
