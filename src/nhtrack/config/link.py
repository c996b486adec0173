"""What lies between robots and their laws: commands that arrive late, and a pose that is seen with noise."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, TypeAlias

from pydantic import Field

from nhtrack.config.law_sections import LawSection
from nhtrack.section import Section

Delay: TypeAlias = Annotated[
    int,
    Field(
        ge=0,
        le=1000,
        description="control periods by which what a law commands reaches its follower late; until then it keeps its "
        "velocities. The leader takes its input at once [1]",
    ),
]


class Noise(Section):
    """Standard deviations of what a follower's law sees amiss of its own robot.

    Normally distributed, independent, anew in every control period; what others see of the robot has none.
    """

    position: float = Field(default=0.0, ge=0, description="of x and of y, each [scenario length]")
    heading: float = Field(default=0.0, ge=0, description="of the heading [rad]")
    speed: float = Field(default=0.0, ge=0, description="of the forward velocity [scenario length/time]")
    turning: float = Field(default=0.0, ge=0, description="of the yaw rate [rad/scenario time]")


def delay_warnings(delay: int, law: LawSection, at: str = "law") -> Iterator[str]:
    """Yields that a law predicts another delay than there is, in a sentence.

    Args:
        delay: control periods by which commands arrive late.
        law: that is asked for them.
        at: its key in the file.
    """
    if law.delay_periods != delay:
        yield (
            f"{at}.delay_periods is {law.delay_periods} and `delay` is {delay}: the law is asked for another instant "
            "than that at which its commands arrive"
        )
