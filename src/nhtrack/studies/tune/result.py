"""What a search of gains found."""

from __future__ import annotations

from dataclasses import dataclass

from nhtrack.config.scenario import Scenario
from nhtrack.presentation.numbers import counted
from nhtrack.studies.tune.objective import Objective, RunFigures
from nhtrack.views import drawn_by


@dataclass(frozen=True)
class Generation:
    """One batch of a search: how many candidates it had, and the lowest cost found by its end."""

    candidates: int
    best: float


@dataclass(frozen=True, repr=False)
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

    @property
    def law_line(self) -> str:
        """The law with the gains found, as a scenario file has it."""
        gains = ", ".join(f"{name}: {gain:g}" for name, gain in self.gains.items())
        return f"law: {{name: {self.scenario.law.name}, {gains}}}"

    def __repr__(self) -> str:
        """Returns a one-line account of the search."""
        gains = ", ".join(f"{name}={gain:g}" for name, gain in self.gains.items())
        return f"Tuning({self.scenario.law.name!r}, {gains}; cost {self.cost_before:.3g} -> {self.cost:.3g})"

    def _repr_html_(self) -> str:
        """Returns what a notebook shows: gains and what they leave, before and after."""
        return drawn_by("nhtrack.studies.tune.tables.tuning_html", self)
