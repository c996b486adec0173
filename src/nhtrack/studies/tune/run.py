"""Search of a law's gains on the ideal model: a Sobol sequence over all of them, then around the best.

The search works on the logarithms of the gains. The first half of the budget is spread over the whole box by a
Sobol sequence. Then, generation by generation, a normal distribution is fitted to the best candidates so far and
sampled, again by a Sobol sequence (the cross-entropy method). A generation is one batched rollout, at a control
rate that is lowered where the scenario's own would ask for more periods than the search needs; the best few are
run again at the scenario's own rate, and those figures decide.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.special import ndtri

from nhtrack.analysis.motion import robots_with_wheels
from nhtrack.arrays import Array
from nhtrack.config.law_sections import LawSection, powers
from nhtrack.config.schema import Scenario
from nhtrack.errors import NhtrackError
from nhtrack.experiment.build import build, make_law
from nhtrack.experiment.compile import compile_once
from nhtrack.experiment.loop import Progress
from nhtrack.presentation.numbers import counted
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.settling import settling_limits
from nhtrack.similarity import Similarity
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.studies.feasibility.run import reduced_plant, with_time
from nhtrack.studies.tune.objective import Figures, Objective, RunFigures, figures_of

SEARCH_PERIODS = 2000  # control periods of a search run, at most
_ROBOT_PERIODS = 2_500_000  # robots x candidates x periods in one batch: some 400 MB
_GENERATIONS = 4  # after the first
_ELITE = 0.125  # share of all candidates that the next generation is drawn around
_WIDEN = 0.05  # smallest spread of a generation, in e-folds of a gain
_FINALISTS = 16
_DOUBLINGS = 9  # of a sequence of which only some candidates are allowed
_DIGITS = 3  # of a gain


class TuningError(NhtrackError):
    """A law or a budget that cannot be searched."""


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


@dataclass(frozen=True)
class Generation:
    """One batch of a search: how many candidates it had, and the lowest cost found by its end."""

    candidates: int
    best: float


@dataclass(frozen=True)
class Tuning:
    """The outcome of a search.

    Attributes:
        scenario: with the gains found, and with its time scale as a number.
        gains: the gains found, in the scenario's units.
        figures: what they leave, at the scenario's own control rate.
        cost: the objective's value of that.
        gains_before: the gains that the scenario came with.
        figures_before: what those leave.
        cost_before: the objective's value of that; infinite where the robots are lost.
        history: the generations.
        objective: what was wanted.
        seed: of the Sobol sequences.
        below_bound: whether gains were allowed that their law warns of.
    """

    scenario: Scenario
    gains: dict[str, float]
    figures: RunFigures
    cost: float
    gains_before: dict[str, float]
    figures_before: RunFigures
    cost_before: float
    history: tuple[Generation, ...]
    objective: Objective
    seed: int
    below_bound: bool

    @property
    def candidates(self) -> int:
        """How many sets of gains were run."""
        return sum(generation.candidates for generation in self.history)

    @property
    def fitting_time(self) -> float:
        """Time scale down to which the gains found fit wheels and motors, by the run at the scenario's own."""
        return float(self.figures.pace) * self.scenario.similarity.time_scale

    @property
    def account(self) -> str:
        """The search in a line."""
        bound = ", gains below their bounds allowed" if self.below_bound else ""
        searched = f"{counted(self.candidates, 'candidate')} in {counted(len(self.history), 'generation')}"
        return (
            f"objective {self.objective}, {searched}, "
            f"seed {self.seed}{bound}, friction margin {self.scenario.similarity.friction_margin:g}"
        )

    @property
    def leaves(self) -> str:
        """What the gains leave, in a line."""
        late = self.figures
        return (
            f"late error {100 * late.late_position:.2g} % of the path and {late.late_heading:.2g} rad; "
            f"peak friction utilisation {late.utilisation:.2g}, fits down to time scale {self.fitting_time:.3g}"
        )


