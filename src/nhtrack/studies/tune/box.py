"""The gains that a search tries: where each is looked for, and the candidates drawn there."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.special import ndtri

from nhtrack.arrays import Array
from nhtrack.config.law_sections import LawSection, powers
from nhtrack.config.scenario import Scenario
from nhtrack.errors import NhtrackError
from nhtrack.experiment.build import build, make_law
from nhtrack.similarity import Similarity
from nhtrack.simulation.robot_models import RobotModels

_WIDEN = 0.05  # smallest spread of a generation, in e-folds of a gain
_DOUBLINGS = 9  # of a sequence of which only some candidates are allowed
_DIGITS = 3  # of a gain


class TuningError(NhtrackError):
    """A law or a budget that cannot be searched."""


LEAST_BUDGET = 8  # sets of gains


def require_budget(budget: int) -> None:
    """Raises where a budget is too small.

    Raises:
        TuningError: it is.
    """
    if budget < LEAST_BUDGET:
        raise TuningError(f"budget: expected at least {LEAST_BUDGET} candidates, got {budget}")


class Range(NamedTuple):
    """Where a gain is looked for: low and high [1], in units of duration^-power size^length.

    The size is the leader's path or, if that is longer, the largest distance to it at the start.
    """

    low: float
    high: float
    power: int
    length: int = 0

    def limits(self, duration: float, size: float) -> tuple[float, float]:
        """Returns the range of a scenario's gain, in the scenario's units."""
        unit = size**self.length / duration**self.power
        return self.low * unit, self.high * unit


def ranges_of(law: LawSection) -> dict[str, Range]:
    """Returns where the gains of a law are looked for; those that name no range are left as they are."""
    found = {}
    for name, gain in law.kind.described.items():
        if gain.search is not None:
            length, time = powers(gain.unit)
            found[name] = Range(*gain.search, -time, length)
    return found


class SearchBox:
    """The gains that are searched, and where candidates come from."""

    def __init__(self, scenario: Scenario, names: tuple[str, ...], limits: Array, seed: int, below_bound: bool) -> None:
        self.names, self._low, self._high = names, np.log(limits[:, 0]), np.log(limits[:, 1])
        self.start = np.array([getattr(scenario.law, name) for name in names])
        self._law, self._below_bound = scenario.law, below_bound
        self._random = np.random.default_rng(seed)

    @classmethod
    def of(
        cls, scenario: Scenario, seed: int, below_bound: bool, robot: RobotModels | None = None
    ) -> SearchBox:
        """Returns the box of a scenario's law; its robot where it has been read already."""
        ranges, size = ranges_of(scenario.law), _size(scenario, robot)
        if not ranges:
            gain = 'Annotated[float, Gain("1/T", "...", search=(6, 1000))]'
            raise TuningError(f"law {scenario.law.name!r} has no gain with a range to search, such as {gain}")
        limits = [gain.limits(scenario.duration, size) for gain in ranges.values()]
        return cls(scenario, tuple(ranges), np.array(limits), seed, below_bound)

    def allows(self, gains: Array) -> bool:
        """Returns whether a law with these gains has nothing to warn of, or need not care."""
        if self._below_bound:
            return True
        law = self._law.model_copy(update=by_name(self.names, gains))
        return not make_law(law, Similarity()).warnings()

    def spread(self, count: int) -> Array:
        """Returns candidates all over the box, the scenario's own gains first where they are allowed."""
        own = self.start[None] if self.allows(self.start) else self.start[:0].reshape(0, len(self.names))
        rest = self._draw(count - len(own), lambda unit: self._low + (self._high - self._low) * unit)
        return np.concatenate([own, rest])

    def around(self, elite: Array, count: int) -> Array:
        """Returns candidates drawn from the normal distribution of the elite, in logarithms, kept in the box."""
        logs = np.log(np.maximum(elite, np.exp(self._low)))
        spread = np.cov(logs, rowvar=False) + _WIDEN**2 * np.eye(len(self.names))
        root, mean = np.linalg.cholesky(spread), logs.mean(axis=0)
        return self._draw(count, lambda unit: mean + ndtri(np.clip(unit, 1e-9, 1 - 1e-9)) @ root.T)

    def _draw(self, count: int, place: Callable[[Array], Array]) -> Array:
        """Returns the first candidates of the sequence that are allowed, shape (count, d)."""
        from scipy.stats import qmc  # only here: it takes a second to import

        sobol, kept = qmc.Sobol(len(self.names), scramble=True, rng=self._random), list[Array]()
        power = math.ceil(math.log2(max(count, 2)))
        for doubling in range(_DOUBLINGS):
            unit = sobol.random_base2(power + max(0, doubling - 1))  # as many as were drawn before
            drawn = np.exp(np.clip(place(unit), self._low, self._high))
            kept += [gains for gains in _rounded(drawn) if self.allows(gains)]
            if len(kept) >= count:
                return np.array(kept[:count]).reshape(count, len(self.names))
        raise TuningError("hardly any gains in the ranges keep the law's bounds; allow gains below them")


def _size(scenario: Scenario, robot: RobotModels | None) -> float:
    """Returns the size of an experiment, in scenario units, see `Range`; 1 where nothing moves or is apart."""
    experiment = build(scenario, robot)
    start = experiment.start
    gained = experiment.inputs[:, 0] * experiment.dt
    speed = start.xi[0, 0] + np.cumsum(gained) - gained / 2  # at the middle of each period
    path = float(np.abs(speed).sum() * experiment.dt)
    apart = float(np.hypot(*(start.g[:, :2] - start.g[0, :2]).T).max())
    return max(path, apart) / experiment.similarity.length or 1.0


def by_name(names: tuple[str, ...], gains: Array) -> dict[str, float]:
    """Returns gains, shape (d,), by their names."""
    return {name: float(gain) for name, gain in zip(names, gains, strict=True)}


def _rounded(gains: Array) -> Array:
    """Returns gains to three significant digits, as they are written into a scenario."""
    return np.asarray(np.vectorize(lambda gain: float(f"{gain:.{_DIGITS}g}"), otypes=[float])(gains))
