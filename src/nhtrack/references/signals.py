"""The leader's input as two signals, each a number, a formula in t, or a list of segments."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, TypeAlias

import numpy as np
from pydantic import AfterValidator, Discriminator, Field, Tag

from nhtrack.references.contract import InputSection, Reference, ReferenceInputError, Signal
from nhtrack.references.expression import Expression, make_signal
from nhtrack.references.segments import make_segments
from nhtrack.section import Finding, Section, fault

_MOST_ASKED = 20_000  # times of a run that a formula is judged at: 0.1 to 5 s of the CPU, by its length


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


class SignalInput(InputSection):
    """The leader's input as two signals, each a number, a formula in t, or a list of segments."""

    key: ClassVar[str] = "u_x"
    words: ClassVar[str] = "u_x and u_theta"
    u_x: SignalValue = Field(description="forward acceleration [scenario length/time^2]")
    u_theta: SignalValue = Field(description="angular acceleration [rad/scenario time^2]")

    def reference(self) -> Reference:
        """Returns the reference, in scenario units."""
        return Reference(_signal(self.u_x), _signal(self.u_theta))

    @classmethod
    def findings(cls, given: Mapping[str, Any], times: np.ndarray | None) -> Iterator[Finding]:
        """Yields signals that have no finite value at some time; of a long run they are asked at some of its times.

        The run asks at all of them, before its first step.
        """
        for name in ("u_x", "u_theta"):
            signal = _raw_signal(given.get(name))
            try:
                if signal is not None and times is not None:
                    signal(_some(times))
            except ReferenceInputError as error:
                yield (name,), str(error)


def _signal(given: SignalValue) -> Signal:
    if isinstance(given, tuple):
        return make_segments([(segment.until, segment.value) for segment in given])
    return make_signal(given)


def _some(times: np.ndarray) -> np.ndarray:
    """Returns times, at most `_MOST_ASKED` of them, evenly spread, with the first and the last."""
    if len(times) <= _MOST_ASKED:
        return times
    return np.asarray(times[np.linspace(0, len(times) - 1, _MOST_ASKED).astype(int)])


def _raw_signal(value: Any) -> Signal | None:
    """Returns the signal of a raw value of the file, or None where its form is at fault."""
    try:
        if isinstance(value, list):
            return make_segments([(piece.get("until"), piece["value"]) for piece in value])
        return make_signal(value)
    except (ReferenceInputError, TypeError, ValueError, KeyError, AttributeError, OverflowError):
        return None
