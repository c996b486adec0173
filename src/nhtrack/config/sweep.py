"""What a sweep file may say: a scenario, the keys of it that vary and how, and what is asked of every run."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np
from pydantic import AfterValidator, Discriminator, Field, Tag

from nhtrack.arrays import Array
from nhtrack.config.changes import value_text
from nhtrack.config.grid import Range, filled, words_of
from nhtrack.config.tree import parse_path
from nhtrack.config.values import RunName
from nhtrack.errors import did_you_mean
from nhtrack.references import VOCABULARY, Expression, ReferenceInputError
from nhtrack.section import Section, fault, values_of

MOST_RUNS = 2_000_000
# What is asked of a run, as a run's summary has it, of its worst robot; what each is.
METRICS: Mapping[str, str] = {
    "settled": "share of the followers that settled [1]",
    "settling_time": "when the last follower settled [s]; not known where one never did",
    "initial_position_error": "at the start [m]",
    "final_position_error": "at the end [m]",
    "final_heading_error": "at the end [rad]",
    "late_position_error": "largest distance from its place over the last 15 % of the run [m]",
    "late_heading_error": "largest angle over the last 15 % of the run [rad]",
    "path_length": "the longest way of a robot [m]",
    "gap_position_rms": "distance from the ideal twin, as a root of mean squares [m]; on wheels",
    "gap_position_max": "largest distance from the ideal twin [m]; on wheels",
    "gap_heading_rms": "angle from the ideal twin, as a root of mean squares [rad]; on wheels",
    "gap_heading_max": "largest angle from the ideal twin [rad]; on wheels",
    "peak_utilisation": "largest share of friction used, on the ideal model predicted [1]",
    "peak_lateral_slip": "largest speed of a wheel aside [m/s]; on wheels",
    "torque_saturation_share": "share of the time in which a motor was at its limit [1]",
    "effort_x": "root of the mean square of u_x [m/s^2]",
    "effort_theta": "root of the mean square of u_theta [rad/s^2]",
    "switches": "control periods in which a mode of the law changed [1]",
}
ON_WHEELS = ("gap_position_rms", "gap_position_max", "gap_heading_rms", "gap_heading_max", "peak_lateral_slip")
COLUMNS = ("run", "point", "repeat", "seed", "key", "outcome", "reason")  # of the table, beside axes and metrics


Bounds: TypeAlias = Annotated[tuple[float, float], Field(strict=False), values_of("least", "largest")]
Pair: TypeAlias = Annotated[tuple[str, str], Field(strict=False), values_of("one", "other")]
MeanAndDeviation: TypeAlias = Annotated[tuple[float, float], Field(strict=False), values_of("mean", "deviation")]


class Choices(Section):
    """Values with names, for what is more than a number: laws, robots, sections."""

    choices: Annotated[dict[str, Any], Field(min_length=1)] = Field(
        description="values by the names that the table calls them by"
    )


class Spread(Section):
    """Numbers that are drawn."""

    def at(self, u: Array) -> Array:
        """Returns the quantiles of shares u in [0, 1), shape (n,)."""
        raise NotImplementedError


class Uniform(Spread):
    """Numbers drawn evenly between two."""

    uniform: Bounds = Field(description="the least and the largest")

    def at(self, u: Array) -> Array:
        """Returns the quantiles of shares u in [0, 1), shape (n,)."""
        low, high = self.uniform
        return low + u * (high - low)


class LogUniform(Spread):
    """Numbers whose logarithms are drawn evenly."""

    log_uniform: Bounds = Field(
        description="the least, above 0, and the largest"
    )

    def at(self, u: Array) -> Array:
        """Returns the quantiles of shares u in [0, 1), shape (n,)."""
        low, high = np.log(self.log_uniform)
        return np.asarray(np.exp(low + u * (high - low)))


class Normal(Spread):
    """Numbers of a normal distribution."""

    normal: MeanAndDeviation = Field(description="mean and standard deviation")

    def at(self, u: Array) -> Array:
        """Returns the quantiles of shares u in [0, 1), shape (n,); of 0 the one of half a millionth."""
        from scipy.special import ndtri  # only here: it takes a while to import

        mean, deviation = self.normal
        return np.asarray(mean + deviation * ndtri(np.clip(u, 5e-7, 1 - 5e-7)))


def _rises(spread: Any) -> Any:
    low, high = spread.log_uniform if isinstance(spread, LogUniform) else spread.uniform
    if not low < high:
        raise fault(f"expected the least before the largest, got {low:g}, {high:g}")
    if isinstance(spread, LogUniform) and low <= 0:
        raise fault(f"numbers whose logarithms are drawn are above 0, got {low:g}")
    return spread


def _has_width(spread: Normal) -> Normal:
    if spread.normal[1] <= 0:
        raise fault(f"expected a standard deviation above 0, got {spread.normal[1]:g}")
    return spread


_FORMS = ("choices", "uniform", "log_uniform", "normal")


def _form(value: Any) -> str:
    if isinstance(value, (list, tuple)):
        return "<values>"
    keys = value if isinstance(value, Mapping) else vars(value) if isinstance(value, Section) else ()
    return f"<{next((form for form in _FORMS if form in keys), 'range')}>"


Axis: TypeAlias = Annotated[
    Annotated[tuple[Any, ...], Field(strict=False, min_length=1), Tag("<values>")]
    | Annotated[Range, Tag("<range>")]
    | Annotated[Choices, Tag("<choices>")]
    | Annotated[Uniform, AfterValidator(_rises), Tag("<uniform>")]
    | Annotated[LogUniform, AfterValidator(_rises), Tag("<log_uniform>")]
    | Annotated[Normal, AfterValidator(_has_width), Tag("<normal>")],
    Discriminator(_form),
]


class Sample(Section):
    """Points drawn in the space of all axes, in place of a grid."""

    method: Literal["sobol", "latin_hypercube", "random", "saltelli"] = Field(
        default="sobol",
        description="`sobol`: a scrambled Sobol sequence, even for a power of two of points; `latin_hypercube`: each "
        "axis covered evenly; `random`: each point by itself; `saltelli`: what Sobol indices are reckoned from",
    )
    count: int = Field(
        ge=1, le=MOST_RUNS, description="how many points; of `saltelli` groups of (axes + 2) points each [1]"
    )
    seed: int = Field(default=0, ge=0, description="seed of the draw [1]")

    def points(self, axes: int) -> int:
        """Returns how many points are drawn in the space of so many axes."""
        return self.count * group_size(self.method, axes)


def group_size(method: str, axes: int) -> int:
    """Returns how many points are drawn together: for Sobol indices two of the cube, and one an axis between them."""
    return axes + 2 if method == "saltelli" else 1


def _path(text: str) -> str:
    try:
        parse_path(text)
    except ValueError as error:
        raise fault(str(error)) from None
    return text


def _metric(name: str) -> str:
    if name not in METRICS:
        raise fault(f"no metric {name!r}; {did_you_mean(name, tuple(METRICS))}")
    return name


def _expression_name(name: str) -> str:
    if name in METRICS or name in COLUMNS:
        raise fault(f"{name!r} is a column of the table already; choose another name")
    return name


def _expression(formula: str) -> str:
    unknown = next((word for word in words_of(formula) if word not in (*METRICS, *VOCABULARY) or word == "t"), None)
    if unknown is not None:
        raise fault(f"unknown name {unknown!r}; {did_you_mean(unknown, (*METRICS, *VOCABULARY[1:]))}")
    try:
        Expression(str(filled(formula, dict.fromkeys(METRICS, 1.0))))
    except ReferenceInputError as error:
        raise fault(str(error)) from None
    return formula


Metric: TypeAlias = Annotated[str, AfterValidator(_metric)]


class Sweep(Section):
    """One scenario run many times, with other values of some of its keys."""

    name: RunName = Field(description="names the sweep and its results folder")
    description: str = Field(default="", description="one line for people, shown by `nhtrack list`")
    base: str = Field(min_length=1, description="the scenario: a bundled name, or a file relative to the sweep's")
    set: dict[Annotated[str, AfterValidator(_path)], Any] = Field(
        default={}, description="changes of the scenario that are the same in every run, by dotted keys"
    )
    axes: Annotated[dict[Annotated[str, AfterValidator(_path)], Axis], Field(min_length=1)] = Field(
        description="keys of the scenario that vary, dotted as in `law.k` or `followers[0].start.pose[0]`, each with "
        "its values"
    )
    sample: Sample | None = Field(
        default=None, description="how points are drawn; null runs every combination of all values"
    )
    repeats: int = Field(
        default=1, ge=1, le=MOST_RUNS, description="runs of every point: the k-th has the scenario's seed + k [1]"
    )
    metrics: Annotated[tuple[Metric, ...], Field(strict=False, min_length=1)] | None = Field(
        default=None, description="columns of the table; null has all that the back end knows"
    )
    expressions: dict[
        Annotated[str, AfterValidator(_expression_name)], Annotated[str, AfterValidator(_expression)]
    ] = Field(default={}, description="columns of one's own: formulas of metrics")
    pareto: Annotated[tuple[Pair, ...], Field(strict=False)] = Field(
        default=(),
        description="pairs of columns, metrics or expressions, of which runs are drawn that are best in one for what "
        "they have of the other; the smaller the better, so that one to be large is an expression with a minus",
    )

    @property
    def points(self) -> int:
        """How many points there are."""
        if self.sample is not None:
            return self.sample.points(len(self.axes))
        return math.prod(len(self.values(key)) for key in self.axes)

    @property
    def runs(self) -> int:
        """How many runs there are."""
        return self.points * self.repeats

    def values(self, key: str) -> tuple[Any, ...]:
        """Returns the values of an axis that are not drawn; none of one that is."""
        axis = self.axes[key]
        if isinstance(axis, Spread):
            return ()
        return tuple(axis.choices.values()) if isinstance(axis, Choices) else _plain(axis)

    def labels(self, key: str) -> tuple[Any, ...]:
        """Returns what the table calls the values of an axis: names, numbers, or texts."""
        axis = self.axes[key]
        if isinstance(axis, Choices):
            return tuple(axis.choices)
        values = _plain(axis)
        simple = all(isinstance(value, (int, float)) and not isinstance(value, bool) for value in values)
        return values if simple else tuple(value_text(value) for value in values)

    @property
    def base_changes(self) -> list[str]:
        """What is changed in the scenario of every run, as on the command line."""
        return [f"{key}={value_text(value)}" for key, value in self.set.items()]


def _plain(axis: Any) -> tuple[Any, ...]:
    return axis if isinstance(axis, tuple) else tuple(axis.values())
