"""What all sections of a scenario or campaign file have in common, wherever in the package they are defined."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Annotated, Any, Self, TypeAlias

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ModelWrapValidatorHandler,
    ValidationError,
    model_validator,
)
from pydantic_core import ErrorDetails, InitErrorDetails, PydanticCustomError

from nhtrack.errors import did_you_mean

# YAML lists become tuples, which stay frozen; only the container is converted, never what is in it.
Point: TypeAlias = Annotated[tuple[float, float], Field(strict=False)]
LARGEST = 1e12  # magnitude of a number in a file; powers and products of larger ones have no end in doubles
LEAST_FRICTION = 1e-5  # mjMINMU, a coefficient that MuJoCo takes for any below it
Finding: TypeAlias = tuple[tuple[str | int, ...], str]  # what is wrong between keys: path in the file, and message


def fault(message: str) -> PydanticCustomError:
    """Returns the error by which a validator reports a message of its own."""
    return PydanticCustomError("fault", "{message}", {"message": message})


def _friction(value: float) -> float:
    if 0 < value < LEAST_FRICTION:
        raise fault(f"expected 0, or at least {LEAST_FRICTION:g}, the least that MuJoCo takes, got {value:g}")
    return value


Friction: TypeAlias = Annotated[float, Field(ge=0), AfterValidator(_friction)]


def is_bounded(value: Any) -> bool:
    """Returns whether a raw value of a file is a number, finite and of `LARGEST` in magnitude at most."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) <= LARGEST


def _is_too_large(value: Any) -> bool:
    """Returns whether `_too_large` has anything to say of a value: hardly ever, and this is asked of all."""
    if isinstance(value, float):
        return abs(value) > LARGEST
    if isinstance(value, tuple):
        return any(map(_is_too_large, value))
    return isinstance(value, dict) and any(map(_is_too_large, value.values()))


def _too_large(values: Iterable[tuple[Any, Any]], *loc: str | int) -> Iterator[InitErrorDetails]:
    """Yields the faults of numbers beyond `LARGEST` in values by their keys; sections judge themselves."""
    for key, value in values:
        if isinstance(value, float):
            if abs(value) > LARGEST:
                said = fault(f"expected {LARGEST:g} in magnitude at most, got {value:g}")
                yield InitErrorDetails(type=said, loc=(*loc, key), input=value)
        elif isinstance(value, tuple):
            yield from _too_large(enumerate(value), *loc, key)
        elif isinstance(value, dict):
            yield from _too_large(value.items(), *loc, key)


def values_of(*names: str) -> BeforeValidator:
    """Returns the validator that says by name which values a list of another length ought to have."""

    def judge(value: Any) -> Any:
        if isinstance(value, (list, tuple)) and len(value) != len(names):
            raise fault(f"expected {len(names)} values ({', '.join(names)}), got {len(value)}")
        return value

    return BeforeValidator(judge)


def title_of(name: str) -> str:
    """Returns what documents call a section of a class name: `PayloadSection` is the section Payload."""
    return name.removesuffix("Section") or name


class Section(BaseModel):
    """A mapping of the file: frozen, no unknown keys, no conversion between types, numbers of `LARGEST` at most."""

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        strict=True,
        allow_inf_nan=False,
        hide_input_in_errors=True,
        model_title_generator=lambda section: title_of(section.__name__),
    )

    @model_validator(mode="wrap")
    @classmethod
    def _speak_of_keys(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Says of unknown and missing keys what only the section knows: its other keys and what they mean."""
        try:
            section = handler(data)
        except ValidationError as error:
            problems = [cls._detail(problem) for problem in error.errors(include_url=False)]
            raise ValidationError.from_exception_data(error.title, problems, hide_input=True) from None
        if any(map(_is_too_large, section.__dict__.values())):
            large = list(_too_large(section.__dict__.items()))
            raise ValidationError.from_exception_data(cls.__name__, large, hide_input=True)
        return section

    @classmethod
    def _detail(cls, problem: ErrorDetails) -> InitErrorDetails:
        loc, kind, context = problem["loc"], problem["type"], problem.get("ctx", {})
        said: str | PydanticCustomError = fault(context["message"]) if kind == "fault" else kind
        if len(loc) == 1 and kind == "extra_forbidden":
            said = fault(f"unknown key; {did_you_mean(str(loc[0]), cls.model_fields)}")
        elif len(loc) == 1 and kind == "missing":
            said = fault(f"required key is missing: {cls.model_fields[str(loc[0])].description}")
        return InitErrorDetails(type=said, loc=loc, input=problem["input"], ctx=context)
