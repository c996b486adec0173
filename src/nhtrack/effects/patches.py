"""Regions of the floor with a friction of their own.

Friction is the tyre's: each physics step gives a tyre the coefficient of the place where it stands
(`nhtrack.ground.Ground.friction_at`). On the floor patches are only drawn.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar, Self, TypeAlias

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from nhtrack.colours import GRIP, ICE, rgb
from nhtrack.effects.contract import Effect
from nhtrack.ground import Ground, Patch
from nhtrack.section import Friction, Section, fault, values_of

_UNLIKE_FLOOR = 0.3  # change of friction at which a patch is drawn in full colour
_FLOOR = (0.65, 0.67, 0.70)  # colour of the floor, which fainter patches come nearer to
_HEIGHT = 3e-4  # [m] drawn above the floor, below trails; patches that overlap are stacked


def _disc(disc: tuple[float, float, float]) -> tuple[float, float, float]:
    if not disc[2] > 0:
        raise fault(f"expected a positive radius, got {disc[2]:g}")
    return disc


def _rectangle(sides: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
    x_min, x_max, y_min, y_max = sides
    if not (x_min < x_max and y_min < y_max):
        raise fault(f"expected x_min < x_max and y_min < y_max, got {list(sides)}")
    return sides


Disc: TypeAlias = Annotated[
    tuple[float, float, float], Field(strict=False), values_of("x", "y", "r"), AfterValidator(_disc)
]
Rectangle: TypeAlias = Annotated[
    tuple[float, float, float, float],
    Field(strict=False),
    values_of("x_min", "x_max", "y_min", "y_max"),
    AfterValidator(_rectangle),
]


class PatchSection(Section):
    """A region of the floor with a friction coefficient of its own: a disc or a rectangle."""

    friction: Friction = Field(description="Coulomb friction coefficient of wheels on it [1]; ice has about 0.05")
    disc: Disc | None = Field(default=None, description="its centre and radius, [x, y, r] [scenario length]")
    rectangle: Rectangle | None = Field(
        default=None, description="its sides, [x_min, x_max, y_min, y_max] [scenario length]"
    )

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        if (self.disc is None) == (self.rectangle is None):
            raise fault("expected either `disc` or `rectangle`")
        return self

    def scaled(self, length: float) -> Patch:
        """Returns the patch in robot units."""
        disc = None if self.disc is None else (length * self.disc[0], length * self.disc[1], length * self.disc[2])
        if self.rectangle is None:
            return Patch(self.friction, disc=disc)
        x_min, x_max, y_min, y_max = self.rectangle
        return Patch(self.friction, (length * x_min, length * x_max, length * y_min, length * y_max), disc)


@dataclass(frozen=True)
class Patches(Effect):
    """Regions of the floor; where they overlap the last one counts."""

    patches: tuple[Patch, ...]

    key: ClassVar[str] = "patches"
    field: ClassVar[tuple[Any, Any]] = (
        Annotated[tuple[PatchSection, ...], Field(strict=False)],
        Field(
            default=(),
            description="regions with a friction of their own, such as ice; where they overlap the last counts",
        ),
    )

    @classmethod
    def of(cls, value: tuple[PatchSection, ...], length: float) -> Self | None:
        """Returns the patches, whose places scale with length."""
        return cls(tuple(patch.scaled(length) for patch in value)) if value else None

    def ground(self, ground: Ground) -> Ground:
        """Returns the ground with the patches on it."""
        return replace(ground, patches=(*ground.patches, *self.patches))

    def edit_arena(self, arena: Any, ground: Ground) -> None:
        """Draws the patches flat on the floor."""
        for index, patch in enumerate(self.patches):
            _draw(arena, f"patch_{index}", patch, ground.friction, (index + 1) * _HEIGHT)


def _draw(arena: Any, name: str, patch: Patch, floor: float, height: float) -> None:
    """Draws a patch, bluish where it is slippier than the floor and brown where it grips more."""
    unlike = 0.3 + 0.7 * min(1.0, abs(patch.friction - floor) / _UNLIKE_FLOOR)
    mixed = unlike * np.array(rgb(ICE if patch.friction < floor else GRIP)) + (1 - unlike) * np.array(_FLOOR)
    matt = arena.asset.add("material", name=name, rgba=(*mixed, 1), specular=0, shininess=0)
    look = {"name": name, "material": matt, "contype": 0, "conaffinity": 0, "group": 2}
    if patch.disc is not None:
        x, y, radius = patch.disc
        arena.worldbody.add("geom", type="cylinder", size=(radius, height / 2), pos=(x, y, height / 2), **look)
    elif patch.rectangle is not None:
        x_min, x_max, y_min, y_max = patch.rectangle
        size, centre = ((x_max - x_min) / 2, (y_max - y_min) / 2), ((x_min + x_max) / 2, (y_min + y_max) / 2)
        arena.worldbody.add("geom", type="box", size=(*size, height / 2), pos=(*centre, height / 2), **look)
