"""What a scenario asks of its robots."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from nhtrack.analysis.demand import PeakDemand
from nhtrack.analysis.speedup import Binding
from nhtrack.config.scenario import Scenario
from nhtrack.presentation.numbers import cell, seconds
from nhtrack.views import drawn_by


@dataclass(frozen=True, repr=False)
class Feasibility:
    """What a scenario asks of its robots at its time scale, and the time scale that fits.

    Attributes:
        scenario: with its time scale as a number.
        demands: see `demands`.
        bindings: see `bindings`, with the scenario's margin.
        fitting_time: smallest time scale that fits, or None where none does.
        obstacle: why none does, or None.
    """

    scenario: Scenario
    demands: tuple[PeakDemand, ...]
    bindings: tuple[Binding, ...]
    fitting_time: float | None
    obstacle: str | None = None

    @property
    def fits(self) -> bool:
        """Whether the scenario fits as it is, with its friction margin."""
        return all(binding.factor >= 1 for binding in self.bindings)

    @property
    def table(self) -> list[dict[str, Any]]:
        """Rows of plain values for JSON; what is not finite becomes None.

        After a robot's demands comes its `time_scale`: the scenario's as value, the smallest that fits the robot as
        limit, when and on which wheel it is bound.
        """
        present = self.scenario.similarity.time_scale
        rows = [vars(demand) for demand in self.demands]
        for binding in self.bindings:
            limit = present / binding.factor if binding.factor > 0 else math.inf
            place = binding.time, binding.wheel
            rows.append(vars(PeakDemand(binding.robot, "time_scale", present, "1", limit, limit / present, *place)))
        order = list(dict.fromkeys(row["robot"] for row in rows))
        rows.sort(key=lambda row: order.index(row["robot"]))
        return [{key: _finite(value) for key, value in row.items()} for row in rows]

    @property
    def verdict(self) -> str:
        """What the figures say, in a sentence."""
        time, margin = self.scenario.similarity.time_scale, self.scenario.similarity.friction_margin
        if self.fitting_time is None:
            return f"No time scale fits: {self.obstacle}."
        smallest = f"the smallest time scale that fits is {self.fitting_time:g}"
        if self.fits:
            return f"Fits at similarity.time {time:g}, with friction used to {margin:.3g} at most; {smallest}."
        worst = max(self.demands, key=self._used)
        place = f"{worst.robot}'s {worst.wheel} wheel at {seconds(worst.time)}"
        what = worst.quantity.replace("_", " ")
        used, share = "of which there is none", self._used(worst)
        if math.isfinite(share):
            used = f"{cell(share, '%')} of what may be used"
        return f"Does not fit at similarity.time {time:g}: {what} of {place}, {used}; {smallest}."

    def _used(self, demand: PeakDemand) -> float:
        """Returns the share of what a demand may use, which of friction is its margin."""
        margin = self.scenario.similarity.friction_margin if demand.quantity == "friction_utilisation" else 1.0
        return (demand.share or 0.0) / margin

    def __repr__(self) -> str:
        """Returns a one-line account."""
        return f"Feasibility({self.scenario.name!r}: {self.verdict})"

    def _repr_html_(self) -> str:
        """Returns what a notebook shows: the verdict, and the table."""
        return drawn_by("nhtrack.studies.feasibility.tables.feasibility_html", self)


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
