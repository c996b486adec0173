"""The section `similarity`: from the units a file is written in to metres and seconds."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Discriminator, Field, Tag

from nhtrack.section import Section

TimeScale: TypeAlias = Annotated[
    Annotated[float, Field(gt=0), Tag("<time>")] | Annotated[Literal["auto"], Tag("<auto>")],
    Discriminator(lambda value: "<auto>" if isinstance(value, str) else "<time>"),
]


class SimilaritySection(Section):
    """Maps scenario units to the robot; robot and gravity do not scale, so this sets the friction demand."""

    length: float = Field(default=1.0, gt=0, description="robot metres per scenario length unit [m]")
    time: TimeScale = Field(
        default=1.0,
        description="robot seconds per scenario time unit [s]; `auto` takes the smallest at which, on the ideal model, "
        "friction stays within `friction_margin` and every motor within its limits",
    )
    friction_margin: float = Field(
        default=0.7,
        gt=0,
        le=1,
        description="share of the friction limit that `time: auto` and `nhtrack feasibility` let wheels use [1]",
    )

    @property
    def time_scale(self) -> float:
        """Robot seconds per scenario time unit.

        Raises:
            TypeError: the time is still `auto`; `nhtrack.studies.feasibility.run.with_time` makes it a number.
        """
        if self.time == "auto":
            raise TypeError("similarity.time: auto becomes a number by nhtrack.studies.feasibility.run.with_time")
        return self.time
