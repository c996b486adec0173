"""The sections `leader` and `followers`: who moves, from where, and who tracks whom."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import Field

from nhtrack.config.values import Name, PlanarTwist, Pose
from nhtrack.references import Input, input_words
from nhtrack.section import Point, Section

Weight: TypeAlias = Annotated[float, Field(ge=0, le=1)]


class Start(Section):
    """Where a robot is at t = 0 and how it moves."""

    pose: Pose = Field(description="x, y [scenario length], theta [rad, unwrapped: pi and -pi are different starts]")
    twist: PlanarTwist = Field(
        default=(0.0, 0.0),
        description="forward speed v [scenario length/time] and turning speed omega [rad/scenario time]",
    )


class LeaderSection(Section):
    """The root of the network: drives open loop by its own input, on real wheels unless virtual."""

    name: Name = Field(default="leader", description="how followers and results call it")
    virtual: bool = Field(
        default=False, description="true: a moving marker that follows the input exactly, instead of a robot"
    )
    start: Start = Field(
        default=Start(pose=(0.0, 0.0, 0.0)),
        description="where it begins; left out, where its input says, else at the origin, heading along x, at rest",
    )
    input: Input = Field(description=f"its accelerations over time: {input_words()}")


class FollowerSection(Section):
    """A robot that tracks others."""

    name: Name = Field(description="how others and results call it")
    parents: Annotated[tuple[Name, ...], Field(strict=False, min_length=1)] = Field(
        description="the robots it tracks, by name; several are folded, in this order, into one virtual leader"
    )
    weights: Annotated[tuple[Weight, ...], Field(strict=False)] | None = Field(
        default=None,
        description="lambda of each fold, one fewer than the parents: 0 keeps what is folded so far, 1 takes the next "
        "parent; null gives every parent the same share [1]",
    )
    offset: Point = Field(
        default=(0.0, 0.0),
        description="its place in the frame of its (virtual) leader: x ahead, y left [scenario length]",
    )
    start: Start = Field(description="where it begins")
