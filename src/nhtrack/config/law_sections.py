"""The section `law` of a file, made from what each law says of its gains."""

from __future__ import annotations

import dis
from collections.abc import Iterator, Mapping
from functools import cache, reduce
from operator import or_
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self, TypeAlias

from pydantic import (
    Discriminator,
    Field,
    ModelWrapValidatorHandler,
    SerializeAsAny,
    Tag,
    ValidationError,
    create_model,
    model_validator,
)
from pydantic_core import InitErrorDetails

from nhtrack.laws import Gain, LawError, LawKind, law_in, law_of_text, laws
from nhtrack.laws.contract import dimension
from nhtrack.laws.slots import slots_of
from nhtrack.laws.trial import trial_fault
from nhtrack.section import Section, fault
from nhtrack.similarity import Similarity

_FILE = "<file>"
_UNITS = {"L": "scenario length", "T": "scenario time"}


class MotionLimits(Section):
    """What a law may ask of a robot; robot units, since robots do not scale.

    The limits on velocities and accelerations follow from the robot's reduced model and the ground.
    """

    utilisation: float = Field(
        default=0.5, gt=0, le=1, description="share of the friction limit that wheels may use, as predicted [1]"
    )
    speed: float | None = Field(
        default=None, gt=0, description="largest speed [m/s]; null takes half of what the motors reach without load"
    )
    everywhere: bool = Field(
        default=False,
        description="whether the least friction of all patches counts; else of those where the leader drives, places "
        "go with it, or starts lead straight to them",
    )


class LawSection(Section):
    """A law with its gains in scenario units."""

    kind: ClassVar[LawKind]
    name: str = Field(description="which law")
    delay_periods: int = Field(
        default=0,
        ge=0,
        le=50,
        description="control periods by which the law is asked ahead, to make up for `delay`: its follower moved on by "
        "the commands under way, what it tracks by its accelerations and their last change [1]",
    )

    def gains(self, similarity: Similarity) -> dict[str, Any]:
        """Returns the gains in robot units, by the fields of the law's `Gains`; choices as their numbers."""
        return {name: _scaled(self._value(name, gain), gain, similarity) for name, gain in self.kind.described.items()}

    def robot_gain(self, name: str, similarity: Similarity, otherwise: float) -> float:
        """Returns a gain in robot units, or a number where the law has no such gain."""
        return float(self.gains(similarity)[name]) if name in self.kind.gains._fields else otherwise

    def _value(self, name: str, gain: Gain) -> Any:
        section = self if not gain.section else getattr(self, gain.section)
        value = getattr(section, _key(name, gain))
        return gain.choices.index(value) if gain.choices else value

    def __reduce__(self) -> tuple[Any, ...]:
        """Returns how to make the section anew in another process, where its class has to be made as well.

        A law of one's own takes its text along: its file may have changed by then.
        """
        return _remade, (self.model_dump(), self.kind.source if isinstance(self, FileLaw) else None)

    @model_validator(mode="after")
    def _tried(self) -> Self:
        """Calls a law that is not the package's own once, with its gains, before anything is run."""
        kind: LawKind | None = getattr(type(self), "kind", None)
        if kind is not None and not kind.built_in:
            limited = getattr(self, "limits", None) is not None
            said = trial_fault(kind(**self.gains(Similarity())), limited=limited)
            if said is not None:
                raise fault(said)
        return self


def _remade(tree: Mapping[str, Any], source: str | None) -> LawSection:
    if source is None:
        section = law_section(tree["name"])
    else:
        section = _section_of(law_of_text(Path(tree["file"]), source), own=True)
    return section.model_construct(**_inner(section, tree))


def _inner(section: type[LawSection], tree: Mapping[str, Any]) -> dict[str, Any]:
    """Returns a dumped tree with its own sections as such; numbers may be arrays, so nothing is judged."""
    values = dict(tree)
    for key, value in tree.items():
        if isinstance(value, Mapping):
            default = section.model_fields[key].get_default()
            values[key] = (MotionLimits if key == "limits" else type(default)).model_construct(**value)
    return values


def law_section(name: str) -> type[LawSection]:
    """Returns the section of a law that scenarios may name."""
    return _sections()[name]


def law_names() -> tuple[str, ...]:
    """Returns the names of the laws that scenarios may name."""
    return tuple(_sections())


def section_of_file(path: str | Path) -> type[LawSection]:
    """Returns the section of the law in a file.

    Raises:
        LawError: the file holds no law.
    """
    return _section_of(law_in(path), own=True)


@cache
def _sections() -> Mapping[str, type[LawSection]]:
    return {name: _section_of(kind, own=False) for name, kind in laws().items()}


