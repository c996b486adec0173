"""The section `physics`: how MuJoCo steps, and what the robots are up against."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self, TypeAlias

from pydantic import AfterValidator, Field, model_validator

from nhtrack.section import Point, Section, counted, fault


def _disc(disc: tuple[float, float, float]) -> tuple[float, float, float]:
    if not disc[2] > 0:
        raise fault(f"expected a positive radius, got {disc[2]:g}")
    return disc


def _rectangle(sides: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
    x_min, x_max, y_min, y_max = sides
    if not (x_min < x_max and y_min < y_max):
        raise fault(f"expected x_min < x_max and y_min < y_max, got {list(sides)}")
    return sides


Edge: TypeAlias = Annotated[float, Field(ge=0)]
Disc: TypeAlias = Annotated[
    tuple[float, float, float], Field(strict=False), counted("x", "y", "r"), AfterValidator(_disc)
]
Rectangle: TypeAlias = Annotated[
    tuple[float, float, float, float],
    Field(strict=False),
    counted("x_min", "x_max", "y_min", "y_max"),
    AfterValidator(_rectangle),
]
Edges: TypeAlias = Annotated[tuple[Edge, Edge, Edge], Field(strict=False), counted("x", "y", "z")]


class Contact(Section):
    """How wheels meet the floor."""

    model: Literal["stiff", "default"] = Field(
        default="stiff",
        description="`stiff` derives the contact parameters from the time step, so that turning slip "
        "vanishes with it; `default` keeps MuJoCo's own, which slip by centimetres per second",
    )
    rate_correction: bool = Field(
        default=True,
        description="supplies the term MuJoCo's contact rows leave out, as a bias inside the friction cone: "
        "it gives no grip on ice",
    )


class PatchSection(Section):
    """A region of the floor with a friction coefficient of its own: a disc or a rectangle."""

    friction: float = Field(ge=0, description="Coulomb friction coefficient of wheels on it [1]; ice has about 0.05")
    disc: Disc | None = Field(default=None, description="its centre and radius, [x, y, r] [scenario length]")
    rectangle: Rectangle | None = Field(
        default=None, description="its sides, [x_min, x_max, y_min, y_max] [scenario length]"
    )

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        if (self.disc is None) == (self.rectangle is None):
            raise fault("expected either `disc` or `rectangle`")
        return self


class SlopeSection(Section):
    """An inclined floor. Poses are given in its plane; its normal is what robots take for upwards."""

    angle: float = Field(default=0.0, ge=0, lt=math.pi / 2, description="angle with the horizontal [rad]")
    uphill: float = Field(default=0.0, description="direction in which the floor rises, from the x axis [rad]")


class PayloadSection(Section):
    """A box of uniform density that every robot carries; robot units, since robots do not scale."""

    mass: float = Field(gt=0, description="its mass [kg]")
    offset: Point = Field(
        default=(0.0, 0.0), description="its centre in the robot's frame: x ahead of the axle, y left of it [m]"
    )
    height: float = Field(ge=0, description="height of its centre above the floor [m]")
    size: Edges = Field(default=(0.0, 0.0, 0.0), description="its edges along x, y, z [m]; zeros make it a point")


class MotorsSection(Section):
    """Limits of the wheel motors, in place of the robot's own; robot units."""

    torque_limit: float | None = Field(
        default=None, gt=0, description="largest torque at a wheel [N m]; null keeps the robot's own"
    )
    no_load_speed: float | None = Field(
        default=None, gt=0, description="wheel speed at which a motor gives no torque [rad/s]; null keeps the robot's"
    )


class Physics(Section):
    """How MuJoCo steps, and what the robots are up against."""

    timestep: float = Field(default=0.001, ge=1e-6, le=0.1, description="physics step on the robot's clock [s]")
    friction: float = Field(default=1.0, ge=0, description="Coulomb friction coefficient of wheels and floor [1]")
    patches: Annotated[tuple[PatchSection, ...], Field(strict=False)] = Field(
        default=(), description="regions with a friction of their own, such as ice; where they overlap the last counts"
    )
    slope: SlopeSection = Field(default=SlopeSection(), description="an inclined floor")
    payload: PayloadSection | None = Field(default=None, description="what every robot carries")
    wheel_mismatch: float = Field(
        default=0.0,
        gt=-0.5,
        lt=0.5,
        description="how much larger the left wheel is than the right one, over the nominal radius [1]",
    )
    motors: MotorsSection = Field(default=MotorsSection(), description="limits of the wheel motors")
    compensation: Literal["nominal", "actual"] = Field(
        default="nominal",
        description="what wheel torques are computed for: `nominal`, the robot as its file has it on a level floor; "
        "`actual`, its payload and the slope as well",
    )
    base: Literal["free", "planar"] = Field(
        default="free",
        description="`free`: a body on two wheels and a caster that can tip; `planar`: held level, each wheel bearing "
        "half the weight, for large sweeps",
    )
    robot_contact: bool = Field(
        default=False,
        description="whether robots collide: off where followers end in the leader's place, on in formations",
    )
    contact: Contact = Field(default=Contact(), description="how wheels meet the floor")