def tune(
    scenario: Scenario,
    objective: Objective | None = None,
    budget: int = 256,
    seed: int = 0,
    stage: Callable[[str], Progress] | None = None,
    *,
    below_bound: bool = False,
) -> Tuning:
    """Returns the gains of the lowest cost found; never worse than the scenario's own where those were allowed.

    Args:
        scenario: what to tune; `time: auto` is found for its own gains first, and kept.
        objective: what is wanted; the late errors by default.
        budget: how many sets of gains to run, at least 8.
        seed: of the Sobol sequences; the same seed finds the same gains.
        stage: see `nhtrack.studies.run.run.simulate`.
        below_bound: allow gains that their law warns of, such as k <= 2 (1 + ke/kp) or kd < 2 sqrt(kp).

    Raises:
        TuningError: a law without ranges to search, a budget too small, or no candidate that keeps its robots.
        FeasibilityError: `time: auto`, and no time scale fits the scenario's own gains.
    """
    if budget < 8:
        raise TuningError(f"budget: expected at least 8 candidates, got {budget}")
    objective = objective or Objective(late=1.0)
    compile_once(stage)
    scenario = with_time(scenario, stage("time scale") if stage is not None else None)
    box = _Box.of(scenario, seed, below_bound)
    trial = _Trial(scenario, box.names, objective, reduced_plant(scenario))
    report = stage("tuning") if stage is not None else lambda done, total: None
    found, costs, history = _search(trial, box, budget, report)
    order = np.argsort(costs, kind="stable")[:_FINALISTS]
    finalists = np.concatenate([box.start[None], found[order[np.isfinite(costs[order])]]])
    figures, final = trial.run(finalists, own_rate=True)
    allowed = final.copy()
    allowed[0] = final[0] if box.allows(box.start) else np.inf
    best = int(allowed.argmin())
    if not np.isfinite(allowed[best]):
        raise TuningError(f"none of {budget} candidates keeps its robots near their leaders and on their wheels")
    return Tuning(
        scenario=_with_gains(scenario, _by_name(box.names, finalists[best])),
        gains=_by_name(box.names, finalists[best]),
        figures=figures.of(best),
        cost=float(final[best]),
        gains_before=_by_name(box.names, box.start),
        figures_before=figures.of(0),
        cost_before=float(final[0]),
        history=tuple(history),
        objective=objective,
        seed=seed,
        below_bound=below_bound,
    )


