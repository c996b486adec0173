"""A base that is held level: three slides and a vertical hinge instead of a free joint, for large sweeps."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

from pydantic import Field

from nhtrack.effects.contract import Effect

if TYPE_CHECKING:
    from nhtrack.robots.contract import Parts
    from nhtrack.robots.diff_drive import DiffDrive


@dataclass(frozen=True)
class PlanarBase(Effect):
    """A base that cannot lean: each wheel bears half the weight, casters none."""

    key: ClassVar[str] = "base"
    field: ClassVar[tuple[Any, Any]] = (
        Literal["free", "planar"],
        Field(
            default="free",
            description="`free`: a body on two wheels and a caster that can tip; `planar`: held level, each wheel "
            "bearing half the weight, for large sweeps",
        ),
    )
    holds_level: ClassVar[bool] = True

    @classmethod
    def of(cls, value: Literal["free", "planar"], length: float) -> Self | None:
        """Returns the planar base, or None for a free one."""
        return cls() if value == "planar" else None

    def model(self, model: DiffDrive) -> DiffDrive:
        """Returns the reduced model held level."""
        return replace(model, levelled=True)

    def edit_robot(self, robot: Any, parts: Parts, model: DiffDrive) -> None:
        """Lets casters touch nothing, and those that swivel stand still where they trail."""
        for name in parts.casters:
            geom = robot.find("geom", name)
            geom.contype = geom.conaffinity = 0
        for name in parts.rolling_casters:
            body = robot.find("geom", name).parent
            while body.name != parts.chassis:
                for joint in list(body.get_children("joint")):
                    joint.remove()
                body = body.parent

    def edit_frame(self, frame: Any) -> None:
        """Puts slides and a hinge in place of the free joint; heights then count from the axle's."""
        frame.get_children("freejoint").remove()
        frame.pos = (0, 0, 0)
        for name, axis in (("root", (1, 0, 0)), ("y", (0, 1, 0)), ("z", (0, 0, 1))):
            frame.add("joint", name=name, type="slide", axis=axis)
        frame.add("joint", name="yaw", type="hinge", axis=(0, 0, 1))