@cache
def _section_of(kind: LawKind, *, own: bool) -> type[LawSection]:
    """Returns the section of a law, with a key for each gain; `own` where a file's path names it."""
    fields: dict[str, Any] = {}
    inner: dict[str, dict[str, Any]] = {}
    if own:
        fields["file"] = (str, Field(description="Python file of the law, relative to this file"))
        fields["name"] = (str, Field(default=kind.name, description="what tables call the law"))
    else:
        fields["name"] = (Literal[kind.name], Field(description="which law"))
    for name, gain in kind.described.items():
        place = inner.setdefault(gain.section, {}) if gain.section else fields
        place[_key(name, gain)] = _field(kind, name, gain)
    for section, keys in inner.items():
        model = _SHARED.get((section, tuple(keys))) or create_model(_camel(section), __base__=Section, **keys)
        fields[section] = (model, Field(default=model(), description="sizes below which a direction is noise"))
    if _looks_at_limits(kind):
        text = "keeps wheels and motors within their limits; null asks for whatever the gains do"
        fields["limits"] = (MotionLimits | None, Field(default=None, description=text))
    base = FileLaw if own else LawSection
    section_class = create_model(_camel(kind.name) + "Law", __base__=base, __doc__=kind.summary or kind.name, **fields)
    section_class.kind = kind
    return section_class


class DeadZone(Section):
    """Below these sizes the angles of a law are noise and count as zero; always in robot units."""

    length: float = Field(default=1e-6, ge=0, description="smallest |q| whose direction means anything [m]")
    speed: float = Field(default=1e-3, ge=0, description="smallest leader speed whose direction means anything [m/s]")


class PlaceDeadZone(Section):
    """Below this speed the direction of a place in a formation is noise; always in robot units."""

    speed: float = Field(default=1e-3, ge=0, description="smallest speed of a place that has a direction [m/s]")


# Sections inside a law's that several laws share.
_SHARED: Mapping[tuple[str, tuple[str, ...]], type[Section]] = {
    ("dead_zone", ("length", "speed")): DeadZone,
    ("dead_zone", ("speed",)): PlaceDeadZone,
}


def _key(name: str, gain: Gain) -> str:
    return name.removeprefix(f"{gain.section}_") if gain.section else name


def _field(kind: LawKind, name: str, gain: Gain) -> tuple[Any, Any]:
    """Returns type and description of a gain's key."""
    default = kind.gains._field_defaults.get(name, ...)
    if gain.choices:
        chosen = default if default is ... else gain.choices[int(default)]
        return Literal[gain.choices], Field(default=chosen, description=gain.doc or name)
    number = next(slot.kind for slot in slots_of(kind.gains) if slot.field == name)
    unit = "".join(_UNITS.get(letter, letter) for letter in gain.unit).replace("scenario length/scenario time", _SPEED)
    return (
        number,
        Field(
            default=number(default) if isinstance(default, (int, float)) else default,
            gt=gain.above,
            ge=gain.least,
            lt=gain.below,
            description=f"{gain.doc or name} [{unit}]",
        ),
    )


_SPEED = "scenario length/time"


def powers(unit: str) -> tuple[int, int]:
    """Returns the powers of length and time by which similarity scales a gain; none for robot units."""
    return (0, 0) if set(unit) & set("ms") else dimension(unit)


def _scaled(value: Any, gain: Gain, similarity: Similarity) -> Any:
    return value if gain.choices else similarity.scale(value, *powers(gain.unit))


def _looks_at_limits(kind: LawKind) -> bool:
    """Returns whether a law's command reads its argument of the robot's limits."""
    function: Any = getattr(kind.command, "py_func", kind.command)
    limits = function.__code__.co_varnames[2]
    return any(step.argval == limits or limits in _names(step.argval) for step in dis.get_instructions(function))


def _names(value: Any) -> Iterator[Any]:
    return iter(value) if isinstance(value, tuple) else iter(())


def _camel(name: str) -> str:
    return "".join(part[:1].upper() + part[1:] for part in name.split("_"))


class FileLaw(LawSection):
    """A law of one's own: a Python file, and the gains that it has."""

    file: str = Field(min_length=1, description="Python file of the law, relative to this file")
    name: str = Field(default="", description="what tables call the law; by default its file's name")

    @model_validator(mode="wrap")
    @classmethod
    def _of_its_file(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Judges the keys by the gains of the law in the file."""
        if cls is not FileLaw or isinstance(data, FileLaw) or not isinstance(data, Mapping):
            return handler(data)
        file = data.get("file")
        if not isinstance(file, str) or not file:
            return handler({key: data[key] for key in data if key == "file"})
        try:
            section = section_of_file(file)
        except LawError as error:
            lines = str(error).splitlines()
            problems = [InitErrorDetails(type=fault(line), loc=("file",), input=file) for line in lines]
            raise ValidationError.from_exception_data("law", problems, hide_input=True) from None
        return section.model_validate(data)  # type: ignore[return-value]


def _form(value: Any) -> str | None:
    """Returns which section of the union a value is meant for."""
    if isinstance(value, FileLaw) or (isinstance(value, Mapping) and "file" in value):
        return _FILE
    name = value.get("name") if isinstance(value, Mapping) else getattr(value, "name", None)
    return name if isinstance(name, str) else None


_Union: Any = reduce(
    or_, [Annotated[section, Tag(name)] for name, section in _sections().items()] + [Annotated[FileLaw, Tag(_FILE)]]
)
Law: TypeAlias = Annotated[SerializeAsAny[_Union], Discriminator(_form)]