def _search(trial: _Trial, box: _Box, budget: int, report: Progress) -> tuple[Array, Array, list[Generation]]:
    """Returns all candidates tried, shape (budget, d), their costs, shape (budget,), and the generations."""
    later = [budget // 2 // _GENERATIONS] * _GENERATIONS if budget >= 8 * _GENERATIONS else []
    first = budget - sum(later)
    found, costs, history = np.empty((0, len(box.names))), np.empty(0), list[Generation]()
    for size in (first, *later):
        if not history:
            candidates = box.spread(size)
        else:
            elite = found[np.argsort(costs, kind="stable")[: max(len(box.names) + 2, round(_ELITE * len(found)))]]
            candidates = box.around(elite, size)

        def share_done(share: float, done: int = len(found), size: int = size) -> None:
            report(round(done + share * size), budget)

        _, cost = trial.run(candidates, share_done)
        found, costs = np.concatenate([found, candidates]), np.concatenate([costs, cost])
        history.append(Generation(size, float(costs.min())))
    return found, costs, history


class _Box:
    """The gains that are searched, and where candidates come from."""

    def __init__(self, scenario: Scenario, names: tuple[str, ...], limits: Array, seed: int, below_bound: bool) -> None:
        self.names, self._low, self._high = names, np.log(limits[:, 0]), np.log(limits[:, 1])
        self.start = np.array([getattr(scenario.law, name) for name in names])
        self._law, self._below_bound = scenario.law, below_bound
        self._random = np.random.default_rng(seed)

    @classmethod
    def of(cls, scenario: Scenario, seed: int, below_bound: bool) -> _Box:
        """Returns the box of a scenario's law."""
        ranges, size = ranges_of(scenario.law), _size(scenario)
        if not ranges:
            gain = 'Annotated[float, Gain("1/T", "...", search=(6, 1000))]'
            raise TuningError(f"law {scenario.law.name!r} has no gain with a range to search, such as {gain}")
        limits = [gain.limits(scenario.duration, size) for gain in ranges.values()]
        return cls(scenario, tuple(ranges), np.array(limits), seed, below_bound)

    def allows(self, gains: Array) -> bool:
        """Returns whether a law with these gains has nothing to warn of, or need not care."""
        if self._below_bound:
            return True
        law = self._law.model_copy(update=_by_name(self.names, gains))
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


def _size(scenario: Scenario) -> float:
    """Returns the size of an experiment, in scenario units, see `Range`; 1 where nothing moves or is apart."""
    experiment = build(scenario)
    start = experiment.start
    gained = experiment.inputs[:, 0] * experiment.dt
    speed = start.xi[0, 0] + np.cumsum(gained) - gained / 2  # at the middle of each period
    path = float(np.abs(speed).sum() * experiment.dt)
    apart = float(np.hypot(*(start.g[:, :2] - start.g[0, :2]).T).max())
    return max(path, apart) / experiment.similarity.length or 1.0


class _Trial:
    """Runs sets of gains side by side and says what they cost."""

    def __init__(self, scenario: Scenario, names: tuple[str, ...], objective: Objective, drive: DiffDrive) -> None:
        self._scenario, self._names, self._objective, self._drive = scenario, names, objective, drive
        slower = math.ceil(scenario.periods / SEARCH_PERIODS)
        self._search = scenario.model_copy(update={"control_rate": scenario.control_rate / slower})

    def run(
        self, candidates: Array, report: Callable[[float], None] | None = None, *, own_rate: bool = False
    ) -> tuple[Figures, Array]:
        """Returns the figures of candidates (b, d) and their costs, each of shape (b,)."""
        scenario = self._scenario if own_rate else self._search
        together = max(1, _ROBOT_PERIODS // (scenario.periods * (1 + len(scenario.followers))))
        parts = []
        for begin in range(0, len(candidates), together):
            batch = candidates[begin : begin + together]

            def progress(done: int, total: int, begin: int = begin, size: int = len(batch)) -> None:
                if report is not None:
                    report((begin + size * done / total) / len(candidates))

            parts.append(self._figures(scenario, batch, progress))
        figures = Figures(*(np.concatenate(column) for column in zip(*parts, strict=True)))
        return figures, self._objective.cost(figures)

    def _figures(self, scenario: Scenario, batch: Array, progress: Progress) -> Figures:
        """Returns the figures of one batched rollout; NaN for the candidates that lose their robots."""
        experiment = build(_with_gains(scenario, {name: batch[:, i, None] for i, name in enumerate(self._names)}))
        simulation = IdealSimulation(
            experiment.network.names, None, experiment.dt, keep_going=True, size=experiment.size
        )
        run = experiment.rollout(simulation, progress, batch=(len(batch),))
        run.require_whole()  # a robot that runs away is a candidate that is lost, and no failure
        bodies = list(robots_with_wheels(experiment).values())
        margin = scenario.similarity.friction_margin
        limits = settling_limits(experiment.similarity.length)
        figures = figures_of(run, limits, bodies, self._drive, experiment.scene.ground, margin)
        return Figures(*(np.where(simulation.lost, np.nan, values) for values in figures))


def _with_gains(scenario: Scenario, gains: Mapping[str, Array] | Mapping[str, float]) -> Scenario:
    """Returns the scenario with other gains: numbers, or arrays (b, 1) that make its law one of b laws."""
    return scenario.model_copy(update={"law": scenario.law.model_copy(update=dict(gains))})


def _by_name(names: tuple[str, ...], gains: Array) -> dict[str, float]:
    return {name: float(gain) for name, gain in zip(names, gains, strict=True)}


def _rounded(gains: Array) -> Array:
    """Returns gains to three significant digits, as they are written into a scenario."""
    return np.asarray(np.vectorize(lambda gain: float(f"{gain:.{_DIGITS}g}"), otypes=[float])(gains))
