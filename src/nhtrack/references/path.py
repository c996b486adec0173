"""The leader's input as a path: a curve by formulas, or waypoints with limits."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal, Self, TypeAlias

import numpy as np
from pydantic import Discriminator, Field, Tag, ValidationError, model_validator

from nhtrack.references.contract import ReferenceInputError
from nhtrack.references.curve import Curve
from nhtrack.references.expression import make_signal
from nhtrack.references.motion import Motion, MotionInput
from nhtrack.references.moves import Pace, make_moves, moves_motion
from nhtrack.references.route import Bounds, Route
from nhtrack.references.signals import Formula
from nhtrack.section import Finding, Point, Section, fault, values_of

Waypoint: TypeAlias = Annotated[Point, values_of("x", "y")]

Coordinate: TypeAlias = Annotated[
    Annotated[float, Tag("<number>")] | Annotated[Formula, Tag("<formula>")],
    Discriminator(lambda value: "<formula>" if isinstance(value, str) else "<number>"),
]

_SAME = 1e-6  # distance of waypoints that are one, as a share of what they span


class CurveSection(Section):
    """A curve by formulas in the time; the leader drives along it forwards, and backwards after a cusp."""

    x: Coordinate = Field(description="a number, or a formula in t, the time of the scenario [scenario length]")
    y: Coordinate = Field(description="a number, or a formula in t [scenario length]")

    def curve(self) -> Curve:
        """Returns the curve, in scenario units."""
        return Curve(make_signal(self.x), make_signal(self.y))

    def motion(self) -> Motion:
        """Returns the motion along it."""
        return self.curve().motion()


class WaypointsSection(Section):
    """Waypoints that the leader drives through, from rest to rest, as fast as limits allow."""

    waypoints: Annotated[tuple[Waypoint, ...], Field(strict=False)] = Field(
        description="x, y of each, two at least, in order; it begins at the first [scenario length]"
    )
    speed: float = Field(gt=0, description="largest speed [scenario length/time]")
    acceleration: float = Field(gt=0, description="of speeding up and braking [scenario length/time^2]")
    corner: Literal["smooth", "stop-and-turn"] = Field(
        default="smooth",
        description="`smooth`: a line of continuous curvature through the waypoints; `stop-and-turn`: straight lines, "
        "and turns on the spot",
    )
    closed: bool = Field(default=False, description="whether the last is joined to the first")
    laps: int = Field(default=1, ge=1, le=1000, description="how often a closed path is gone round [1]")
    curvature: float | None = Field(
        default=None, gt=0, description="a smooth line that bends more is refused; null: any [rad/scenario length]"
    )
    lateral_acceleration: float | None = Field(
        default=None, gt=0, description="slows a smooth line's bends; null: does not [scenario length/time^2]"
    )
    yaw_rate: float | None = Field(
        default=None, gt=0, description="largest; null: any on a smooth line, 1 on the spot [rad/scenario time]"
    )
    yaw_acceleration: float = Field(default=1.0, gt=0, description="in turns on the spot [rad/scenario time^2]")
    pause: float = Field(
        default=0.0, ge=0, description="how long it stands at a waypoint before it turns on the spot [scenario time]"
    )

    @model_validator(mode="after")
    def _fits(self) -> Self:
        needed = 3 if self.closed else 2
        if len(self.waypoints) < needed:
            raise fault(f"expected at least {needed} waypoints, got {len(self.waypoints)}")
        if self.laps > 1 and not self.closed:
            raise fault("only a closed path can have several laps")
        return self

    def faults(self) -> Iterator[tuple[int, str]]:
        """Yields which waypoint cannot be driven through as wanted, counted from 0, and why."""
        span = float(np.ptp(self.waypoints, axis=0).max())
        around = [*self.waypoints, self.waypoints[0]] if self.closed else list(self.waypoints)
        for i, (before, here) in enumerate(pairwise(around), start=1):
            if math.dist(before, here) <= _SAME * span:
                yield i % len(self.waypoints), "the same place as the waypoint before it; leave one out"
                return
        sharpest, where = self._route().sharpest() if self.corner == "smooth" else (0.0, 0)
        if sharpest == math.inf or sharpest > (self.curvature or math.inf):
            bends = f"bends by {sharpest:.3g}" if sharpest < math.inf else "turns as good as on the spot"
            allowed = f", more than the {self.curvature:g} allowed" if self.curvature else ""
            yield (
                where % len(self.waypoints),
                f"the line through the waypoints {bends} near here{allowed}: move them apart, or let it stop and turn "
                "(corner: stop-and-turn)",
            )

    def _route(self) -> Route:
        return Route.through(np.array(self.waypoints), self.closed)

    def motion(self) -> Motion:
        """Returns the motion through the waypoints.

        Raises:
            ReferenceInputError: there is none, see `faults`.
        """
        if found := next(self.faults(), None):
            raise ReferenceInputError(f"waypoint {found[0] + 1}: {found[1]}")
        if self.corner == "stop-and-turn":
            drive, turn = Pace(self.speed, self.acceleration), Pace(self.yaw_rate or 1.0, self.yaw_acceleration)
            points = np.array(self.waypoints)
            return moves_motion(make_moves(points, self.laps, self.closed, drive, turn, self.pause))
        limits = Bounds(
            self.speed, self.acceleration, self.lateral_acceleration or math.inf, self.yaw_rate or math.inf
        )
        route = self._route()
        return (route.times(self.laps) if self.closed else route).motion(limits)


def _has_waypoints(given: Any) -> bool:
    return "waypoints" in given if isinstance(given, Mapping) else hasattr(given, "waypoints")


class PathInput(MotionInput):
    """The leader's input as a path, from which its heading, its velocities and its accelerations follow."""

    key: ClassVar[str] = "path"
    words: ClassVar[str] = "a path"
    path: Annotated[
        Annotated[CurveSection, Tag("<curve>")] | Annotated[WaypointsSection, Tag("<waypoints>")],
        Discriminator(lambda given: "<waypoints>" if _has_waypoints(given) else "<curve>"),
    ] = Field(description="a curve by formulas, or waypoints")

    def reference(self) -> Motion:
        """Returns the motion along the path, in scenario units."""
        return self.path.motion()

    @classmethod
    def findings(cls, given: Mapping[str, Any], times: np.ndarray | None) -> Iterator[Finding]:
        """Yields what no unicycle follows, and what `MotionInput.findings` does."""
        try:
            path = cls.model_validate(given).path
        except ValidationError:
            return  # the section's own fault, told by its model
        if isinstance(path, WaypointsSection):
            faults: list[Finding] = [(("path", "waypoints", i), message) for i, message in path.faults()]
            yield from faults or super().findings(given, times)
            return
        found = list(super().findings(given, times))
        yield from found
        if not found and times is not None:
            try:
                yield from ((("path",), message) for message in path.curve().faults(np.insert(times, 0, 0.0)))
            except ReferenceInputError as error:
                yield ("path",), str(error)
