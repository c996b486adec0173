"""What a campaign file may say of a reference: two signals, any input of a leader, or signals over a grid."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import product
from typing import Annotated, Any, Self, TypeAlias

from pydantic import (
    AfterValidator,
    Discriminator,
    Field,
    ModelWrapValidatorHandler,
    Tag,
    TypeAdapter,
    ValidationError,
    model_validator,
)
from pydantic_core import InitErrorDetails

from nhtrack.config.families import DRAWN, FAMILIES, QUICK, SETS
from nhtrack.config.grid import Grid, Template, filled, first_value, numbers_of, words_of
from nhtrack.config.robots import Start
from nhtrack.config.values import Name, PlanarTwist
from nhtrack.errors import did_you_mean
from nhtrack.references import (
    VOCABULARY,
    Expression,
    Input,
    InputSection,
    ReferenceInputError,
    SignalInput,
    SignalValue,
    input_words,
)
from nhtrack.section import Section, fault


@dataclass(frozen=True)
class FamilyLeader:
    """The leader of a family, or of a point of a grid.

    Attributes:
        name: how tables call it.
        input: as a scenario has it.
        start: where it begins; a disc around it holds the followers.
        grid: name of the family it is a point of, empty where it is none.
        values: of the grid's numbers, by their names.
    """

    name: str
    input: InputSection
    start: Start
    grid: str = ""
    values: Mapping[str, float] = field(default_factory=dict)


class Family(Section):
    """A reference by two signals: what the leader does, from the origin on, along x."""

    name: Name = Field(description="how tables call it")
    u_x: SignalValue = Field(description="forward acceleration [scenario length/time^2]")
    u_theta: SignalValue = Field(description="angular acceleration [rad/scenario time^2]")
    twist: PlanarTwist = Field(
        default=(0.0, 0.0), description="v [scenario length/time] and omega [rad/scenario time] at the start"
    )

    @property
    def names(self) -> tuple[str, ...]:
        """Its name alone."""
        return (self.name,)

    def leader(self, name: str) -> FamilyLeader:
        """Returns its leader."""
        start = Start(pose=(0.0, 0.0, 0.0), twist=self.twist)
        return FamilyLeader(name, SignalInput(u_x=self.u_x, u_theta=self.u_theta), start)


class InputFamily(Section):
    """A reference by any input that the leader of a scenario may have; followers start around where it begins."""

    name: Name = Field(description="how tables call it")
    input: Input = Field(description=f"the leader's accelerations over time: {input_words()}")

    @property
    def names(self) -> tuple[str, ...]:
        """Its name alone."""
        return (self.name,)

    def leader(self, name: str) -> FamilyLeader:
        """Returns its leader, which begins where the input says, else at the origin, along x, at rest."""
        pose, twist = self.input.start() or (None, (0.0, 0.0))
        return FamilyLeader(name, self.input, Start(pose=pose or (0.0, 0.0, 0.0), twist=twist))


class GridFamily(Section):
    """References over a grid of one or two numbers: each point is a family of its own, and all of them make a map."""

    name: Name = Field(description="how tables call it; a point is called by it and its numbers")
    grid: Grid = Field(
        description="one or two names and the numbers each stands for: a list of them, or a range; gains that are to "
        "be tuned are tuned at the point in the middle"
    )
    u_x: Template = Field(
        description="forward acceleration, a number or a formula in t and the names [scenario length/time^2]"
    )
    u_theta: Template = Field(
        description="angular acceleration, a number or a formula in t and the names [rad/scenario time^2]"
    )
    twist: Annotated[tuple[Template, Template], Field(strict=False)] = Field(
        default=(0.0, 0.0),
        description="v [scenario length/time] and omega [rad/scenario time] at the start: numbers, or formulas in the "
        "names at t = 0",
    )
    labels: dict[str, str] = Field(
        default={}, description="what the axes of the map say, with units, by the names; a name says itself otherwise"
    )

    @property
    def points(self) -> dict[str, dict[str, float]]:
        """Values of the grid's names at each point, by the name of the point; the last name runs fastest."""
        rows = product(*(numbers_of(values) for values in self.grid.values()))
        points = [dict(zip(self.grid, row, strict=True)) for row in rows]
        return {self._called(at): at for at in points}

    def _called(self, at: Mapping[str, float]) -> str:
        return " ".join([self.name, *(f"{key}={value:.12g}" for key, value in at.items())])

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all points."""
        return tuple(self.points)

    @property
    def middle(self) -> str:
        """Name of the point in the middle, at which gains are tuned."""
        middles = (values[len(values) // 2] for values in map(numbers_of, self.grid.values()))
        return self._called(dict(zip(self.grid, middles, strict=True)))

    @property
    def corners(self) -> tuple[str, ...]:
        """Names of the points at which each number is its least or its largest."""
        ends = ((values[0], values[-1]) for values in map(numbers_of, self.grid.values()))
        return tuple(dict.fromkeys(self._called(dict(zip(self.grid, at, strict=True))) for at in product(*ends)))

    def leader(self, name: str) -> FamilyLeader:
        """Returns the leader of a point."""
        at = self.points[name]
        signals = SignalInput(u_x=filled(self.u_x, at), u_theta=filled(self.u_theta, at))
        v, omega = (first_value(filled(part, at)) for part in self.twist)
        return FamilyLeader(name, signals, Start(pose=(0.0, 0.0, 0.0), twist=(v, omega)), self.name, at)

    @model_validator(mode="wrap")
    @classmethod
    def _judge_formulas(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Says of each formula by itself which name it lacks, or that it is none."""
        family = handler(data)
        if found := list(family._faults()):
            details = [InitErrorDetails(type=fault(text), loc=loc, input=None) for loc, text in found]
            raise ValidationError.from_exception_data(cls.__name__, details, hide_input=True)
        return family

    def _faults(self) -> Iterator[tuple[tuple[str | int, ...], str]]:
        formulas: dict[tuple[str | int, ...], Any] = {("u_x",): self.u_x, ("u_theta",): self.u_theta}
        formulas |= {("twist", i): part for i, part in enumerate(self.twist)}
        points, known = list(self.points.values()), (*self.grid, *VOCABULARY)
        used = set[str]()
        for loc, formula in formulas.items():
            if not isinstance(formula, str):
                continue
            words = words_of(formula)
            used.update(words)
            unknown = next((word for word in words if word not in known), None)
            if unknown is not None:
                yield loc, f"unknown name {unknown!r}; {did_you_mean(unknown, known)}"
                continue
            try:
                Expression(str(filled(formula, points[0])))
                for at in points if loc[0] == "twist" else ():
                    first_value(filled(formula, at))
            except ReferenceInputError as error:
                yield loc, str(error)
        for name in self.grid:
            if name not in used:
                yield ("grid", name), "no formula has this name"
        for name in self.labels:
            if name not in self.grid:
                yield ("labels", name), f"no such name in the grid; {did_you_mean(name, tuple(self.grid))}"


