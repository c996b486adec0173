"""What every robot carries: a box of uniform density, fixed to its chassis."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self, TypeAlias

import numpy as np
from pydantic import Field

from nhtrack.effects.contract import Effect, Setting
from nhtrack.section import Finding, Point, Section, values_of

if TYPE_CHECKING:
    from nhtrack.robots.contract import Parts
    from nhtrack.robots.diff_drive import DiffDrive

Edge: TypeAlias = Annotated[float, Field(ge=0)]
Edges: TypeAlias = Annotated[tuple[Edge, Edge, Edge], Field(strict=False), values_of("x", "y", "z")]


class PayloadSection(Section):
    """A box of uniform density that every robot carries; robot units, since robots do not scale."""

    mass: float = Field(gt=0, description="its mass [kg]")
    offset: Point = Field(
        default=(0.0, 0.0), description="its centre in the robot's frame: x ahead of the axle, y left of it [m]"
    )
    height: float = Field(ge=0, description="height of its centre above the floor [m]")
    size: Edges = Field(default=(0.0, 0.0, 0.0), description="its edges along x, y, z [m]; zeros make it a point")


@dataclass(frozen=True)
class Payload(Effect):
    """A box of uniform density that every robot carries.

    Attributes:
        mass: [kg].
        position: its centre, x and y in the chassis frame and height above the floor [m].
        size: its edges [m]; zeros for a point.
    """

    mass: float
    position: tuple[float, float, float]
    size: tuple[float, float, float] = (0.0, 0.0, 0.0)

    key: ClassVar[str] = "payload"
    field: ClassVar[tuple[Any, Any]] = (
        PayloadSection | None,
        Field(default=None, description="what every robot carries"),
    )
    weighs: ClassVar[bool] = True

    @classmethod
    def of(cls, value: PayloadSection | None, length: float) -> Self | None:
        """Returns the payload, which is in robot units already."""
        return None if value is None else cls(value.mass, (*value.offset, value.height), value.size)

    def edit_robot(self, robot: Any, parts: Parts, model: DiffDrive) -> None:
        """Adds the box to the chassis, called `payload` where the robot has no such part itself."""
        name = "payload"
        while robot.find("body", name) is not None or robot.find("geom", name) is not None:
            name += "_"
        x, y, height = self.position
        size = np.asarray(self.size) / 2
        inertia = self.mass / 3 * (size @ size - size**2)
        body = robot.find("body", parts.chassis).add("body", name=name, pos=(x, y, height - model.wheel_radius))
        body.add("inertial", pos=(0, 0, 0), mass=self.mass, diaginertia=inertia)
        drawn = np.maximum(size, 1e-3)
        look = {"rgba": (0.72, 0.55, 0.35, 1), "contype": 0, "conaffinity": 0, "group": 2}
        body.add("geom", name=name, type="box", size=drawn, **look)

    def findings(self, setting: Setting) -> Iterator[Finding]:
        """Yields that it reaches into the floor, or tips its robot."""
        _, _, height = self.position
        if height < self.size[2] / 2:
            yield (
                ("height",),
                f"a payload {self.size[2]:g} m high with its centre {height:g} m above the floor reaches into it",
            )
        elif not setting.holds_level:
            yield from _tipping(setting.plant())


def _tipping(plant: DiffDrive) -> Iterator[Finding]:
    lifted = [name for name, load in plant.support_loads().items() if load <= 0]
    if lifted:
        x, y = plant.com[:2]
        yield (
            (),
            f"it tips the robot: with it the centre of mass lies at ({x:.3g}, {y:.3g}) m from the axle's middle, "
            f"outside wheels and caster, and the {' and the '.join(lifted)} would lift",
        )
