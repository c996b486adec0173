"""The section `leader.input`: the leader's accelerations over time."""

from __future__ import annotations

from typing import Annotated, Any, TypeAlias

from pydantic import AfterValidator, BaseModel, Discriminator, Field, Tag

from nhtrack.references import Expression, Interpolation, ReferenceInputError
from nhtrack.section import Section, fault


def _formula(text: str) -> str:
    try:
        Expression(text)
    except ReferenceInputError as error:
        raise fault(str(error)) from None
    return text


Formula: TypeAlias = Annotated[str, AfterValidator(_formula)]


class Segment(Section):
    """A piece of a piecewise input: `value` from the end of the piece before it until `until`."""

    until: float | None = Field(
        default=None,
        gt=0,
        description="end of the piece [scenario time]; the last piece may leave it out and hold for ever",
    )
    value: Annotated[float, Tag("<number>")] | Annotated[Formula, Tag("<formula>")] = Field(
        description="acceleration during the piece: a number or a formula in t, the time of the scenario",
        discriminator=Discriminator(lambda value: "<formula>" if isinstance(value, str) else "<number>"),
    )


def _increasing(segments: tuple[Segment, ...]) -> tuple[Segment, ...]:
    before = 0.0
    for i, segment in enumerate(segments):
        if segment.until is None:
            if i + 1 < len(segments):
                raise fault(f"segment {i + 1} of {len(segments)} needs `until`: only the last one may go without")
        elif segment.until <= before:
            raise fault(f"segments must end later and later: {segment.until:g} comes after {before:g}")
        else:
            before = segment.until
    return segments


def _signal_form(value: Any) -> str:
    if isinstance(value, str):
        return "<formula>"
    return "<segments>" if isinstance(value, (list, tuple)) else "<signal>"


SignalValue: TypeAlias = Annotated[
    Annotated[float, Tag("<signal>")]
    | Annotated[Formula, Tag("<formula>")]
    | Annotated[tuple[Segment, ...], Field(strict=False, min_length=1), AfterValidator(_increasing), Tag("<segments>")],
    Discriminator(_signal_form),
]


class SignalInput(Section):
    """The leader's input as two signals, each a number, a formula in t, or a list of segments."""

    u_x: SignalValue = Field(description="forward acceleration [scenario length/time^2]")
    u_theta: SignalValue = Field(description="angular acceleration [rad/scenario time^2]")


class CsvInput(Section):
    """The leader's input from a file; loading turns it into a table, so a recording carries the numbers."""

    csv: str = Field(
        min_length=1,
        description="CSV file with the columns t, u_x, u_theta named in its first line, found relative to the scenario",
    )
    interpolation: Interpolation = Field(
        default="previous", description="hold each row until the next, or join rows by lines"
    )


class Samples(Section):
    """Columns of equal length."""

    t: Annotated[tuple[float, ...], Field(strict=False, min_length=1)] = Field(
        description="increasing times [scenario time]"
    )
    u_x: Annotated[tuple[float, ...], Field(strict=False)] = Field(
        description="forward accelerations [scenario length/time^2]"
    )
    u_theta: Annotated[tuple[float, ...], Field(strict=False)] = Field(
        description="angular accelerations [rad/scenario time^2]"
    )


class TableInput(Section):
    """The leader's input as samples in the file itself."""

    table: Samples = Field(description="the samples")
    interpolation: Interpolation = Field(
        default="previous", description="hold each sample until the next, or join them by lines"
    )


def _input_form(value: Any) -> str:
    keys = value if isinstance(value, dict) else vars(value) if isinstance(value, BaseModel) else ()
    return "<csv>" if "csv" in keys else "<table>" if "table" in keys else "<signals>"


Input: TypeAlias = Annotated[
    Annotated[SignalInput, Tag("<signals>")]
    | Annotated[CsvInput, Tag("<csv>")]
    | Annotated[TableInput, Tag("<table>")],
    Discriminator(_input_form),
]
