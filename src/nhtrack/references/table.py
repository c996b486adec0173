"""The leader's input as samples, held or joined by lines."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import inf
from typing import Annotated, Any, ClassVar, Literal, TypeAlias

import numpy as np
from pydantic import Field

from nhtrack.references.contract import InputSection, Reference, ReferenceInputError
from nhtrack.section import Finding, Section, is_bounded

Interpolation: TypeAlias = Literal["previous", "linear"]
LATE_START = "the first row is at t = {:g}; a table starts at 0 or before"


@dataclass(frozen=True)
class Table:
    """Samples of a signal, held or joined by lines; constant before the first.

    The last is held for ever where samples are held; where lines join them, the signal is 0 after it.

    Attributes:
        times: strictly increasing times, shape (n,).
        values: values at them, shape (n,).
        interpolation: `previous` holds each sample until the next, `linear` joins them.

    Raises:
        ReferenceInputError: no rows, times that do not increase, or a number that is not finite.
    """

    times: tuple[float, ...]
    values: tuple[float, ...]
    interpolation: Interpolation = "previous"

    def __post_init__(self) -> None:
        times, values = np.asarray(self.times), np.asarray(self.values)
        if times.size == 0 or times.shape != values.shape:
            raise ReferenceInputError(
                f"a table needs as many times as values, got {times.size} and {values.size}"
            )
        if not (np.isfinite(times).all() and np.isfinite(values).all()):
            raise ReferenceInputError("a table may hold finite numbers only")
        if times.size > 1 and (late := np.flatnonzero(np.diff(times) <= 0)).size:
            row = int(late[0])
            raise ReferenceInputError(
                f"the times of a table must increase, got {times[row]:g} before {times[row + 1]:g}"
            )

    @property
    def end(self) -> float:
        """The time after which it is 0."""
        return self.times[-1] if self.interpolation == "linear" else inf

    def __call__(self, t: np.ndarray) -> np.ndarray:
        """Returns the values at the times `t`, both of shape (T,)."""
        times, values = np.asarray(self.times), np.asarray(self.values)
        if self.interpolation == "linear":
            return np.asarray(np.interp(t, times, values, right=0.0), dtype=np.float64)
        starts = times - 1e-12 * np.abs(
            times
        )  # as in `Segments`: an instant a rounding early counts as on time
        index = np.searchsorted(starts, t, side="right") - 1
        return np.asarray(values[np.clip(index, 0, None)], dtype=np.float64)


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


class TableInput(InputSection):
    """The leader's input as samples in the file itself."""

    key: ClassVar[str] = "table"
    words: ClassVar[str] = "a table"
    table: Samples = Field(description="the samples")
    interpolation: Interpolation = Field(
        default="previous",
        description="hold each sample until the next, the last for ever, or join them by lines, with 0 after the last",
    )

    def reference(self) -> Reference:
        """Returns the reference, in scenario units."""
        u_x, u_theta = (Table(self.table.t, u, self.interpolation) for u in (self.table.u_x, self.table.u_theta))
        return Reference(u_x, u_theta)

    @classmethod
    def findings(cls, given: Mapping[str, Any], times: np.ndarray | None) -> Iterator[Finding]:
        """Yields columns that do not match, times out of order, rows missing at the beginning."""
        table = given["table"]
        columns: list[Any] = [table.get(name) for name in ("t", "u_x", "u_theta")] if isinstance(table, Mapping) else []
        if not columns or not all(isinstance(c, list) and c and all(map(is_bounded, c)) for c in columns):
            return  # the section's own fault, told by its model
        t, *accelerations = columns
        try:
            for values in accelerations:
                Table(tuple(t), tuple(values))
        except ReferenceInputError as error:
            yield ("table",), str(error)
            return
        if t[0] > 0:
            yield ("table",), LATE_START.format(t[0])
