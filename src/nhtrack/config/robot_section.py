"""The section `robot`: which robot, and what its file cannot say itself; a text is the file alone."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias, get_args

from pydantic import BeforeValidator, Field, SerializerFunctionWrapHandler, model_serializer

from nhtrack.robots.contract import Hints
from nhtrack.section import Section

Joint: TypeAlias = Annotated[str, Field(min_length=1)]
Forward: TypeAlias = Literal["", "x", "-x", "y", "-y"]
#: Axes of a robot's base that may point ahead; empty to read which does.
FORWARD: tuple[str, ...] = get_args(Forward)


class RobotSection(Section):
    """A robot's file, and what that cannot say itself."""

    file: str = Field(
        min_length=1,
        description="a bundled robot, or a file relative to this one: MJCF (`.xml`, `.mjcf`), URDF (`.urdf`), or a "
        "folder with one of them",
    )
    wheels: Annotated[tuple[Joint, ...], Field(strict=False)] = Field(
        default=(), description="joints of the two driven wheels, for a file without actuators, such as a URDF"
    )
    casters: Annotated[tuple[Joint, ...], Field(strict=False)] = Field(
        default=(), description="joints of wheels that are not driven and slide on the floor as ball casters do"
    )
    forward: Forward = Field(
        default="", description="the axis of the file's base that points ahead; empty reads it from the wheels"
    )
    pose: str = Field(
        default="", description="the key whose joint angles arms are held at; empty for `home`, the only one, or zero"
    )

    @property
    def hints(self) -> Hints:
        """What the file cannot say itself."""
        return Hints(self.wheels, self.casters, self.forward, self.pose)

    @model_serializer(mode="wrap")
    def _short(self, handler: SerializerFunctionWrapHandler) -> Any:
        """Returns the file alone where nothing else is said."""
        return handler(self) if self.hints != Hints() else self.file


def _section(value: Any) -> Any:
    return {"file": value} if isinstance(value, str) else value


#: A robot by its name or file, or the section that says more of it.
RobotChoice: TypeAlias = Annotated[RobotSection, BeforeValidator(_section, json_schema_input_type=str | RobotSection)]