def _bundled_family(name: str) -> str:
    bundled = (*FAMILIES, *QUICK, *DRAWN, *SETS)
    if name not in bundled:
        raise fault(f"no family {name!r}; {did_you_mean(name, bundled)}")
    return name


def _form(value: Any) -> str:
    if isinstance(value, str):
        return "<family name>"
    keys = value if isinstance(value, Mapping) else vars(value) if isinstance(value, Section) else ()
    return "<family over a grid>" if "grid" in keys else "<family by input>" if "input" in keys else "<family>"


OwnFamily: TypeAlias = Family | InputFamily | GridFamily
FamilyChoice: TypeAlias = Annotated[
    Annotated[str, AfterValidator(_bundled_family), Tag("<family name>")]
    | Annotated[Family, Tag("<family>")]
    | Annotated[InputFamily, Tag("<family by input>")]
    | Annotated[GridFamily, Tag("<family over a grid>")],
    Discriminator(_form),
]
_CHOICE: TypeAdapter[Any] = TypeAdapter(FamilyChoice)


def bundled_leader(name: str) -> FamilyLeader:
    """Returns the leader of a bundled family that is no other for every start."""
    family = _CHOICE.validate_python({"name": name, **{**FAMILIES, **QUICK}[name]})
    found: FamilyLeader = family.leader(name)
    return found
